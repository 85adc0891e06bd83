"""Fig. 3: thresholded frames, and the place of the last block in them."""

import itertools

import numpy as np

from beltrepro.replication.camera.scene import Scene
from beltrepro.replication.camera.track import white
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.experiment import filmed

FIGURE = Figure(uses=("belt_028", "belt_028_film", "belt_028_track"), number="3")

STRIPS = 24
SHOWN_S = 10.0
_NEAR_S = 1e-3  # instants of a table and of its film


@style.styled
def draw(data):
    """Left: frames about the fastest slip of the first seconds; right: x_5(t)."""
    panels.require(data, FIGURE)
    track = data["belt_028_track"]
    figure = style.page(3.4)
    filmed.mark(figure)
    left, right = figure.subplots(1, 2, width_ratios=(1.7, 1))
    if track.time_s.size < STRIPS:
        for axes in (left, right):
            panels.note(axes, f"the block is found in {track.time_s.size} frames only")
        return figure
    begin = _about_fastest_slip(track)
    chosen = slice(begin, begin + STRIPS)
    first, last = track.time_s[chosen][[0, -1]]
    frames = itertools.takewhile(lambda f: f.time_s < last + _NEAR_S, data["belt_028_film"]())
    pictures = [frame.picture for frame in frames if frame.time_s > first - _NEAR_S][:STRIPS]

    panels.letter(left, "a")
    panels.letter(right, "b")
    time, position = track.time_s[chosen], 100 * track.x_m[chosen]
    _draw_strips(left, pictures, track, position.mean() / 100)
    left.plot(position, np.arange(len(time)) + 0.5, ".", color=style.VERMILION, markersize=3.5)
    left.set_yticks(np.arange(0, len(time), 4) + 0.5, [f"{instant:.2f}" for instant in time[::4]])
    left.set(xlabel=filmed.LENGTH, ylabel=filmed.SECONDS)
    panels.remark(left, filmed.speed(data["belt_028"]))

    shown = track.time_s <= SHOWN_S
    panels.trace(right, track.time_s[shown], 100 * track.x_m[shown], ylabel=filmed.LENGTH)
    right.axvspan(time[0], time[-1], color=style.ORANGE, alpha=0.35, linewidth=0)
    right.set_xlabel(filmed.SECONDS)
    return figure


def _about_fastest_slip(track):
    """Number of the first place of a second, with the fastest way back in its middle."""
    shown = track.time_s <= SHOWN_S
    speed = np.diff(track.x_m[shown]) / np.diff(track.time_s[shown])
    return int(np.clip(speed.argmin() - STRIPS // 2, 0, max(0, shown.sum() - STRIPS)))


def _draw_strips(axes, pictures, track, middle_m):
    """Thresholded pictures, cut to the lane of the chain at this place, one below the other."""
    half = 0.53 * Scene().block_width
    top, bottom = (round(filmed.pixel(track, middle_m, side)[1]) for side in (-half, half))
    lane = slice(max(0, top), bottom)
    strips = [white(picture, track.metres_per_pixel)[lane] for picture in pictures]
    width, scale = pictures[0].shape[1], 100 * track.metres_per_pixel
    edges = (np.array([-0.5, width - 0.5]) - track.zero[0]) * scale
    look = {"cmap": "gray", "aspect": "auto", "interpolation": "nearest"}
    axes.imshow(np.vstack(strips), extent=(*edges, len(strips), 0), **look)
    axes.set_xlim(0, edges[1])
    for number in range(1, len(strips)):
        axes.axhline(number, color=style.GREY, linewidth=0.4)

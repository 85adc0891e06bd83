"""Figs. 1 to 5: the chain, and films of the virtual experiment."""

import itertools
from functools import partial

import numpy as np
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch, Rectangle

from beltrepro.base import checks
from beltrepro.base.errors import NotEnoughDataError
from beltrepro.model.units import to_si
from beltrepro.replication.camera.recording import (
    LARGE,
    LASTING_S,
    LONGEST_GAP,
    SMALL,
    WHOLE,
    analyse,
)
from beltrepro.replication.camera.scene import Scene
from beltrepro.replication.camera.track import white
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.experiment import measure
from beltrepro.simulation.picture import SUFFIXES
from beltrepro.stats import estimates, spectra, states
from beltrepro.stats.spectra import HIGHEST_HZ

FIGURES = {
    "fig01": Figure(uses=(), number="1"),
    "fig02": Figure(uses=("belt_028", "belt_028_film", "belt_028_track"), number="2"),
    "fig03": Figure(uses=("belt_028", "belt_028_film", "belt_028_track"), number="3"),
    "fig04": Figure(uses=("belt_028", "belt_028_track", "belt_035", "belt_035_track"), number="4"),
    "fig05": Figure(uses=("belt_022", "belt_022_track"), number="5"),
    "experiment_noise": Figure(uses=("experiment_odds", "alternation"), category="Further studies"),
}


# --- A recording of the last block, drawn like Figs. 4 and 5; `beltrepro analyse` calls it --------

_COLOURS = {WHOLE: style.SKY, SMALL: style.GREEN, LARGE: style.BLUE}
_WORDS = {SMALL: "small amplitude", LARGE: "large amplitude"}


def save(recording, path):
    """Draw a recording into a file; InputError for another ending than those of SUFFIXES."""
    style.write(draw_recording(recording), path, checks.path("path", path, SUFFIXES).stem)


@style.styled
def draw_recording(recording):
    """x_N(t), stretches of small amplitude shaded; below, spectra of the parts of Figs. 4 and 5."""
    names = [name for name in (SMALL, LARGE, WHOLE) if name in recording.spectra]
    if len(names) == 2:  # one part is the whole
        names = [name for name in names if name != WHOLE]
    figure = style.page(1.7 * (1 + len(names)))
    above, *below = figure.subplots(1 + len(names))
    above.set_title("\n".join(draw_trace(above, recording)))
    for axes, name in zip(below, names, strict=True):
        draw_spectrum(axes, recording.spectra[name], name)
    return figure


def draw_trace(axes, recording, window=(-np.inf, np.inf)):
    """x_N(t) within a window, in seconds and centimetres; small amplitudes shaded.

    Returns two lines of words, on r and on the small amplitude.
    """
    shown = (recording.time_s >= window[0]) & (recording.time_s <= window[1])
    time, position = recording.time_s[shown], 100 * recording.x_m[shown]
    # A line across a gap would show what was not seen.
    gaps = np.flatnonzero(np.diff(time) > LONGEST_GAP * recording.interval_s) + 1
    panels.trace(axes, np.insert(time, gaps, np.nan), np.insert(position, gaps, np.nan), ylabel="")
    axes.set(xlabel="$t$ (s)", ylabel="$x_N$ (cm)", xlim=(time[0], time[-1]))
    for begin, end in recording.small_s:
        axes.axvspan(begin, end, color=style.GREEN, alpha=0.15, linewidth=0)
    longest = np.diff(recording.small_s, axis=1).max(initial=0.0)
    share = f"small amplitude {100 * recording.small_share:.0f} %, {longest:.0f} s at most"
    return f"$r$ = {recording.disorder.words}", share


def draw_spectrum(axes, spectrum, name, *, linear=False):
    """Power spectrum of a stretch of a recording, with its power law on a logarithmic axis."""
    shown = spectrum.frequency_hz <= HIGHEST_HZ
    frequency, power = spectrum.frequency_hz[shown], spectrum.power[shown]
    look = {"color": _COLOURS[name], "linewidth": 0.6, "alpha": 0.35 if linear else 1}
    axes.semilogy(frequency, power, rasterized=True, **look)
    axes.set(xlabel=r"$\nu$ (Hz)", ylabel=r"$S(\nu)$ (m$^2$/Hz)", xlim=(frequency[0], HIGHEST_HZ))
    axes.set_ylim(np.quantile(power, 0.02), 5 * power.max())
    if linear:
        axes.set(xlim=(0, HIGHEST_HZ), xticks=range(0, 9, 2))
    else:
        axes.set_xscale("log")
        if 100 * frequency[0] > HIGHEST_HZ:
            panels.plain_log(axes.xaxis)
    title = [f"{spectrum.begin_s:.0f} to {spectrum.end_s:.0f} s"]
    if name != WHOLE:
        title.insert(0, _WORDS[name])
    if spectrum.law and not linear:
        band = np.array([spectrum.law.low, spectrum.law.high])
        label = panels.true_minus(rf"$\propto \nu^p$, $p$ = {spectrum.exponent.words}")
        axes.plot(band, spectrum.law(band), label=label, **style.HERE)
        axes.legend(loc="lower left")
    panels.remark(axes, "\n".join(title))  # the letter is beside the last line


# --- Parts that the figures of the virtual experiment share (Figs. 2 to 5) ------------------------

SECONDS = r"$t$ (s)"
LENGTH = "$x_5$ (cm)"


def _page(height, layout, **how):
    """A page with lettered panels that says at its top that the experiment is not a real one."""
    figure, axes = panels.page(height, layout, **how)
    words = "virtual experiment: simulated chain, simulated camera"
    figure.suptitle(words, style="italic", color="0.35")
    return figure, axes


def speed(run):
    velocity = run.attributes["belt_velocity"]
    return (
        rf"$u$ = {to_si(velocity, 'velocity'):.2f} m/s, "
        rf"$\sigma$ = {run.attributes['noise']:g}"
    )


def pixel(track, x_m, y_m=0.0):
    """Pixel of a point, metres along the belt from the fixed point and across it from the chain."""
    angle, (column, row) = np.radians(track.angle), track.zero
    along, across = x_m / track.metres_per_pixel, y_m / track.metres_per_pixel
    return (
        column + along * np.cos(angle) - across * np.sin(angle),
        row + along * np.sin(angle) + across * np.cos(angle),
    )


_SHOWN_S = 300.0  # of a recording, as in the paper


def _begin(recording):
    """Where the part of a recording begins that is nearest to half small amplitude."""
    last = max(recording.time_s[-1] - _SHOWN_S, recording.time_s[0])
    begins = np.arange(recording.time_s[0], last + 1, _SHOWN_S / 10)
    inside = np.clip(recording.small_s, begins[:, None, None], begins[:, None, None] + _SHOWN_S)
    share = np.diff(inside, axis=2).sum(axis=(1, 2)) / _SHOWN_S
    return begins[np.argmin(np.abs(share - 0.5).round(9))]


def _draw_film(trace, below, data, film):
    """x_5(t) of a film, and spectra of its longest small and large amplitude, or of the whole."""
    track = data[f"{film}_track"]
    try:
        recording = analyse(track.time_s, track.x_m)
    except NotEnoughDataError as reason:
        for axes in (trace, *below):
            panels.note(axes, str(reason))
        return
    begin = _begin(recording)
    _, words = draw_trace(trace, recording, (begin, begin + _SHOWN_S))
    disorder = f"$r$ = {recording.disorder.value:.2g}"
    observed = [
        one for one in measure.EXPERIMENT if measure.at_speed(one.speed_m_s, data[film].attributes)
    ]
    disorder += "".join(f" (paper: {one.disorder_parameter:g})" for one in observed)
    disorder += "" if observed else "; not paper's $u$"
    trace.set(xlabel=SECONDS, ylabel=LENGTH)
    panels.remark(trace, f"{speed(data[film])}, {disorder}")
    panels.make_room(trace, above=0.2)
    look = {"color": style.GREEN, "ha": "right", "va": "top", "transform": trace.transAxes}
    trace.text(0.99, 0.96, f"whole film: {words}", **look)
    names = ((), (WHOLE,), (SMALL, LARGE))[len(below)]
    for axes, name in zip(below, names, strict=True):
        spectrum = recording.spectra.get(name)
        lasts = spectrum and (name != SMALL or spectrum.end_s - spectrum.begin_s > LASTING_S)
        if not lasts:
            panels.note(axes, f"no stretch of {name} amplitude lasts {LASTING_S:.0f} s here")
            axes.set(xticks=[], yticks=[])
            continue
        # equal spacing is seen on a linear axis only, and peaks in the mean over parts
        draw_spectrum(axes, spectrum, name, linear=True)
        segment = round(spectra.SEGMENT_S / recording.interval_s)
        mean = spectra.power_spectrum(spectrum.x_m, recording.interval_s, segment=segment)
        axes.semilogy(*mean, color=_COLOURS[name], linewidth=1.1)
        if name == SMALL and spectrum.x_m.size >= segment:
            _mark_comb(axes, spectrum.x_m, float(recording.interval_s))


def _mark_comb(axes, values, interval_s):
    """Lines at the multiples of the frequency of which peaks are found; solid where one is."""
    comb = spectra.comb(values, interval_s)
    if comb.found:
        for number, peak in enumerate(comb.peaks, 1):
            look = {"color": "0.6" if peak else "0.75", "linestyle": "-" if peak else ":"}
            axes.axvline(number * comb.spacing_hz, 0, 0.66, linewidth=0.5, zorder=0, **look)
        count = f"{comb.peaks.sum()} of {comb.peaks.size} multiples"
        words = f"{count}\nof {comb.spacing_hz:.2f} Hz: peaks"
        axes.text(0.98, 0.96, words, ha="right", va="top", transform=axes.transAxes)


# --- Fig. 1: the chain on the belt ----------------------------------------------------------------

N_BLOCKS = 5
_BLOCK = 0.62  # side of a block
_APART = 1.35  # middles of neighbours
_ROLLER = 0.22


@panels.draws(FIGURES)
def fig01(data):
    """Drawing of the model of Sec. III; shows no data."""
    figure = style.page(1.1)
    axes = figure.subplots()
    wall = {"facecolor": "0.85", "edgecolor": "0.5", "hatch": "////", "lw": 0}
    axes.add_patch(Rectangle((-0.2, -0.55), 0.2, 1.5, **wall))
    axes.plot([0, 0], [-0.55, 0.95], color="black", linewidth=1.4)
    _draw_belt(axes, 0.25, _APART * N_BLOCKS + 0.95)
    end, side = 0.0, _BLOCK / 2
    for number in range(1, N_BLOCKS + 1):
        last = _APART * number
        _draw_spring(axes, end, last - side)
        colour, ink = ("0.25", "white") if number < N_BLOCKS else ("white", "black")
        look = {"facecolor": colour, "edgecolor": "black", "linewidth": 1.2}
        axes.add_patch(Rectangle((last - side, 0.02), _BLOCK, _BLOCK, **look))
        axes.text(last, side, "$m$", ha="center", va="center", color=ink)
        end = last + side
    axes.text(0.5, 0.55, "$k$", ha="center")
    height = _BLOCK + 0.42
    axes.plot([last] * 2, [_BLOCK + 0.05, height + 0.1], "k:", linewidth=0.8)
    _arrow(axes, (0, height), (last, height), "black", style="<|-|>")
    axes.text(last / 2, height + 0.08, "$x_N$", ha="center")
    axes.set(xlim=(-0.35, end + 1.25), ylim=(-0.6, 1.4), aspect="equal")
    axes.axis("off")
    return figure


def _draw_belt(axes, begin, end):
    """The belt on its rollers, and an arrow for its velocity."""
    corner, size = (begin + _ROLLER, -2 * _ROLLER), (end - begin - 2 * _ROLLER, 2 * _ROLLER)
    look = {"facecolor": "0.93", "edgecolor": "black", "linewidth": 1.2}
    rounded = f"round,pad=0,rounding_size={_ROLLER}"
    axes.add_patch(FancyBboxPatch(corner, *size, boxstyle=rounded, **look))
    for place in np.linspace(begin + 2 * _ROLLER, end - 2 * _ROLLER, 6):
        centre = (place, -_ROLLER)
        axes.add_patch(Circle(centre, 0.72 * _ROLLER, facecolor="white", edgecolor="0.35"))
    _arrow(axes, (end - 0.12, 0.22), (end + 0.62, 0.22), style.VERMILION)
    axes.text(end + 0.25, 0.32, "$u$", ha="center", color=style.VERMILION)


def _draw_spring(axes, begin, end):
    lead = 0.15 * (end - begin)
    along = np.linspace(begin + lead, end - lead, 240)
    wave = _BLOCK / 2 + 0.1 * np.sin(np.linspace(0, 12 * np.pi, along.size))
    height = [_BLOCK / 2, *wave, _BLOCK / 2]
    axes.plot([begin, *along, end], height, color=style.BLUE, linewidth=0.8)


def _arrow(axes, begin, end, colour, style="-|>"):
    look = {"arrowstyle": style, "mutation_scale": 7, "color": colour, "linewidth": 1.3}
    axes.add_patch(FancyArrowPatch(begin, end, shrinkA=0, shrinkB=0, **look))


# --- Fig. 2: snapshot of the experiment -----------------------------------------------------------


@panels.draws(FIGURES)
def fig02(data):
    """The first frame of the film, with the names of its parts."""
    first = _first_frame(data["belt_028"], data["belt_028_film"])
    picture = first["picture"]
    figure, (axes,) = _page(1.25, "a")
    axes.set_title("", loc="left")
    height, width = picture.shape
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    _name_parts(axes, partial(pixel, data["belt_028_track"]), first["blocks_m"])
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height + 55, -60), xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    return figure


@panels.reduced
def _first_frame(series, film):
    """The picture, and the places of the blocks in it."""
    blocks_m = to_si(series.arrays["positions"][0], "length")
    return {"picture": next(film()).picture, "blocks_m": blocks_m}


def _name_parts(axes, pixel, blocks_m):
    """Blocks are named above the picture, what else there is below it."""
    scene = Scene()
    half = scene.block_width / 2
    for number, place in enumerate(blocks_m, 1):
        # a long word beside another would run into it: only the first has room
        words = {1: "block 1", len(blocks_m): f"{number}, white"}.get(number, f"{number}")
        _point(axes, words, pixel(place, -half), -35)
    tape = half + scene.tape_gap + scene.tape_width / 2
    _point(axes, "fixed point", pixel(0.0, half / 2), 35, align="left")
    _point(axes, "tape measure", pixel(0.45, tape), 35)
    bar = [pixel(place, half) for place in (1.15, 1.25)]
    axes.plot(*zip(*bar, strict=True), color="white", linewidth=1.5)
    look = {"textcoords": "offset points", "color": "white", "ha": "center"}
    axes.annotate("10 cm", pixel(1.2, half), (0, 2), **look)
    middle = (blocks_m[-2] + blocks_m[-1]) / 2
    _point(axes, "spring", pixel(middle, scene.spring_width / 2), 35)
    begin, end = pixel(blocks_m[-1] + 0.06), pixel(blocks_m[-1] + 0.16)
    arrow = {"arrowstyle": "-|>", "color": style.ORANGE, "linewidth": 1.6}
    axes.annotate("", end, begin, arrowprops=arrow)
    axes.annotate("belt, $u$", begin, (0, 4), textcoords="offset points", color=style.ORANGE)


def _point(axes, words, place, beyond, *, align="center"):
    """Words above (beyond < 0) or below the picture, with a line to a place in it."""
    height = axes.images[0].get_array().shape[0]
    outside = beyond if beyond < 0 else height + beyond
    line = {"arrowstyle": "-", "color": style.SKY, "linewidth": 0.8}
    look = {"ha": align, "va": "center"}
    axes.annotate(words, place, (place[0], outside), arrowprops=line, **look)


# --- Fig. 3: thresholded frames, and the place of the last block in them --------------------------

STRIPS = 24
SHOWN_S = 10.0
_BESIDE_CM = 10.0  # of black beside what is white
_NEAR_S = 1e-3  # instants of a table and of its film


@panels.draws(FIGURES)
def fig03(data):
    """Frames about the fastest slip of the first seconds, one below the other."""
    track = data["belt_028_track"]
    figure, (axes,) = _page(3.0, "a")
    axes.set_title("", loc="left")
    chosen = _about_fastest_slip(track)
    time, position = track.time_s[chosen] - track.time_s[chosen][0], 100 * track.x_m[chosen]
    _draw_strips(axes, _strips(data["belt_028"], data["belt_028_film"], track)["strips"], track)
    axes.plot(position, np.arange(len(time)) + 0.5, ".", color=style.VERMILION, markersize=2)
    axes.set_yticks(np.arange(0, len(time), 6) + 0.5, [f"{instant:.2f}" for instant in time[::6]])
    axes.set(xlabel=LENGTH, ylabel="$t$ since the first frame (s)")
    panels.remark(axes, speed(data["belt_028"]))
    return figure


def _about_fastest_slip(track):
    """The places of a second with the fastest way back in its middle."""
    shown = track.time_s <= SHOWN_S
    speed = np.diff(track.x_m[shown]) / np.diff(track.time_s[shown])
    begin = int(np.clip(speed.argmin() - STRIPS // 2, 0, max(0, shown.sum() - STRIPS)))
    return slice(begin, begin + STRIPS)


@panels.reduced
def _strips(series, film, track):
    """Thresholded frames, cut to the lane of the chain at the place of the last block."""
    chosen, half = _about_fastest_slip(track), 0.53 * Scene().block_width
    (first, *_, last), middle_m = track.time_s[chosen], track.x_m[chosen].mean()
    top, bottom = (round(pixel(track, middle_m, side)[1]) for side in (-half, half))
    lane = slice(max(0, top), bottom)
    frames = itertools.takewhile(lambda f: f.time_s < last + _NEAR_S, film())
    pictures = [frame.picture for frame in frames if frame.time_s > first - _NEAR_S][:STRIPS]
    return {"strips": np.array([white(one, track.metres_per_pixel)[lane] for one in pictures])}


def _draw_strips(axes, strips, track):
    """One below the other."""
    width, scale = strips.shape[2], 100 * track.metres_per_pixel
    edges = (np.array([-0.5, width - 0.5]) - track.zero[0]) * scale
    look = {"cmap": "gray", "aspect": "auto", "interpolation": "nearest"}
    axes.imshow(np.vstack(strips), extent=(*edges, len(strips), 0), **look)
    lit = (edges[0] + scale * np.flatnonzero(strips.any(axis=(0, 1))))[[0, -1]]
    axes.set_xlim(*(lit + _BESIDE_CM * np.array([-1, 1])))
    for number in range(1, len(strips)):
        axes.axhline(number, color=style.GREY, linewidth=0.4)


# --- Fig. 4: x_5(t) at 0.28 m/s, with spectra of small and of large amplitudes --------------------


@panels.draws(FIGURES)
def fig04(data):
    """a: x_5(t) at 0.35 m/s; b, c: spectra of its small and large amplitude; d: 0.28 m/s."""
    figure, (alternating, *below, usual) = _page(3.95, "aa;bc;dd", height_ratios=(0.9, 0.95, 1.05))
    for film, trace, parts in (("belt_035", alternating, below), ("belt_028", usual, ())):
        _draw_film(trace, parts, data, film)
    spectra_of = [axes for axes in below if axes.get_yscale() == "log"]
    limits = [axes.get_ylim() for axes in spectra_of]
    for axes in spectra_of:
        axes.set_ylim(min(low for low, _ in limits), 10 * max(high for _, high in limits))
    _print_bars(usual, {"paper: both regimes in turns": (3.0, _SHOWN_S - 3)})
    return figure


def _print_bars(axes, bars):
    """Above a trace what the paper sees at this speed, to the same scale: ends by words."""
    begin, _ = axes.get_xlim()
    panels.make_room(axes, above=0.2)
    where = {"transform": axes.get_xaxis_transform()}
    for words, ends in bars.items():
        axes.plot(begin + np.array(ends), [0.7] * 2, "|-", color=style.BLACK, **where)
        axes.text(begin + ends[0] + 3, 0.73, words, **where)


# --- Fig. 5: x_5(t) at 0.22 m/s, with its spectrum ------------------------------------------------

_PRINTED_S = {"paper: avalanches": (0.0, 125.0), "paper: all slip": (125.0, 185.0)}  # or more


@panels.draws(FIGURES)
def fig05(data):
    """a: x_5(t); b: a minute of it, as long as the printed slip; c: the spectrum of all of it."""
    figure, (above, enlarged, below) = _page(4.05, "a;b;c", height_ratios=(1.3, 1, 1))
    _draw_film(above, (below,), data, "belt_022")
    track = data["belt_022_track"]
    begin, _ = above.get_xlim()
    window = tuple(begin + np.array(_PRINTED_S["paper: all slip"]))
    panels.zoom(above, enlarged, track.time_s, 100 * track.x_m, window)
    enlarged.set(xlabel=SECONDS, ylabel=LENGTH)
    slips_s = _slips_of_all(data["belt_022"])["seconds"]
    for ends in slips_s[(slips_s[:, 1] > window[0]) & (slips_s[:, 0] < window[1])]:
        enlarged.axvspan(*ends, color="0.8", linewidth=0, zorder=0)
    longest = np.diff(slips_s, axis=1).max(initial=0.0)
    enlarged.set_title(
        f"grey: all blocks slip, {longest:.1f} s at most (paper: 60 s)", color="0.35"
    )
    _print_bars(above, _PRINTED_S)
    return figure


@panels.reduced
def _slips_of_all(series):
    arrays, about = series.arrays, series.attributes
    relative = arrays["velocities"] - about["belt_velocity"]
    slips = states.slips_of_all(arrays["time"], relative, arrays["events"])
    return {"seconds": to_si(slips - about["transient"], "time")}


# --- Not in the paper: what trials of its length say about the recordings of the experiment -------

_LINES = 4  # most friction ratios that are shown: the printed one, and larger ones
_SPEED_COLOURS = (style.BLUE, style.VERMILION)


@panels.draws(FIGURES)
def experiment_noise(data):
    """a: r against noise; b: alternation against u."""
    figure, (disorder, alternating) = panels.page(3.8, "a;b")
    _draw_disorder(disorder, data["experiment_odds"])
    _draw_alternation(alternating, data["alternation"])
    return figure


def _draw_disorder(axes, odds):
    """r at each noise, a colour for each speed; the printed r as lines."""
    axes.set(xlabel=panels.NOISE, ylabel=panels.DISORDER, ylim=(0, 0.16))
    rows = odds[(odds["dataset"] == "trials") & odds["noise"].notna()]
    axes.set_xscale("log")
    panels.plain_log(axes.xaxis)
    for (speed, at_speed), colour, shift in zip(
        rows.groupby("speed_m_s"), _SPEED_COLOURS, (0.96, 1.04), strict=False
    ):
        place, look = at_speed["noise"] * shift, {"color": colour, "markersize": 4}
        middle = {"fmt": "o", "elinewidth": 1.2, "label": f"{speed:g} m/s"}
        numbers = (at_speed[name] for name in ("r", "r_lower", "r_upper"))
        panels.intervals(axes, place, *numbers, **middle, **look)
        axes.plot(place, at_speed["r_least"], "v", markerfacecolor="none", **look)
        axes.axhline(at_speed["r_recorded"].iloc[0], color=colour, linestyle="--", linewidth=1.2)
    look = {"color": style.BLACK, "markerfacecolor": "none", "markersize": 4}
    axes.plot([], [], "v", **look, label=f"least of {rows['runs'].max()}")
    axes.plot([], [], "--", color=style.BLACK, label="paper")
    panels.legend_above(axes, handlelength=1.0, columnspacing=0.6)


def _draw_alternation(axes, table):
    """Share of alternating trials of all noises against u, a line for each friction ratio."""
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel="share with both regimes", ylim=(-0.03, 1.03))
    counts = table.groupby(["friction_ratio", "belt_velocity"])[["alternating", "runs"]].sum()
    ratios = np.unique(table["friction_ratio"])
    ratios = ratios[ratios > measure.FRICTION_RATIO - 1e-9]
    shown = np.unique(np.linspace(0, ratios.size - 1, _LINES).round().astype(int))
    for index, (ratio, colour) in enumerate(
        zip(ratios[shown], style.shades(shown.size), strict=True)
    ):
        velocity, rows = counts.loc[ratio].index, counts.loc[ratio].to_numpy()
        middle, low, high = np.transpose([estimates.share(*row).numbers for row in rows])
        look = style.line_style(index) | {"color": colour, "markersize": 3, "elinewidth": 0.7}
        look |= {"label": f"{ratio:g}" if index else f"$f_s$ = {ratio:g}", "linewidth": 0.9}
        place = velocity + 0.12 * (index - shown.size / 2)
        panels.intervals(axes, place, middle, low, high, **look)
    for observation, colour in zip(measure.EXPERIMENT, _SPEED_COLOURS, strict=True):
        axes.axvline(observation.belt_velocity, color=colour, linestyle="--", linewidth=1.2)
    panels.legend_above(axes)

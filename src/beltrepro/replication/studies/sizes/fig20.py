"""Fig. 20: ten blocks in their transition region."""

import numpy as np

from beltrepro.replication.drawing import alternation, panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.stats import sections

FIGURE = Figure(uses=("n10_u28", "n10_u31", "n10_u34", "n10_u38", "size_replicates"), number="20")

SHOWN = 10000.0  # length of the part of a series that is drawn
N_BLOCKS = 10


@style.styled
def draw(data):
    """a to d: x_N(t) after the transient; e: last stick of each run against belt velocity."""
    panels.require(data, FIGURE)
    scan = data["size_replicates"]
    laminar_time = float(scan.attributes["laminar_time"])
    series = (data[name] for name in FIGURE.uses if name != "size_replicates")
    every = sorted(series, key=lambda one: one.attributes["belt_velocity"])
    figure = style.page(5.6)
    *stack, below = figure.subplots(len(every) + 1, 1, height_ratios=[1] * len(every) + [1.5])
    for axes, mark, series in zip(stack, "abcd", every, strict=True):
        axes.sharex(stack[0])
        axes.sharey(stack[0])
        axes.tick_params(labelbottom=axes is stack[-1])
        panels.letter(axes, mark)
        begin, _ = alternation.half_laminar(series, laminar_time, SHOWN)
        alternation.trace(axes, series, laminar_time, (begin, begin + SHOWN), zero=begin)
    stack[-1].set_xlabel("$t$ since the left edge of the panel")
    panels.letter(below, "e")
    _last_sticks(below, scan, laminar_time)
    return figure


def _last_sticks(axes, scan, laminar_time):
    """Last stick of the last block of each run, and the share of runs that stick to the end."""
    row = sections.rows(scan, n_blocks=N_BLOCKS, noise=0.0)
    velocity, transient = row["belt_velocity"], float(scan.attributes["transient"])
    duration = float(scan.attributes["duration"])
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel="last stick / length of run", ylim=(-0.05, 1.12))
    if not velocity.size:
        panels.note(axes, f"no run with N = {N_BLOCKS}")
        return
    # a run that never sticks after the transient has none
    last = np.where(np.isfinite(row["last_stick_time"]), row["last_stick_time"], transient)
    lasting = last > duration - laminar_time
    axes.plot(
        velocity, last / duration, ".", color=style.BLUE, markersize=3, alpha=0.5, label="a run"
    )
    places = np.unique(velocity)
    share = [lasting[velocity == place].mean() for place in places]
    look = {"color": style.VERMILION, "markerfacecolor": "none", "markersize": 5}
    axes.plot(places, share, "o", **look, label="share that sticks to the end")
    axes.axhline(transient / duration, color="0.5", linewidth=0.8, linestyle=":")
    panels.legend_above(axes)

"""Comparison of integrators: how trajectories from the same state part."""

import numpy as np
from matplotlib.ticker import FixedLocator, NullFormatter

from beltrepro.analysis import divergence
from beltrepro.figures import panels, style

TITLE = "Trajectories of the two integrators from the same initial states."
USES = {
    "tested": "runs by the tested integrator with several time steps",
    "reference": "runs by the reference from the same states",
}

_SHOWN_ERRORS = (1, 5, 20)
_ROUNDING = 1e-5  # below, before the first event, there is only rounding


@style.styled
def draw(data, caption):
    """a: separation against time; b: shift of shared events; c: error against the time step.

    a and b: medians over the members, at the time step of the reference runs. c: root mean square
    over the members of the separation after a number of events, for one point.
    """
    panels.require(data, USES)
    tested, reference = (data[name].arrays for name in USES)
    base = reference["time_step"][0]
    steps = np.unique(tested["time_step"])
    nearest = steps[np.argmin(np.abs(steps - base))]
    found = divergence.pairs(tested, reference, time_step=nearest, reference_step=base)
    figure = style.page(caption, 3.4)
    axes = figure.subplots(1, 3)
    for panel, name in zip(axes, "abc", strict=True):
        panels.letter(panel, name)
    for index, (point, members) in enumerate(sorted(found.items())):
        look = style.line_style(index) | {"marker": "", "linewidth": 0.9}
        _separation(axes[0], members, look)
        _shifts(axes[1], members, look | {"label": f"$N = {point[0]}$, $u = {point[1]:g}$"})
    axes[0].axhline(divergence.PARTED, color=style.GREY, linewidth=0.6, linestyle=":")
    words = f"$dt = {nearest:g}$"
    axes[0].set(xlabel=panels.TIME, ylabel="separation of the blocks", title=words)
    axes[0].set_ylim(bottom=_ROUNDING)
    axes[1].set(xlabel=f"{panels.TIME} of the event", ylabel="shift of the event", title=words)
    _errors(axes[2], tested, reference, steps, base)
    for panel in axes:
        if not panel.lines:
            panels.note(panel, "no run has a reference")
    handles, labels = axes[1].get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside upper center", ncols=6)
    return figure


def _separation(axes, members, look):
    middle = np.median([pair.separation for pair in members], axis=0)
    axes.semilogy(members[0].time, np.where(middle > 0, middle, np.nan), **look)


def _shifts(axes, members, look):
    """Median shift in slices of time: members have their events at different instants."""
    instants = np.concatenate([pair.event_time for pair in members])
    shifts = np.abs(np.concatenate([pair.event_shift for pair in members]))
    edges = np.linspace(0, members[0].time[-1], 41)
    slices = np.digitize(instants, edges)
    known = np.unique(slices)
    known = known[known < edges.size]
    centre = (edges[known - 1] + edges[known]) / 2
    middle = np.array([np.median(shifts[slices == one]) for one in known])
    axes.semilogy(centre, np.where(middle > 0, middle, np.nan), **look)


def _errors(axes, tested, reference, steps, base):
    """Errors at the point with the most blocks but not more than 5, and the largest u."""
    tables = [
        divergence.pairs(tested, reference, time_step=step, reference_step=base) for step in steps
    ]
    axes.set(xlabel="$dt$", ylabel="error")
    points = sorted(tables[0]) if tables else []
    if not points:
        return
    point = max([one for one in points if one[0] <= 5] or points)
    axes.set_title(f"$N = {point[0]}$, $u = {point[1]:g}$")
    errors = [divergence.errors(table[point]) for table in tables]
    for index, n_events in enumerate(_SHOWN_ERRORS):
        known = [(step, error[n_events][1]) for step, error in zip(steps, errors, strict=True)
                 if n_events in error]  # fmt: skip
        if known:
            label = f"after {n_events} event" + ("s" if n_events > 1 else "")
            look = style.line_style(index) | {"markersize": 3, "linewidth": 0.9}
            axes.loglog(*zip(*known, strict=True), label=label, **look)
    if not axes.lines:
        return
    low = min(line.get_ydata()[0] / line.get_xdata()[0] for line in axes.lines)
    ends = steps[[0, -1]]
    axes.loglog(ends, 0.5 * low * ends, color=style.GREY, linewidth=0.8, label=r"$\propto dt$")
    axes.xaxis.set_major_locator(FixedLocator(steps[:: max(1, steps.size // 2)]))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** 0.45)
    axes.legend(loc="upper left")

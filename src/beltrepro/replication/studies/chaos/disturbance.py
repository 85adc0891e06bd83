"""Not in the paper: what small disturbances of each slip, as by a time step, do to the motion."""

import numpy as np
import pandas as pd

from beltrepro.model.scheme_error import equivalent_kick
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.stats.estimates import share_of
from beltrepro.stats.growth import finite_size_exponents

FIGURE = Figure(uses=("growth", "steps", "kicked", "weak_noise"), category="Further studies")

_FEWEST = 5  # passages that a rate of growth rests on
_SKIPPED = 1  # levels of a twin in which it turns to the direction that grows
_DISTURBANCE = "disturbance of a slip"
_METHODS = {"event": "exact", "verlet": "scheme"}


@style.styled
def draw(data):
    """Growth by size; irregular runs and r against the disturbance; r against weak noise."""
    panels.require(data, FIGURE)
    figure = style.page(6.6)
    growth, share, disorder, noise = axes = figure.subplots(4, 1)
    panels.letters(*axes)
    for panel in axes:
        panel.set_xscale("log")
    _draw_growth(growth, data["growth"])
    steps, kicked, noisy = (data[name].arrays for name in ("steps", "kicked", "weak_noise"))
    scheme = _runs(steps, equivalent_kick(steps["belt_velocity"], steps["time_step"]))
    kicks = _runs(kicked, kicked["kick"])
    levels = _runs(noisy, noisy["noise"], step=noisy["time_step"])
    marks = dict(zip(np.unique(noisy["time_step"]), style.MARKERS[2:], strict=False))
    velocities = np.unique(np.concatenate([kicks["u"], levels["u"]]))
    for u, colour in zip(velocities, style.COLOURS, strict=False):
        look = {"color": colour, "elinewidth": 0.6, "markersize": 3.5}
        by_kick, by_step, by_noise = (runs[runs["u"] == u] for runs in (kicks, scheme, levels))
        for panel, draw_runs in ((share, _draw_shares), (disorder, _draw_means)):
            draw_runs(panel, by_kick, fmt="o-", linewidth=0.8, **look)
            draw_runs(panel, by_step, fmt="s", markerfacecolor="none", **look)
        share.plot([], [], color=colour, linewidth=2, label=f"$u = {u:g}$")
        if len(by_noise):
            _draw_means(noise, by_kick, fmt="-", color=colour)
        for step, runs in by_noise.groupby("step"):
            _draw_means(noise, runs, fmt=marks[step], **look)
    look = {"color": style.GREY, "markersize": 3.5}
    disorder.plot([], [], "o", label="kicks", **look)
    disorder.plot([], [], "s", label="time step of the scheme", markerfacecolor="none", **look)
    for step, marker in marks.items():
        noise.plot([], [], marker, label=f"$dt = {panels.power(step)}$", **look)
    share.set(xlabel=_DISTURBANCE, ylabel="share of irregular runs", ylim=(-0.05, 1.05))
    disorder.set(xlabel=_DISTURBANCE, ylabel=panels.DISORDER, xlim=share.get_xlim())
    noise.set(xlabel=panels.NOISE, ylabel=panels.DISORDER, xlim=share.get_xlim())
    for panel in axes:
        if not panel.has_data():
            panels.note(panel, "no runs")
        panels.legend_above(panel, ncols=2 if panel is growth else 5)
    return figure


def _runs(arrays, size, **more):
    """Disturbed runs as rows: u, the size of the disturbance, r, and how the motion ends."""
    runs = {"u": arrays["belt_velocity"], "size": size, "r": arrays["disorder_parameter"]}
    runs["irregular"] = arrays["state"].astype(str) == "irregular"
    return pd.DataFrame(runs | more)[size > 0]


def _draw_growth(axes, dataset):
    """Finite-size exponents of each number of blocks by each method."""
    arrays = dataset.arrays
    observed = dataset.attributes["duration"] - dataset.attributes["transient"]
    levels = arrays["levels"]
    for index, n_blocks in enumerate(np.unique(arrays["n_blocks"])):
        for method, marker in zip(_METHODS, "ox", strict=True):
            runs = (arrays["n_blocks"] == n_blocks) & (arrays["method"].astype(str) == method)
            if not runs.any():
                continue
            times = arrays["passage_time"][runs].reshape(-1, len(levels))
            look = {"color": style.COLOURS[index], "markersize": 3.5}
            label = f"$N = {n_blocks}$, {_METHODS[method]}"
            rates = finite_size_exponents(levels, times, observed, skipped=_SKIPPED)
            measured = (rates.passed >= _FEWEST) & np.isfinite(rates.exponent)
            values = rates.size, rates.exponent, rates.standard_error
            values = np.compress(measured, values, axis=1)
            axes.errorbar(*values, fmt=marker, label=label, elinewidth=0.6, **look)
            none = finite_size_exponents(levels, times, observed)
            still = none.passed == 0
            look |= {"linestyle": "none", "markerfacecolor": "none" if marker == "x" else None}
            axes.plot(none.size[still], none.limit[still], marker="v", **look)
    axes.set(xlabel="distance of two runs", ylabel="rate of growth", yscale="log")
    axes.set_xlim(levels[0], levels[-1])


def _draw_shares(axes, runs, **look):
    """Share of irregular runs at each size of the disturbance."""
    by_size = runs.groupby("size")["irregular"]
    numbers = [share_of(irregular).numbers for _, irregular in by_size]
    if numbers:
        panels.intervals(axes, list(by_size.groups), *np.transpose(numbers), **look)


def _draw_means(axes, runs, **look):
    """Mean r at each size of the disturbance, with its standard error."""
    r = runs.groupby("size")["r"]
    if len(runs):
        axes.errorbar(r.mean().index, r.mean(), r.sem().fillna(0), **look)

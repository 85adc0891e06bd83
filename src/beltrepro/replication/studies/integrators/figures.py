"""The two integrators compared: r with noise, and the attractors without."""

import numpy as np
import pandas as pd
import scipy

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.integrators import measure

FIGURES = {
    "agreement_disorder": Figure(uses=("agreement",), category="Integrators compared"),
    "agreement_attractors": Figure(
        uses=("pairs_states_verlet", "pairs_states_event", "agreement"),
        category="Integrators compared",
    ),
}


# --- Comparison of integrators: the disorder parameter with noise ---------------------------------


@panels.draws(FIGURES)
def agreement_disorder(data):
    """a: mean r of both against u; b: difference in standard errors."""
    table = data["agreement"]
    rows = table[table["quantity"] == measure.DISORDER]
    figure, (above, below) = panels.page(3.8, "a;b", height_ratios=(1.3, 1))
    curves = rows.groupby(["n_blocks", "noise"])
    for index, ((_, noise), curve) in enumerate(curves):
        velocity = curve["belt_velocity"]
        look = style.line_style(index) | style.look_of_noise(noise)
        above.plot(velocity, curve["mean_reference"], color=look["color"], linewidth=0.9)
        bars = {"fmt": "x", "color": look["color"], "markersize": 4, "elinewidth": 0.8}
        points = velocity, curve["mean_tested"], curve["error_tested"]
        above.errorbar(*points, label=rf"$\sigma = {noise:g}$", **bars)
        look |= {"markersize": 3.5, "linestyle": "none"}
        below.plot(velocity, curve["z"], **look)
    above.set(ylabel=panels.DISORDER)
    above.set_ylim(bottom=0)
    panels.legend_above(above, ncols=len(curves))
    below.set(xlabel=panels.BELT_VELOCITY, ylabel="difference / standard error")
    _limits(below, len(rows))
    return figure


def _limits(axes, count):
    """What the largest of so many normal deviates exceeds in 5 of 100 cases."""
    limit = scipy.stats.norm.isf((1 - (1 - measure.LEVEL) ** (1 / count)) / 2)
    axes.axhspan(-2, 2, color="0.92", linewidth=0, zorder=0)
    for side in (-limit, limit):
        axes.axhline(side, color=style.GREY, linewidth=0.8, linestyle="--")
    axes.set_ylim(-1.35 * limit, 1.35 * limit)


# --- Comparison of integrators: the attractors reached without noise ------------------------------

_COLUMNS = ("belt_velocity", "initial_spread", "time_step", "final_disorder")
_WIDTH = 0.8  # of the group of bars at one u, in steps of u


@panels.draws(FIGURES)
def agreement_attractors(data):
    """One row for each initial spread. Left: share that still sticks; right: r at the end."""
    *scans, table = (data[name] for name in FIGURES["agreement_attractors"].uses)
    sides = list(_sides(*scans))
    shares = table[table["quantity"] == measure.STILL_STICKING]
    spreads, velocities = (
        np.unique(scans[0].arrays[name]) for name in ("initial_spread", "belt_velocity")
    )
    figure = style.page(0.65 + 1.7 * spreads.size)
    width = _WIDTH * np.diff(velocities).min(initial=10.0) / len(sides)
    rows = figure.subplots(spreads.size, 2, sharex=True, squeeze=False)
    for (left, right), spread in zip(rows, spreads, strict=True):
        at_spread = shares[np.isclose(shares["initial_spread"], spread)]
        for index, (role, step, colour, label, runs) in enumerate(sides):
            offset = width * (index + 0.5 - len(sides) / 2)
            compared = at_spread[np.isclose(at_spread["time_step"], step)]
            place = compared["belt_velocity"] + offset
            bars = {"fmt": style.MARKERS[index], "markersize": 3, "elinewidth": 0.8}
            mean, error = compared[f"mean_{role}"], compared[f"error_{role}"].fillna(0)
            left.errorbar(place, mean, error, label=label, color=colour, **bars)
            near = runs[runs["initial_spread"] == spread]
            for velocity, at_velocity in near.groupby("belt_velocity"):
                _runs(right, velocity + offset, at_velocity["final_disorder"], colour, width)
        left.set(ylabel="share still sticking", ylim=(-0.05, 1.05))
        right.set(ylabel="$r$ at the end")
        right.set_ylim(bottom=0)
        right.locator_params(axis="y", nbins=5)
        panels.remark(left, f"initial spread {spread:g}")
    for panel in rows[-1]:
        panel.set_xlabel(panels.BELT_VELOCITY)
    panels.letters(*rows.flat)
    legend = rows[0, 0].get_legend_handles_labels()
    look = {"ncols": 4, "title": "paper's scheme, by $dt$, and exact motion"}
    figure.legend(*legend, loc="outside upper center", **look)
    return figure


def _sides(tested, reference):
    """Role, step in the table, colour, label and runs of each tested step and of the reference."""
    runs, base = (
        pd.DataFrame({name: side.arrays[name] for name in _COLUMNS}) for side in (tested, reference)
    )
    for (step, at_step), colour in zip(runs.groupby("time_step"), style.COLOURS, strict=False):
        yield "tested", step, colour, f"$dt = {step:g}$", at_step
    finest = base[base["time_step"] == base["time_step"].min()]
    coarse = runs["time_step"].min()
    yield "reference", coarse, style.BLACK, "exact", finest


def _runs(axes, place, final, colour, width):
    """Each run a dot, in rising order."""
    spread = np.linspace(-0.35, 0.35, final.size) * width
    look = {"markersize": 1.8, "markeredgewidth": 0, "rasterized": True}
    axes.plot(place + spread, np.sort(final), ".", color=colour, **look)

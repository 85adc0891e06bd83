"""Comparison of integrators: the attractors reached without noise."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.transition import lifetimes

FIGURE = Figure(
    title="States reached without noise by the two integrators, from near and from distant states.",
    uses=("pairs_states_verlet", "pairs_states_event"),
    words=(
        "Each row has another spread of initial states. Left: share of runs in which the last "
        "block still sticks at the end. Right: r over the end of each run, a dot a run, side by "
        "side for the time steps of the tested integrator and, black, the reference. Where dots "
        "line up level, all runs reach one attractor."
    ),
    alt=(
        "Panels in rows of initial spread: share of runs that still stick against belt velocity, "
        "and the distributions of final r for each time step and for the reference."
    ),
    category="Integrators compared",
)

_WIDTH = 0.8  # of the group of bars at one u


@style.styled
def draw(data, caption):
    """One row for each initial spread. Left: share that still sticks; right: r at the end.

    Left: bars of one standard error. Right: each run a dot, side by side for the time steps of the
    tested integrator and, black, the reference; u is not to scale.
    """
    panels.require(data, FIGURE)
    tested, reference = (data[name] for name in FIGURE.uses)
    sides = _sides(tested, reference)
    spreads = np.unique(tested.arrays["initial_spread"])
    velocities = np.unique(tested.arrays["belt_velocity"])
    figure = style.page(caption, 1.2 + 2.0 * max(spreads.size, 1))
    rows = figure.subplots(max(spreads.size, 1), 2, sharex=True, squeeze=False)
    for row, spread in zip(rows, spreads, strict=False):
        for place, velocity in enumerate(velocities):
            for index, (label, colour, arrays) in enumerate(sides):
                chosen = (arrays["belt_velocity"] == velocity) & (
                    arrays["initial_spread"] == spread
                )
                offset = _WIDTH * ((index + 0.5) / len(sides) - 0.5)
                first = label if place == 0 else None
                _point(row, place + offset, arrays, chosen, colour, first, _WIDTH / len(sides))
        row[0].set(ylabel="share still sticking", ylim=(-0.05, 1.05))
        row[1].set(ylabel="$r$ at the end")
        row[1].set_ylim(bottom=0)
        row[0].set_title(f"initial spread {spread:g}", loc="left")
    for panel in rows[-1]:
        panel.set_xticks(range(velocities.size), [f"{velocity:g}" for velocity in velocities])
        panel.set_xlabel(panels.BELT_VELOCITY)
    for panel in rows.flat:
        if not panel.has_data():
            panels.note(panel, "no runs")
    handles, labels = rows[0][0].get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _sides(tested, reference):
    """Label, colour and arrays of each time step of the tested integrator, then the reference."""
    sides = []
    for index, step in enumerate(np.unique(tested.arrays["time_step"])):
        chosen = tested.arrays["time_step"] == step
        arrays = {name: values[chosen] for name, values in tested.arrays.items()}
        label = f"{tested.attributes['method']}, $dt = {step:g}$"
        sides.append((label, style.COLOURS[index], arrays))
    return [*sides, (str(reference.attributes["method"]), style.BLACK, reference.arrays)]


def _point(row, place, arrays, chosen, colour, label, width):
    if not chosen.any():
        return
    stuck = lifetimes.labels_of(arrays)[chosen] == lifetimes.STICK_SLIP
    share = stuck.mean()
    error = np.sqrt(share * (1 - share) / stuck.size)
    row[0].errorbar(
        place, share, error, fmt="o", color=colour, markersize=3, elinewidth=0.8, label=label
    )
    final = arrays["final_disorder"][chosen]
    spread = np.linspace(-0.35, 0.35, final.size) * width if final.size > 1 else 0.0
    row[1].plot(
        place + spread,
        np.sort(final),
        ".",
        color=colour,
        markersize=1.8,
        markeredgewidth=0,
        rasterized=True,
    )

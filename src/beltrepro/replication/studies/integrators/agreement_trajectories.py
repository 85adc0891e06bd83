"""Comparison of integrators: how trajectories from the same state part."""

import numpy as np
from matplotlib.ticker import FixedLocator, NullFormatter

from beltrepro.model.accuracy import FORCE_ORDER
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.integrators import divergence

FIGURE = Figure(
    uses=("pairs_paths_verlet", "pairs_paths_event", "convergence"), category="Integrators compared"
)

_AFTER_TIME_STEPS = (1, 5, 20)  # numbers of events
_AFTER_LONG_STEPS = (2, 5, 20)  # right after the first event the first step has made no error yet
_ROUNDING = 1e-5  # below, before the first event, there is only rounding


@style.styled
def draw(data):
    """a: separation against time; b: shift of shared events; c and d: error against the step."""
    panels.require(data, FIGURE)
    tested, reference = (data[name] for name in FIGURE.uses[:2])
    figure = style.page(6.4)
    axes = figure.subplots(4, 1)
    panels.letters(*axes)
    _paths(axes[0], axes[1], tested.arrays, reference.arrays)
    of_verlet, of_event = (
        _rows(data["convergence"], varied, side.attributes["method"])
        for varied, side in (("time_step", tested), ("tolerance", reference))
    )
    axes[2].set(xlabel="$dt$", ylabel="error")
    _errors(axes[2], of_verlet, _AFTER_TIME_STEPS, order=1)
    _tolerances(axes[3], of_event)
    for panel, words in zip(axes, [*["no run has a reference"] * 3, "no tolerances"], strict=True):
        if not panel.lines:
            panels.note(panel, words)
    handles, labels = axes[1].get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside upper center", ncols=3)
    return figure


def _rows(convergence, varied, method):
    """Errors of a method, with what was varied: rows of the table as dicts."""
    chosen = (convergence["varied"] == varied) & (convergence["method"] == method)
    return convergence[chosen].to_dict("records")


def _paths(left, right, tested, reference):
    """Separations and shifts of the runs whose time step is nearest to that of the reference."""
    base = float(reference["time_step"].min())
    steps = np.unique(tested["time_step"])
    nearest = steps[np.argmin(np.abs(steps - base))]
    by_point = divergence.pairs(
        tested,
        reference,
        rows=divergence.equal(tested["time_step"], nearest),
        reference_rows=divergence.equal(reference["time_step"], base),
    )
    sizes, velocities = (sorted({point[axis] for point in by_point}) for axis in (0, 1))
    for point, members in sorted(by_point.items()):
        # The colour says N, the dashes u.
        look = {
            "color": style.COLOURS[sizes.index(point[0])],
            "linestyle": style.DASHES[velocities.index(point[1]) % len(style.DASHES)],
            "linewidth": 0.9,
        }
        _separation(left, members, look)
        _shifts(right, members, look | {"label": f"$N = {point[0]}$, $u = {point[1]:g}$"})
    left.axhline(divergence.PARTED, color=style.GREY, linewidth=0.6, linestyle=":")
    words = f"$dt = {nearest:g}$"
    left.set(xlabel=panels.TIME, ylabel="separation of the blocks", title=words)
    left.set_ylim(bottom=_ROUNDING)
    right.set(xlabel=f"{panels.TIME} of the event", ylabel="shift of the event", title=words)


def _tolerances(axes, errors):
    """Errors against the mean step, with the limit below which there is only rounding."""
    axes.set(xlabel="mean step", ylabel="error")
    _errors(axes, errors, _AFTER_LONG_STEPS, order=FORCE_ORDER + 1)
    if axes.lines:
        tolerances = [row["tolerance"] for row in errors]
        axes.set_xlabel(f"mean step, tolerances {min(tolerances):g} to {max(tolerances):g}")
        limit = divergence.ROUNDING_OF_LONG_STEPS
        axes.axhline(limit, color=style.GREY, linewidth=0.6, linestyle=":")


def _separation(axes, members, look):
    middle = np.median([pair.separation for pair in members], axis=0)
    axes.semilogy(members[0].time, np.where(middle > 0, middle, np.nan), **look)


def _shifts(axes, members, look):
    """Median shift in slices of time: members have their events at different instants."""
    instants = np.concatenate([pair.event_time for pair in members])
    shifts = np.abs(np.concatenate([pair.event_shift for pair in members]))
    edges = np.linspace(0, members[0].time[-1], 41)
    slices = np.digitize(instants, edges)
    filled = np.unique(slices)
    filled = filled[filled < edges.size]
    centre = (edges[filled - 1] + edges[filled]) / 2
    middle = np.array([np.median(shifts[slices == one]) for one in filled])
    axes.semilogy(centre, np.where(middle > 0, middle, np.nan), **look)


def _errors(axes, errors, after_events, *, order):
    """Errors with the fitted orders, at the point with most blocks up to 5 and the largest u."""
    points = {_point(row) for row in errors}
    if not points:
        return
    point = max({point for point in points if point[0] <= 5} or points)
    axes.set_title(f"{errors[0]['method']}, $N = {point[0]}$, $u = {point[1]:g}$")
    for index, n_events in enumerate(after_events):
        rows = [row for row in errors if _point(row) == point and row["after_events"] == n_events]
        if rows:
            steps, sizes = zip(*sorted((row["step"], row["error"]) for row in rows), strict=True)
            look = style.line_style(index) | {"markersize": 3, "linewidth": 0.9}
            axes.loglog(steps, sizes, label=_label(rows[0]), **look)
    if not axes.lines:
        return
    guide = np.array(steps) ** order
    share = 0.3 * min(line.get_ydata()[-1] for line in axes.lines) / guide[-1]
    axes.plot(steps, share * guide, color=style.GREY, linewidth=0.8, label=f"order {order}")
    axes.xaxis.set_major_locator(FixedLocator(steps[:: max(1, len(steps) // 3)]))
    axes.xaxis.set_major_formatter("{x:.2g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** 0.5)
    axes.legend(loc="upper left")


def _label(row):
    words = f"after {row['after_events']} event" + ("s" if row["after_events"] > 1 else "")
    if np.isfinite(row["order"]):
        words += rf": order ${row['order']:.2f} \pm {row['order_error']:.2f}$"
    return words


def _point(row):
    return tuple(row[name] for name in divergence.PLACE)

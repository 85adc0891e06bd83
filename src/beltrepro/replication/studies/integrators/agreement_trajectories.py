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
        data["convergence"].query("varied == @varied and method == @side.attributes['method']")
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
        ends = errors["tolerance"].min(), errors["tolerance"].max()
        axes.set_xlabel("mean step, tolerances {:g} to {:g}".format(*ends))
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
    few = errors[errors["n_blocks"] <= 5]
    for name in divergence.PLACE:
        few = few[few[name] == few[name].max()]
    errors = few.sort_values(["step", "error"])
    for index, n_events in enumerate(after_events):
        rows = errors[errors["after_events"] == n_events]
        if len(rows):
            look = style.line_style(index) | {"markersize": 3, "linewidth": 0.9}
            axes.loglog(rows["step"], rows["error"], label=_label(rows.iloc[0]), **look)
    if not axes.lines:
        return
    first, steps = errors.iloc[0], axes.lines[-1].get_xdata()
    axes.set_title(
        f"{first['method']}, $N = {first['n_blocks']}$, $u = {first['belt_velocity']:g}$"
    )
    guide = steps**order
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

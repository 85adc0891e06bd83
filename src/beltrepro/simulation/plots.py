"""What results show in one panel: drawn into given axes, which their methods return."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import cycle, starmap
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from beltrepro.base import checks, names
from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError, warn
from beltrepro.simulation import artists
from beltrepro.simulation.artists import BLACK, BLUE, COLOURS, GREY, TIME, label, label_of
from beltrepro.simulation.grid import QUANTITIES
from beltrepro.simulation.picture import draw_slips
from beltrepro.stats import sections
from beltrepro.stats.densities import density

Look = dict[str, Any]

# Sizes of avalanches and of slips, with their units.
_ENERGIES = {"dissipated": "energy", "spring_energy_drop": "energy"}
_SIZES = {
    "avalanches": _ENERGIES | {"slips": "1", "blocks": "1"},
    "slips": {"dissipated": "energy", "displacement": "length"},
}
_COMPARED = (*QUANTITIES, "way", "method", "time_step", "tolerance")
_MOST_LABELS = 8
_NONE = -math.inf  # in a key of curves that are sorted
_ROUNDING = 1e-9  # spread of a coordinate over its size, as rounding alone makes it
_BINS = 120, 400  # of v_N, by how many crossings there are
_MARKERS = {"periodic": "o", "irregular": "x", "equilibrium slip": "s"}
_AREA = 60.0  # of the mark of an attractor that all starts reach, points squared
_LEAST = 0.05  # share below which a mark does not shrink on


# --- several chains -------------------------------------------------------------------------------


def results(ax: Axes, table: Any, y: str, x: str | None, by: Any, where: Any, look: Look) -> Axes:
    """The mean over the replicates and its band, a curve for each value of `by`."""
    chosen = _chosen(table, where)
    x, differing = _differing(table, chosen, x)
    abscissa, ordinate = (_column(table, *one, "biuf")[chosen] for one in (("x", x), ("y", y)))
    if "error" in table:  # of a chain that has failed a count is 0 and an answer no
        ordinate = np.where(table["error"][chosen] == "", ordinate, np.nan)
    if endless := np.count_nonzero(np.isinf(abscissa)):
        warn(f"{x} is infinite in {endless} of {abscissa.size} chains: they are not drawn")
    by = differing if by is None else by
    by = [by] if isinstance(by, str) else list(by)
    columns = [_column(table, "by", name)[chosen].tolist() for name in by]
    keys = [tuple(map(_sortable, key)) for key in zip(*columns, strict=True)]
    keys = keys or [()] * len(abscissa)
    curves = sorted(set(keys))
    forms = [*map(artists.form_of, zip(*curves, strict=True))]
    if len(curves) > 1 and "color" in look:
        raise InputError("color: each of several curves has its own; where={...} leaves one")
    _warn_of_starts(table, chosen)
    colours = artists.shades(len(curves)) if len(curves) > 1 else [BLUE]
    labelled = -(-len(curves) // _MOST_LABELS)
    for number, (curve, colour) in enumerate(zip(curves, colours, strict=True)):
        mine = np.array([key == curve for key in keys])
        parts = [one for one in zip(by, curve, forms, strict=True) if one[1] != _NONE]
        words = ", ".join(starmap(artists.valued, parts)) * (number % labelled == 0)
        how = {"color": colour, "label": words} | look
        artists.band(ax, abscissa[mine], ordinate[mine], **how)
    ax.set(xlabel=label_of(x), ylabel=label_of(y))
    if len(curves) > 1:
        ax.legend(title="bands: 10 to 90 %" if ax.collections else None)
    return ax


def section(
    ax: Axes, table: Any, x: str | None, where: Any, bins: int | None, bar: bool, look: Look
) -> Axes:
    """The density of v_N at the section, a column for each value of x."""
    if "section_velocity" not in table:
        raise InputError("these results have no section_velocity: `scan` measures it")
    _refuse_colour(look)
    chosen = _chosen(table, where)
    x, differing = _differing(table, chosen, x)
    abscissa, velocity = _column(table, "x", x, "biuf")[chosen], table["section_velocity"][chosen]
    for name in differing:
        value = _columns(table)[name][chosen][0].item()
        value = repr(value) if isinstance(value, str) else f"{value:.12g}"
        one = f"where={{{name!r}: {value}}}"
        raise InputError(f"{name} has several values, a density is of one: {one}")
    if not np.isfinite(velocity).any():
        raise InputError("section_velocity: no chain crosses its section")
    if "section_position" in table:
        pairs = set(zip(abscissa.tolist(), table["section_position"][chosen].tolist(), strict=True))
        if len(pairs) > len(set(abscissa.tolist())):
            one = f"where={{'section_position': {min(pairs)[1]:.12g}}}"
            raise InputError(f"section_position has several values, a density is of one: {one}")
    if bins is None and "section_histogram" in table:
        edges, counts = table.settings["section_bins"], table["section_histogram"][chosen]
    else:
        edges, counts = _counted(abscissa, velocity, bins)
    if not counts.any():
        raise InputError("section_bins: no crossing lies in them")
    places, heights = sections.density_at(abscissa, counts, edges)
    mesh = artists.density(ax, artists.edges(places), np.asarray(edges), heights, **look)
    if bar:
        artists.colour_bar([mesh], ax, label("density", "1/velocity"))
    ax.set(xlabel=label_of(x), ylabel=label("$v_N$ at the section", "velocity"))
    return ax


def _counted(
    abscissa: np.ndarray, velocity: np.ndarray, bins: int | None
) -> tuple[np.ndarray, np.ndarray]:
    """Edges of bins, and how many of the velocities (P, M) that are kept lie in each."""
    if bins is None:  # in few bins are few crossings seen
        per_column = np.isfinite(velocity).sum() / np.unique(abscissa).size
        bins = int(np.clip(8 * np.sqrt(per_column), *_BINS))
    checks.positive("bins", bins := checks.whole_number("bins", bins))
    edges = np.histogram_bin_edges(velocity[np.isfinite(velocity)], bins)
    return edges, np.array([np.histogram(row[np.isfinite(row)], edges)[0] for row in velocity])


def _columns(table: Any) -> dict[str, np.ndarray]:
    """The arrays that have one number, or word, for each chain: one for constants of its blocks."""
    columns = {name: one for name, one in table.items() if one.shape == table["replicate"].shape}
    many = {name: table[name] for name in QUANTITIES if table[name].ndim > 1}
    return columns | {name: np.array([*map(_in_words, rows)]) for name, rows in many.items()}


def _in_words(values: np.ndarray) -> str:
    """Constants of the blocks of a chain, without what pads them."""
    return f"({', '.join(format(one, '.12g') for one in values if not np.isnan(one))})"


def _column(table: Any, argument: str, name: str, kinds: str = "biufU") -> np.ndarray:
    """One of them of some kinds."""
    columns = _columns(table)
    allowed = [key for key, one in columns.items() if one.dtype.kind in kinds]
    return columns[names.one_of(argument, name, allowed)]


def _chosen(table: Any, where: Mapping[str, Any] | None) -> np.ndarray:
    """Which chains have these values."""
    if not isinstance(where, Mapping | None):
        raise InputError(f"where = {shown(where)}: values by name are needed, {{'noise': 1}}")
    chosen = np.ones(len(table["replicate"]), dtype=bool)
    for name, value in (where or {}).items():
        column = _column(table, "where", name)
        is_word = column.dtype.kind == "U"
        if is_word and checks.is_sequence(value):  # the constants of the blocks of a chain
            value = _in_words(checks.series(f"where: {name}", value))
        elif is_word and name in QUANTITIES and checks.is_real(value):  # the same for all of them
            value = np.array([_in_words(np.full(n, float(value))) for n in table["n_blocks"]])
        if not (is_word or (checks.is_real(value) and np.isinf(value))):  # as a linear_limit
            value = checks.finite_number(f"where: {name}", value)
        chosen &= column == value if is_word else np.isclose(column, value, 1e-9, 0)
        if not chosen.any():
            raise InputError(f"where: no chain has {name} = {shown(value)}")
    return chosen


def _differing(table: Any, chosen: np.ndarray, x: str | None) -> tuple[str, list[str]]:
    """x, if not told the quantity of most values, and what else differs among some chains.

    The way of a sweep is such: a motion met on the way up is no replicate of one on the way down.
    """
    columns = _columns(table)
    compared = [*_COMPARED, *["initial_spread"] * ("way" not in columns)]  # of its first value
    kept = {name: columns[name][chosen].tolist() for name in compared if name in columns}
    # a method without a tolerance has NaN
    many = {name: len({one for one in values if one == one}) for name, values in kept.items()}
    differing = sorted((name for name in many if many[name] > 1), key=lambda name: -many[name])
    if x is None:
        numbers = (name for name in differing if columns[name].dtype.kind != "U")
        x = next(numbers, "belt_velocity")
    return x, [name for name in differing if name != x]


def _sortable(value: Any) -> Any:
    """A value that is equal to itself: `_NONE` for NaN, as of a method without tolerance."""
    return value if value == value else _NONE


def _warn_of_starts(table: Any, chosen: np.ndarray) -> None:
    """Warn if a replicate has several rows at a point, as in the store of a sweep."""
    columns = _columns(table)
    compared = {*_COMPARED, "initial_spread", "seed", "replicate"} & columns.keys()
    rows = zip(*(columns[name][chosen].tolist() for name in compared), strict=True)
    if (most := max(Counter(map(str, rows)).values())) > 1:  # as texts, in which NaN is NaN
        warn(
            f"up to {most} rows of one replicate at one point are averaged, which began from "
            "different states or have other sections; those of a store of sweeps have step and way "
            "if `sweep` is called again with it"
        )


def _refuse_colour(look: Look) -> None:
    if "color" in look:
        raise InputError("color: a density has many, which cmap names")


def plane(ax: Axes, points: Any, as_density: bool, bar: bool, look: Look) -> Axes:
    """Points of a section in the plane of the last block, or their density."""
    if not len(points):
        raise InputError("these are no points: at none the last block slips")
    at = points["position"], points["relative_velocity"]
    if as_density:
        _refuse_colour(look)
        for name, values in zip(("x_N", "v_N - u"), at, strict=True):
            if np.ptp(values) <= _ROUNDING * np.abs(values).max():
                line = f"{name} is {values[0]:g} at all points: their density has no area"
                raise InputError(f"density = True: {line}; draw the points")
        mesh = artists.plane(ax, *at, **look)
        if bar:
            artists.colour_bar([mesh], ax, label("density", "1/(length × velocity)"))
    else:
        look = {"rasterized": len(points) > artists.RASTER_FROM} | look
        ax.plot(*at, **{"color": BLUE, "marker": ".", "markersize": 2, "linestyle": "none"} | look)
    ax.set(xlabel=label("$x_N$", "length"), ylabel=label("$v_N - u$", "velocity"))
    return ax


def spectrum(ax: Axes, measured: Any, law: Any, look: Look) -> Axes:
    """Power by frequency, and the law that was fitted."""
    artists.spectrum(ax, measured.frequency, measured.power, **look)
    if law:
        words = "exponent {:.3g} ({:.3g} to {:.3g})".format(*law.exponent.numbers)
        artists.power_law(ax, law, label=words)
        ax.legend()
    ax.set(xlabel=label("frequency", "1/time"), ylabel="power spectral density")
    return ax


# --- slips and avalanches -------------------------------------------------------------------------


def sizes(ax: Axes, catalogue: Any, kind: str, size: str, bins: int, look: Look) -> Axes:
    """The density of the sizes of avalanches or slips."""
    units = _SIZES[names.one_of("kind", kind, _SIZES)]
    unit, rows = units[names.one_of("size", size, units)], catalogue[kind]
    moved = size == "displacement"
    values = rows["start_position"] - rows["stop_position"] if moved else rows[size]
    checks.positive("bins_per_decade", bins := checks.whole_number("bins_per_decade", bins))
    if not np.any(values > 0):
        raise InputError(f"{kind}: none has a {size} above 0")
    binned = density(values, bins)
    filled = binned.count > 0
    look = {"marker": "o", "markersize": 3, "linestyle": "none", "color": BLUE} | look
    ax.loglog(binned.centre[filled], binned.density[filled], **look)
    whose = "an avalanche" if kind == "avalanches" else "a slip"
    ax.set_xlabel(label(f"{size.replace('_', ' ')} in {whose}", unit))
    ax.set_ylabel(label("density", "1" if unit == "1" else f"1/{unit}"))
    return ax


def slips(ax: Axes, catalogue: Any, point: int, look: Look) -> Axes:
    """The slips of a chain in time and space, a line from where each starts to its stop."""
    rows = catalogue["slips"]
    rows = rows[rows["point"] == checks.key("point", point)]
    if not rows.size:
        raise InputError(f"point = {point}: no slip of such a chain")
    # one line with gaps, as thousands of lines would take seconds
    gap = np.full(rows.size, np.nan)
    time, place = (
        np.stack([rows[f"start_{what}"], rows[f"stop_{what}"], gap], axis=1).ravel()
        for what in ("time", "position")
    )
    look = {"rasterized": rows.size > artists.RASTER_FROM} | look
    ax.plot(time, place, **{"color": BLUE, "linewidth": 0.8} | look)
    ax.set(xlabel=TIME, ylabel=label("place of the block", "length"))
    ax.locator_params(axis="x", nbins=5)
    ax.margins(x=0)
    return ax


# --- one run --------------------------------------------------------------------------------------


def length(ax: Axes, run: Any, window: Sequence[float] | None, look: Look) -> Axes:
    """x_N(t)."""
    ends, inside = _within(run, window, run.initial_state.time + run.sample_start)
    artists.envelope(ax, run.time[inside], run.positions[inside, -1], **look)
    ax.set(xlim=ends, xlabel=TIME, ylabel=label("$x_N$", "length"))
    ax.locator_params(axis="x", nbins=5)  # wide numbers
    return ax


def slipping(ax: Axes, run: Any, look: Look) -> Axes:
    """Who slips when."""
    draw_slips(ax, run, run.initial_state.time, **look)
    ax.set_xlabel(TIME)
    return ax


def phase(ax: Axes, run: Any, block: int, window: Sequence[float] | None, look: Look) -> Axes:
    """The velocity of a block by its position."""
    n_blocks = run.parameters.n_blocks
    number = n_blocks if block == -1 else checks.whole_number("block", block)
    if not 1 <= number <= n_blocks:
        raise InputError(f"block = {number}: allowed are 1 to {n_blocks}, and -1 for the last")
    _, inside = _within(run, window, run.initial_state.time + run.transient)
    look = {"rasterized": np.count_nonzero(inside) > artists.RASTER_FROM} | look
    place, velocity = (moving[inside, number - 1] for moving in (run.positions, run.velocities))
    ax.plot(place, velocity, **{"color": BLUE, "linewidth": 0.6} | look)
    foot = "N" if number == n_blocks else number
    ax.set_xlabel(label(f"$x_{{{foot}}}$", "length"))
    ax.set_ylabel(label(f"$v_{{{foot}}}$", "velocity"))
    return ax


def _within(
    run: Any, window: Sequence[float] | None, begin: float
) -> tuple[list[float], np.ndarray]:
    """Begin and end of what is shown, from `begin` on if it is not told, and which samples are."""
    ends = [begin, run.final_state.time] if window is None else window
    ends = checks.series("window", ends).tolist()
    if len(ends) != 2 or not ends[0] < ends[1]:
        raise InputError(f"window = {shown(window)}: a begin and a later end are needed")
    inside = (run.time >= ends[0]) & (run.time <= ends[1])
    if not inside.any():
        raise InputError(f"this run has no samples from t = {ends[0]:g} to {ends[1]:g}")
    return ends, inside


# --- exponents, branches and basins ---------------------------------------------------------------


def exponents(ax: Axes, spectrum: Any, look: Look) -> Axes:
    """Exponents in their order, with errors; at the foot those of minus infinity."""
    values = spectrum.exponents
    number, finite = np.arange(1, values.size + 1), np.isfinite(values)
    look = {"marker": "o", "linestyle": "none", "markersize": 3, "color": BLUE} | look
    ax.axhline(0.0, color=GREY, linewidth=0.6, zorder=0)
    ax.errorbar(number[finite], values[finite], spectrum.standard_error[finite], **look)
    foot = {"transform": ax.get_xaxis_transform(), "clip_on": False}
    below = number[np.isneginf(values)]
    ax.plot(below, np.zeros(below.size), **look | foot | {"marker": "v", "label": None})
    ax.set(xlabel="number of the exponent", xlim=(0.5, number.size + 0.5))
    ax.set_ylabel(label(r"$\lambda$", "1/time"))
    return ax


def branch(ax: Axes, followed: Any, y: str, columns: dict[str, Any], look: Look) -> Axes:
    """A number of the orbits of a branch, with what happens to them."""
    values = np.asarray(columns[names.one_of("y", y, columns)], dtype=float)
    place, look = followed.parameter, {"color": BLUE, "linewidth": 1.0} | look
    for dashes, chosen in (("-", followed.stable), ("--", ~followed.stable)):
        ax.plot(place, np.where(chosen, values, np.nan), **{"linestyle": dashes} | look)
        look = look | {"label": None}
    rises = bool(values[-1] > values[0])
    for special in (followed.lower_end, *followed.passed, followed.upper_end):
        at = special.parameter, float(np.interp(special.parameter, place, values))
        ax.plot(*at, "o", color=look["color"], markersize=3)
        # on the side of the curve where it is not
        first = special is followed.lower_end
        side, up = ("left", not rises) if first else ("right", rises)
        how = {"xytext": (0, 4 if up else -4), "textcoords": "offset points", "size": "small"}
        ax.annotate(special.kind, at, ha=side, va="bottom" if up else "top", **how)
    ax.margins(y=0.15)
    ax.set(xlabel=label_of(followed.quantity), ylabel=label_of(y))
    return ax


def basins(ax: Axes, reached: Any, look: Look) -> Axes:
    """r of branches and attractors; marks are as large as the shares of the starts."""
    colour = _colours(reached)
    for number, one in reached.branches.items():
        how = {"color": colour[number], "linewidth": 1, "zorder": 1}
        ax.plot(one.parameter, one.disorder_parameter, **how)
    for state, marker in _MARKERS.items():
        if those := [one for one in reached.attractors if one.state == state]:
            at = [one.value for one in those], [one.disorder_parameter for one in those]
            areas = [_AREA * max(one.reached_by / one.starts, _LEAST) for one in those]
            marks = {"marker": marker, "s": areas, "color": [colour[one.label] for one in those]}
            ax.scatter(*at, **{"label": state, "linewidth": 1} | marks | look)
    ax.set(xlabel=label_of(reached.quantity), ylabel="$r$", yscale="log")
    artists.plain_log(ax.yaxis)
    for handle in ax.legend().legend_handles:
        handle.set(color=BLACK, sizes=[_AREA / 4])
    return ax


def shares(ax: Axes, reached: Any, look: Look) -> Axes:
    """Shares of the starts, on top of each other."""
    colour, bottom = _colours(reached), dict.fromkeys(reached.values.tolist(), 0.0)
    look = {"edgecolor": "white", "linewidth": 0.3} | look
    look = {"width": 0.8 * min(np.diff(reached.values), default=1.0)} | look
    for one in reached.attractors:
        share, place = one.reached_by / one.starts, bottom[one.value]
        ax.bar(one.value, share, **{"bottom": place, "color": colour[one.label]} | look)
        bottom[one.value] += share
    ax.set(xlabel=label_of(reached.quantity), ylabel="share of the starts", ylim=(0, 1))
    return ax


def _colours(reached: Any) -> dict[int, str]:
    """A colour for each label, again after seven."""
    labels = sorted({one.label for one in reached.attractors})
    return dict(zip(labels, cycle(COLOURS), strict=False))

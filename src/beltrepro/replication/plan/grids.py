"""From the axes of a dataset, as config.yaml gives them, to its points."""

import itertools
import math
from collections.abc import Callable

from beltrepro.replication.plan.points import Point
from beltrepro.replication.plan.quantities import QUANTITIES, cast

GRID_DIGITS = 10  # values of a grid are rounded so that 35 steps of 0.2 and 14 of 0.5 are both 7.0
LONGEST_GRID = 100_000
MOST_POINTS = 1_000_000  # of a dataset; each is a run

Complain = Callable[[str], Exception]
"""Makes the error for a text about the configuration."""


def points(axes: dict[str, tuple[object, str]], seed: int, complain: Complain) -> tuple[Point, ...]:
    """Every combination of the axes, in the order of the quantities."""
    given, where = axes["n_blocks"]
    sizes = [int(size) for size in values(given, where, complain)]
    _check_tables(axes, sizes, complain)
    table: list[Point] = []
    for n_blocks in sizes:
        grids = [
            [n_blocks]
            if name == "n_blocks"
            else _values_at(name, n_blocks, *axes[name], seed, complain)
            for name in QUANTITIES
        ]
        _check_count(axes, len(table), grids, complain)
        table += map(_with_method, map(Point._make, itertools.product(*grids)))
    return tuple(table)


def values(grid: object, where: str, complain: Complain) -> tuple:
    """Values of a grid."""
    if isinstance(grid, list):
        return tuple(sorted(grid, key=lambda value: (value is not None, value)))
    if not isinstance(grid, dict):
        return (grid,)
    start, stop, step = (grid[key] for key in ("start", "stop", "step"))
    if stop < start:
        raise complain(f"{where}.stop = {stop:g}: must not be less than start = {start:g}")
    steps = (stop - start) / step + 1e-9
    if steps >= LONGEST_GRID:
        raise complain(
            f"{where}.step = {step:g}: gives {steps:.3g} values, at most {LONGEST_GRID} allowed"
        )
    count = math.floor(steps) + 1
    return tuple(round(float(start + index * step), GRID_DIGITS) for index in range(count))


def is_by_size(grid: object) -> bool:
    """Whether a grid is a table N -> grid."""
    return isinstance(grid, dict) and all(str(key).isdigit() for key in grid)


def _values_at(name, n_blocks, grid, where, seed, complain):
    """Values of one quantity for chains of one size."""
    if is_by_size(grid):
        grid = grid[str(n_blocks)]
    match grid:
        case {"count": count}:
            return tuple(range(count))
        case {"offset": offset}:
            return (seed + offset,)
        case {"without_noise": _}:
            return (tuple(sorted(grid.items())),)
    schema = QUANTITIES[name].schema
    whole = schema.get("type") == "integer"
    found = values(grid, where, complain)
    return tuple(int(value) if whole else cast(schema, value) for value in found)


def _with_method(point: Point) -> Point:
    """The point with the one of two methods that its noise asks for."""
    if isinstance(point.method, str):
        return point
    methods = dict(point.method)
    return point._replace(method=methods["with_noise" if point.noise > 0 else "without_noise"])


def _check_count(axes, before, grids, complain):
    """A dataset has not more points than a plan can hold."""
    count = before + math.prod(map(len, grids))
    if count > MOST_POINTS:
        lengths = dict(zip(QUANTITIES, map(len, grids), strict=True))
        where = axes[max(lengths, key=lengths.__getitem__)][1]
        raise complain(
            f"{where}: with the other axes it makes {count:.3g} points, "
            f"at most {MOST_POINTS} allowed"
        )


def _check_tables(axes, sizes, complain):
    """A table N -> grid has an entry for each number of blocks and no other."""
    for grid, where in axes.values():
        if not is_by_size(grid):
            continue
        for n_blocks in sizes:
            if str(n_blocks) not in grid:
                raise complain(f"{where} has no entry for n_blocks = {n_blocks}")
        if extra := set(map(int, grid)) - set(sizes):
            raise complain(
                f"{where} has an entry for n_blocks = {min(extra)}, which the dataset lacks"
            )

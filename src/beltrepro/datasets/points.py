"""Points: one value of each quantity, as a value of its own, as plain values and as columns."""

from collections import namedtuple
from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from beltrepro.datasets.quantities import QUANTITIES
from beltrepro.model import ChainParameters

CHAIN = tuple(each.name for each in fields(ChainParameters))
"""The quantities that are parameters of the chain; the others say how it is computed."""

Point = namedtuple("Point", QUANTITIES)
"""One value of each quantity."""


def chain(point: Point) -> ChainParameters:
    """The chain of a point."""
    return ChainParameters(**{name: getattr(point, name) for name in CHAIN})


def plain(points: Sequence[Point]) -> dict:
    """Points as plain values: each quantity as a list, or as one value if all points share it."""
    table = {}
    for name in QUANTITIES:
        values = [getattr(point, name) for point in points]
        table[name] = values[0] if len(set(values)) == 1 else values
    return {"count": len(points)} | table


def points_of(table: dict) -> list[Point]:
    """The points that `plain` turned into `table`."""
    count = table["count"]
    columns = [
        table[name] if isinstance(table[name], list | tuple) else [table[name]] * count
        for name in QUANTITIES
    ]
    return [Point(*values) for values in zip(*columns, strict=True)]


def columns(points: Sequence[Point]) -> dict[str, np.ndarray]:
    """Arrays (P,) of every quantity; a tolerance that is the method's own is NaN."""
    table = {name: [getattr(point, name) for point in points] for name in QUANTITIES}
    table["tolerance"] = [np.nan if value is None else value for value in table["tolerance"]]
    return {name: np.array(values) for name, values in table.items()}

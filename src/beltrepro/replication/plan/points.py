"""Points: one value of each quantity, as a value of its own, as plain values and as columns."""

from collections.abc import Sequence
from dataclasses import fields
from typing import NamedTuple

import numpy as np

from beltrepro.model import ChainParameters
from beltrepro.replication.plan.quantities import QUANTITIES

CHAIN = tuple(each.name for each in fields(ChainParameters))
"""The quantities that are parameters of the chain; the others say how it is computed."""


class Point(NamedTuple):
    """One value of each quantity, in their order."""

    n_blocks: int
    static_friction: float
    friction_ratio: float
    rest_length: float
    linear_limit: float
    compression_rate: float
    extension_rate: float
    noise: float
    belt_velocity: float
    initial_spread: float
    method: str
    time_step: float
    tolerance: float | None
    kick: float
    seed: int
    replicate: int


def chain(point: Point) -> ChainParameters:
    """The chain of a point."""
    return ChainParameters(**{name: getattr(point, name) for name in CHAIN})


def plain(points: Sequence[Point]) -> dict:
    """Points as plain values."""
    table = {}
    for name in QUANTITIES:
        values = [getattr(point, name) for point in points]
        table[name] = values[0] if len(set(values)) == 1 else values
    return {"count": len(points)} | table


def points_of(table: dict) -> list[Point]:
    """The points that `plain` turned into a table."""
    count = table["count"]
    columns = [
        table[name] if isinstance(table[name], list | tuple) else [table[name]] * count
        for name in QUANTITIES
    ]
    return [Point(*values) for values in zip(*columns, strict=True)]


def columns(points: Sequence[Point]) -> dict[str, np.ndarray]:
    """Points as arrays."""
    table = {name: [getattr(point, name) for point in points] for name in QUANTITIES}
    table["tolerance"] = [np.nan if value is None else value for value in table["tolerance"]]
    return {name: np.array(values) for name, values in table.items()}

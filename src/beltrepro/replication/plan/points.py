"""Points: one value of each quantity; and what quantities, settings and arrays are, in words.

What config.yaml may give, what a job is told and what the columns of a file say of themselves
follow the fields of `Point`. Their order is that of the points: the last one varies fastest.
"""

from collections.abc import Iterable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

from beltrepro.model import ChainParameters, units


def read_yaml(path: Path) -> dict[str, Any]:
    """What a file of the package says; nothing if there is none."""
    # PyYAML's own reader takes ten times as long; it is the one where libyaml is not to be had.
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    return yaml.load(path.read_text("utf-8"), loader) if path.exists() else {}


WORDS = read_yaml(Path(__file__).with_name("words.yaml"))
UNITS = units.TEXTS


class Described(NamedTuple):
    """A quantity of a point, or a setting of a kind, in words."""

    unit: str  # a key of UNITS
    symbol: str  # that of the paper, in plain letters
    description: str  # one sentence


class Point(NamedTuple):
    """One value of each quantity."""

    n_blocks: int
    static_friction: float
    friction_ratio: float
    rest_length: float
    linear_limit: float
    compression_rate: float
    extension_rate: float
    mass: float
    stiffness: float
    weakening_velocity: float
    viscosity: float
    noise: float
    belt_velocity: float
    initial_spread: float
    method: str
    time_step: float
    seed: int
    replicate: int


QUANTITIES, SETTINGS = (
    {name: Described(*map(str.strip, row.split("|", 2))) for name, row in WORDS[part].items()}
    for part in ("quantities", "settings")
)
"""Settings are what all points of a dataset share and no axis can vary."""
CHAIN = tuple(field.name for field in fields(ChainParameters) if field.name in QUANTITIES)
"""The quantities that are parameters of the chain; the others say how it is computed."""
LAW = tuple(name for name in CHAIN if name not in ("n_blocks", "belt_velocity", "noise"))
"""The constants of the law of the springs and of friction."""
DEFAULTS: dict[str, Any] = {
    **{name: getattr(ChainParameters, name) for name in CHAIN if hasattr(ChainParameters, name)},
    **{"initial_spread": 0.0, "method": "event", "time_step": 0.001, "seed": 1, "replicate": 0},
}
"""Values of the quantities where a dataset gives none."""


FURTHER = ("mass", "stiffness", "weakening_velocity", "viscosity")
"""What the law of the paper has no column for: files of chains with it have none either."""


def has_column(name: str, values: Iterable) -> bool:
    """Whether points of these values of a quantity have it as a column."""
    return name not in FURTHER or any(value != DEFAULTS[name] for value in values)


def chain(point: Point) -> ChainParameters:
    """The chain of a point."""
    return ChainParameters(**{name: getattr(point, name) for name in CHAIN})


def plain(points: Sequence[Point]) -> dict:
    """Points as plain values: of each quantity the one value of all, or a list."""
    table: dict[str, Any] = {"count": len(points)}
    for name, *values in zip(Point._fields, *points, strict=True):
        table[name] = values[0] if len(set(values)) == 1 else values
    return table


def points_of(table: dict) -> list[Point]:
    """The points that `plain` turned into a table."""
    values = [table[name] for name in Point._fields]
    lists = [one if isinstance(one, list | tuple) else [one] * table["count"] for one in values]
    return list(map(Point._make, zip(*lists, strict=True)))


def columns(points: Sequence[Point]) -> dict[str, np.ndarray]:
    """Points as arrays."""
    table = zip(Point._fields, *points, strict=True)
    return {name: np.array(values) for name, *values in table if has_column(name, values)}

"""Points: a value of each quantity, described once: its words, unit, limits and default.

What config.yaml may give, its schema and reference, what a job is told and what the columns of a
file say of themselves follow from `Point`. Its order is that of the points: the last one varies
fastest.
"""

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_type_hints

import numpy as np
import yaml

from beltrepro.model import ChainParameters, units
from beltrepro.model.parameters import LIMITS

WORDS: dict[str, Any] = yaml.load(
    Path(__file__).with_name("words.yaml").read_text(encoding="utf-8"),
    Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader),
)
UNITS = {
    "1": "1",
    "length": f"model length ({1e3 * units.LENGTH_M:.3g} mm)",
    "1/length": f"1 / model length ({1e3 * units.LENGTH_M:.3g} mm)",
    "time": f"model time ({units.TIME_S:.3g} s)",
    "1/time": f"1 / model time ({units.TIME_S:.3g} s)",
    "velocity": f"model velocity ({units.VELOCITY_M_S:.3g} m/s)",
    "force": f"model force ({units.FORCE_N:.3g} N)",
    "energy": f"model energy ({units.ENERGY_J:.3g} J)",
}
"""Text of each unit as files carry it."""

Method = Literal["verlet", "event"]


class _Required:
    """Default of what every dataset must be given."""

    def __repr__(self) -> str:
        return "REQUIRED"


REQUIRED = _Required()


@dataclass(frozen=True)
class Described:
    """A quantity of a point, or a setting of a kind or of the camera: what it is and may be."""

    name: str
    type: Any  # as an annotation has it
    default: Any  # value where none is given
    limits: Mapping[str, float] = field(hash=False)  # by the names that pydantic has for ends
    symbol: str = ""  # that of the paper, in plain letters; a key of UNITS; one sentence
    unit: str = "1"
    description: str = ""


def described(
    words: Mapping[str, str], owner: type, defaults: Mapping[str, Any], limits: Mapping[str, Any]
) -> dict[str, Described]:
    """What the annotations of a class stand for, by name and in their order."""
    table = {}
    for name, type_ in get_type_hints(owner).items():
        unit, symbol, text = map(str.strip, words[name].split("|", 2))
        default = defaults.get(name, REQUIRED)
        table[name] = Described(name, type_, default, limits.get(name, {}), symbol, unit, text)
    return table


class Point(NamedTuple):
    """One value of each quantity."""

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
    method: Method
    time_step: float
    tolerance: float | None
    seed: int
    replicate: int


_CHAIN = {one.name: one.default for one in fields(ChainParameters) if one.default is not MISSING}
_SETUP = {
    **{"initial_spread": 0.0, "method": "event", "time_step": 0.001, "tolerance": None},
    **{"seed": 1, "replicate": 0},
}
_KEYS = {name: {"ge": 0, "le": 2**32 - 1} for name in ("seed", "replicate")}
QUANTITIES = described(WORDS["quantities"], Point, _CHAIN | _SETUP, LIMITS | _KEYS)
CHAIN = tuple(field.name for field in fields(ChainParameters) if field.name in QUANTITIES)
"""The quantities that are parameters of the chain; the others say how it is computed."""
LAW = tuple(
    quantity
    for quantity in QUANTITIES.values()
    if quantity.name in CHAIN and quantity.name not in ("n_blocks", "belt_velocity", "noise")
)
"""The constants of the law of the springs and of friction."""


def chain(point: Point) -> ChainParameters:
    """The chain of a point."""
    return ChainParameters(**{name: getattr(point, name) for name in CHAIN})


def plain(points: Sequence[Point]) -> dict:
    """Points as plain values: of each quantity the one value of all, or a list."""
    columns = dict(zip(QUANTITIES, map(list, zip(*points, strict=True)), strict=True))
    table = {
        name: values[0] if len(set(values)) == 1 else values for name, values in columns.items()
    }
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
    table: dict[str, list] = {
        name: [getattr(point, name) for point in points] for name in QUANTITIES
    }
    table["tolerance"] = [np.nan if value is None else value for value in table["tolerance"]]
    return {name: np.array(values) for name, values in table.items()}

"""Points: a value of each quantity, described once: its words, unit, limits and default.

What config.yaml may give, its schema and reference, what a job is told and what the columns of a
file say of themselves follow from `Point`. Its order is that of the points: the last one varies
fastest.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_type_hints

import numpy as np
from pydantic import BeforeValidator, Field, Strict

from beltrepro.model import ChainParameters, units
from beltrepro.model.parameters import LIMITS

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
METHODS: tuple[str, ...] = get_args(Method)


class _Required:
    """Default of what every dataset must be given."""

    def __repr__(self) -> str:
        return "REQUIRED"


REQUIRED = _Required()


class About(NamedTuple):
    """What stands beside the type of a quantity or setting."""

    # "symbol | unit | description": that of the paper, in plain letters; a key of UNITS; one
    # sentence, with the section or equation of the paper
    words: str
    default: Any = REQUIRED  # value where none is given


@dataclass(frozen=True)
class Described:
    """A quantity of a point or a setting of a kind, as its annotation has it."""

    name: str
    type: Any  # what pydantic checks values by
    symbol: str
    unit: str
    description: str
    default: Any


def described(owner: type) -> dict[str, Described]:
    """What the annotations of a class say, by name and in their order."""
    table = {}
    for name, hint in get_type_hints(owner, include_extras=True).items():
        about = next(part for part in hint.__metadata__ if isinstance(part, About))
        symbol, unit, text = about.words.split(" | ")
        table[name] = Described(name, hint, symbol, unit, text, about.default)
    return table


def _whole(value: object) -> object:
    """2.0 is a whole number; what is none is left to be refused."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


WHOLE = BeforeValidator(_whole)
Number = Annotated[float, Strict()]
Whole = Annotated[int, Strict(), WHOLE]
Key = Annotated[Whole, Field(ge=0, le=2**32 - 1)]
_PAPER = ChainParameters(n_blocks=1, belt_velocity=1.0)


class Point(NamedTuple):
    """One value of each quantity."""

    n_blocks: Annotated[
        Whole,
        About("N | 1 | Number of blocks of the chain (Sec. III)."),
        Field(**LIMITS["n_blocks"]),
    ]
    static_friction: Annotated[
        Number,
        About(
            "F_st0 | force | Mean of the static friction force (Sec. III; 1.98 N in Sec. II).",
            _PAPER.static_friction,
        ),
        Field(**LIMITS["static_friction"]),
    ]
    friction_ratio: Annotated[
        Number,
        About(
            "f_s | 1 | F_k / F_st, kinetic over static friction (Eq. 3, Sec. II).",
            _PAPER.friction_ratio,
        ),
        Field(**LIMITS["friction_ratio"]),
    ]
    rest_length: Annotated[
        Number,
        About("l | length | Length of an undeformed spring (Sec. III, Eq. 1).", _PAPER.rest_length),
        Field(**LIMITS["rest_length"]),
    ]
    linear_limit: Annotated[
        Number,
        About(
            "Delta l_max | length | Deformation up to which a spring is linear (Eq. 2).",
            _PAPER.linear_limit,
        ),
        Field(**LIMITS["linear_limit"]),
    ]
    compression_rate: Annotated[
        Number,
        About(
            "b_1 | 1/length | Rate of the exponential of a compressed spring (Eq. 2).",
            _PAPER.compression_rate,
        ),
        Field(**LIMITS["compression_rate"]),
    ]
    extension_rate: Annotated[
        Number,
        About(
            "b_2 | 1/length | Rate of the exponential of a stretched spring (Eq. 2).",
            _PAPER.extension_rate,
        ),
        Field(**LIMITS["extension_rate"]),
    ]
    noise: Annotated[
        Number,
        About("sigma | force | Standard deviation of the static friction force (Sec. III).", 0.0),
        Field(**LIMITS["noise"]),
    ]
    belt_velocity: Annotated[
        Number,
        About("u | velocity | Velocity of the belt (Sec. III)."),
        Field(**LIMITS["belt_velocity"]),
    ]
    initial_spread: Annotated[
        Number,
        About(
            "s_0 | length | Standard deviation of the displacements of the blocks at the start. "
            "Replicate 0 starts from the state of Sec. III, whatever the spread.",
            0.0,
        ),
        Field(**LIMITS["initial_spread"]),
    ]
    method: Annotated[
        Method,
        About(
            " | 1 | Numerical scheme: verlet is the paper's (Appendix), event locates slips and "
            "sticks exactly (docs/event.md).",
            "event",
        ),
    ]
    time_step: Annotated[
        Number,
        About(
            "dt | time | Step of the integration (Sec. III and Appendix); for event it only sets "
            "the strength of the noise.",
            0.001,
        ),
        Field(**LIMITS["time_step"]),
    ]
    tolerance: Annotated[
        Number | None,
        About(
            " | force | Truncation error allowed in a step of event (docs/event.md); null for the "
            "method's own, and for a method that has none.",
            None,
        ),
        Field(**LIMITS["tolerance"]),
    ]
    kick: Annotated[
        Number,
        About(
            " | length | Standard deviation of the displacement that a block gets when it starts "
            "to slip, for event only (docs/chaos.md); the paper has none.",
            0.0,
        ),
        Field(**LIMITS["kick"]),
    ]
    seed: Annotated[
        Key,
        About(
            " | 1 | Seed of all random numbers. With N, u, sigma, the constants of the law and the"
            " replicate it fixes the random static friction F_st (Sec. III) and the initial "
            "spread.",
            1,
        ),
    ]
    replicate: Annotated[
        Key,
        About(" | 1 | Number of the repetition of a chain: others have other random numbers.", 0),
    ]


QUANTITIES = described(Point)
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


def points_in(arrays: dict[str, np.ndarray]) -> list[Point]:
    """The points whose columns `columns` made."""
    table = [arrays[name].tolist() for name in QUANTITIES]
    place = list(QUANTITIES).index("tolerance")
    table[place] = [None if np.isnan(value) else value for value in table[place]]
    return [Point(*values) for values in zip(*table, strict=True)]


def columns(points: Sequence[Point]) -> dict[str, np.ndarray]:
    """Points as arrays."""
    table: dict[str, list] = {
        name: [getattr(point, name) for point in points] for name in QUANTITIES
    }
    table["tolerance"] = [np.nan if value is None else value for value in table["tolerance"]]
    return {name: np.array(values) for name, values in table.items()}

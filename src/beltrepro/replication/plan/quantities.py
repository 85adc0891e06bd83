"""The quantities of a point: each can be one value, a list, a range or, where sensible, a rule.

The order of QUANTITIES is that of the points: the last one varies fastest.
"""

from dataclasses import dataclass, field

from beltrepro.model import ChainParameters, units
from beltrepro.model.parameters import LARGEST, MAXIMUM_BLOCKS

METHODS = ("verlet", "event")


class _Required:
    """Default of what every dataset must be given."""

    def __repr__(self) -> str:
        return "REQUIRED"


REQUIRED = _Required()


@dataclass(frozen=True)
class Quantity:
    """What a point has a value of."""

    name: str  # name in code, config and files; symbol of the paper, in plain letters
    symbol: str
    unit: str  # A key of UNITS
    description: str  # one sentence, with the section or equation of the paper
    schema: dict = field(hash=False)  # JSON schema of one value
    default: object = REQUIRED  # value where none is given; REQUIRED if there is none


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

_POSITIVE = {"type": "number", "exclusiveMinimum": 0, "maximum": LARGEST}
_PAPER = ChainParameters(n_blocks=1, belt_velocity=1.0)

LAW = (
    Quantity(
        "static_friction",
        "F_st0",
        "force",
        "Mean of the static friction force (Sec. III; 1.98 N in Sec. II).",
        _POSITIVE,
        _PAPER.static_friction,
    ),
    Quantity(
        "friction_ratio",
        "f_s",
        "1",
        "F_k / F_st, kinetic over static friction (Eq. 3, Sec. II).",
        {"type": "number", "minimum": 0, "exclusiveMaximum": 1},
        _PAPER.friction_ratio,
    ),
    Quantity(
        "rest_length",
        "l",
        "length",
        "Length of an undeformed spring (Sec. III, Eq. 1).",
        _POSITIVE,
        _PAPER.rest_length,
    ),
    Quantity(
        "linear_limit",
        "Delta l_max",
        "length",
        "Deformation up to which a spring is linear (Eq. 2).",
        _POSITIVE,
        _PAPER.linear_limit,
    ),
    Quantity(
        "compression_rate",
        "b_1",
        "1/length",
        "Rate of the exponential of a compressed spring (Eq. 2).",
        _POSITIVE,
        _PAPER.compression_rate,
    ),
    Quantity(
        "extension_rate",
        "b_2",
        "1/length",
        "Rate of the exponential of a stretched spring (Eq. 2).",
        _POSITIVE,
        _PAPER.extension_rate,
    ),
)

QUANTITIES = {
    each.name: each
    for each in (
        Quantity(
            "n_blocks",
            "N",
            "1",
            "Number of blocks of the chain (Sec. III).",
            {"type": "integer", "minimum": 1, "maximum": MAXIMUM_BLOCKS},
        ),
        *LAW,
        Quantity(
            "noise",
            "sigma",
            "force",
            "Standard deviation of the static friction force (Sec. III).",
            {"type": "number", "minimum": 0, "maximum": 71.4},
            0.0,
        ),
        Quantity(
            "belt_velocity",
            "u",
            "velocity",
            "Velocity of the belt (Sec. III).",
            {"type": "number", "exclusiveMinimum": 0, "maximum": 1000},
        ),
        Quantity(
            "initial_spread",
            "s_0",
            "length",
            "Standard deviation of the displacements of the blocks at the start. Replicate 0 "
            "starts from the state of Sec. III, whatever the spread.",
            {"type": "number", "minimum": 0, "maximum": 10},
            0.0,
        ),
        Quantity(
            "method",
            "",
            "1",
            "Numerical scheme: verlet is the paper's (Appendix), event locates slips and sticks "
            "exactly (docs/event.md).",
            {"enum": list(METHODS)},
            "event",
        ),
        Quantity(
            "time_step",
            "dt",
            "time",
            "Step of the integration (Sec. III and Appendix); for event it only sets the strength "
            "of the noise.",
            {"type": "number", "minimum": 1e-9, "maximum": 0.1},
            0.001,
        ),
        Quantity(
            "tolerance",
            "",
            "force",
            "Truncation error allowed in a step of event (docs/event.md); null for the method's "
            "own, and for a method that has none.",
            {"type": ["number", "null"], "minimum": 1e-16, "maximum": 1},
            None,
        ),
        Quantity(
            "kick",
            "",
            "length",
            "Standard deviation of the displacement that a block gets when it starts to slip, for "
            "event only (docs/chaos.md); the paper has none.",
            {"type": "number", "minimum": 0, "maximum": 10},
            0.0,
        ),
        Quantity(
            "seed",
            "",
            "1",
            "Seed of all random numbers. With N, u, sigma, the constants of the law and the "
            "replicate it fixes the random static friction F_st (Sec. III) and the initial spread.",
            {"type": "integer", "minimum": 0, "maximum": 2**32 - 1},
            1,
        ),
        Quantity(
            "replicate",
            "",
            "1",
            "Number of the repetition of a chain: others have other random numbers.",
            {"type": "integer", "minimum": 0, "maximum": 2**32 - 1},
            0,
        ),
    )
}


def cast(schema: dict, value: object) -> object:
    """A number as the type that its schema names."""
    if isinstance(value, int | float) and "number" in schema.get("type", ""):
        return float(value)
    return value

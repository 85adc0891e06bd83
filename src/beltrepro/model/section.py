"""Where the section lies at which v_N is recorded (Fig. 12), for any chain."""

from functools import cache

import numpy as np

from beltrepro.model.parameters import ChainParameters
from beltrepro.model.spring import balance_tension, spring_extension

PAPER_POSITION = 615.0  # of the last of five blocks (Sec. IV.A, Fig. 12)
_PAPER = ChainParameters(n_blocks=5, belt_velocity=1.0)


def section_position(parameters: ChainParameters, block: int | None = None) -> float:
    """Position at which the velocity of a block, the last one unless told, is recorded (Fig. 12).

    The paper gives 615 for the last of five blocks, 0.998 of the place at which the springs balance
    the kinetic friction of all blocks. For other blocks and chains the same share of that place is
    taken.
    """
    share = PAPER_POSITION / balance_length(_PAPER)
    return round(share * balance_length(parameters, block or parameters.n_blocks), 1)


def balance_length(parameters: ChainParameters, blocks: int | None = None) -> float:
    """Length of the chain, or of its first blocks, at which springs balance kinetic friction."""
    # only friction that depends on the velocity lets the balance depend on the belt
    speed = parameters.belt_velocity if parameters.friction_varies else 1.0
    return _balance_length(parameters.n_blocks, speed, parameters.law, blocks)


@cache  # a scan asks for that of each of its chains
def _balance_length(n_blocks: int, speed: float, law: tuple, blocks: int | None) -> float:
    chain = ChainParameters(n_blocks, speed, 0.0, *law)
    extension = spring_extension(balance_tension(chain), chain)
    return float(np.sum((np.asarray(chain.rest_length) + extension)[:blocks]))

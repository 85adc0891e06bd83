"""States in which all blocks slip for ever."""

import numpy as np

from beltrepro import ChainState
from beltrepro.model.spring import spring_extension


def sliding(chain, displacements):
    """About the lengths at which springs balance kinetic friction."""
    kinetic = chain.friction_ratio * chain.static_friction
    forces = kinetic * np.arange(chain.n_blocks, 0, -1)
    balance = np.cumsum(spring_extension(forces, chain) + chain.rest_length)
    return ChainState.in_motion(chain, balance + displacements, np.zeros(chain.n_blocks))

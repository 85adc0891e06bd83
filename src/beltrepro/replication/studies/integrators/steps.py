"""Steps that a tolerance allows the integrator of Taylor series, from samples of the motion.

A step may be so long that the last two terms of the series of each force reach the tolerance at its
end (docs/event.md). Events and the end of a run cut steps; those found here are not cut. Without
noise, in model units.
"""

import numpy as np

from beltrepro.model import ChainParameters
from beltrepro.model.accuracy import FORCE_ORDER
from beltrepro.model.friction import friction_force
from beltrepro.model.spring import chain_deformations, external_force


def mean_step(
    positions: np.ndarray, velocities: np.ndarray, parameters: ChainParameters, tolerance: float
) -> float:
    """Mean length of the steps allowed while a block slips: time over number of steps."""
    slips = np.any(velocities != parameters.belt_velocity, axis=1)
    if not slips.any():
        return np.nan
    terms = np.abs(force_series(positions[slips], velocities[slips], parameters)).max(axis=2)
    orders = np.array([FORCE_ORDER - 1, FORCE_ORDER])
    steps = (tolerance / np.maximum(terms[orders].T, np.finfo(float).tiny)) ** (1 / orders)
    return float(1 / np.mean(1 / steps.min(axis=1)))


def force_series(
    positions: np.ndarray, velocities: np.ndarray, parameters: ChainParameters
) -> np.ndarray:
    """Taylor coefficients of the external force F_ex on each block.

    The tension of a spring beyond the end D_0 of its linear branch is a constant plus
    G = e^(c(D - D_0))/c, whose coefficients follow from k G_k = sum_{j=1..k} (j c D_j) G_{k-j}
    (Griewank and Walther, SIAM 2008, ch. 13).
    """
    deformation = chain_deformations(positions, parameters)
    linear = np.abs(deformation) <= parameters.linear_limit
    rate = np.where(deformation < 0, -parameters.compression_rate, parameters.extension_rate)
    excess = np.abs(deformation) - parameters.linear_limit
    growth = [np.exp(np.where(linear, 0.0, np.abs(rate) * excess)) / rate]
    weighted = [np.zeros_like(rate)]  # j c D_j
    forces = [external_force(positions, parameters)]
    direction = np.sign(velocities - parameters.belt_velocity)
    friction = friction_force(
        direction, forces[0], parameters.static_friction, parameters.friction_ratio
    )
    motion = [positions, velocities, np.where(direction == 0, 0.0, forces[0] + friction) / 2]
    for k in range(1, FORCE_ORDER + 1):
        change = np.diff(motion[k], axis=1, prepend=0.0)
        weighted.append(k * rate * change)
        terms = (weighted[j] * growth[k - j] for j in range(1, k + 1))
        growth.append(sum(terms, np.zeros_like(rate)) / k)
        tension = np.where(linear, change, growth[k])
        forces.append(np.diff(tension, axis=1, append=0.0))
        motion.append(np.where(direction == 0, 0.0, forces[k]) / ((k + 1) * (k + 2)))
    return np.array(forces)

"""Many chains with deviations from them (`beltrepro.engine.tangent`)."""

import numpy as np

from beltrepro.engine import tangent
from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.memory import zeros
from beltrepro.engine.simd import LANES
from beltrepro.engine.taylor import LEVELS


class TangentIntegrator(EventIntegrator):
    """Chains integrated by `event`, each with K deviations that follow the linearised motion.

    Parameters as for `EventIntegrator`, and n_vectors : K. The deviations are zero to begin with.
    """

    _hooks = tangent.HOOKS

    def __init__(self, states, *, n_vectors: int, **settings):
        super().__init__(states, **settings)
        n_blocks, lanes = self._chains.displacement.shape
        self._companion = tangent.Deviations(
            displacement=zeros((n_vectors, n_blocks, lanes)),
            velocity=zeros((n_vectors, n_blocks, lanes)),
            position=zeros((n_blocks + 1) * LEVELS * LANES),
            slope=zeros(n_blocks * LEVELS * LANES),
        )

    def deviations(self) -> np.ndarray:
        """Deviations (W, 2N, K) now: of the positions, then of the velocities."""
        both = (self._companion.displacement, self._companion.velocity)
        return np.concatenate(both, axis=1)[..., : self._width].transpose(2, 1, 0)

    def set_deviations(self, values: np.ndarray) -> None:
        """Set the deviations (W, 2N, K); a stuck block has no deviation of its velocity."""
        rows = np.minimum(np.arange(self._chains.time.size), self._width - 1)
        displacement, velocity = np.split(values[rows].transpose(2, 1, 0), 2, axis=1)
        self._companion.displacement[...] = displacement
        self._companion.velocity[...] = np.where(self._chains.direction == 0, 0.0, velocity)

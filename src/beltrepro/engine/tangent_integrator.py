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
            delay=zeros((n_vectors, lanes)),
            noise_force=zeros((n_blocks, lanes)),
            position=zeros((n_blocks + 1) * LEVELS * LANES),
            slope=zeros(n_blocks * LEVELS * LANES),
        )

    def deviations(self) -> np.ndarray:
        """Deviations (W, D, K) now: of the N positions, then of the N velocities.

        With noise a last row has the delay of the noise (`beltrepro.engine.tangent`): D is 2N, or
        2N+1 with noise.
        """
        kept = self._companion
        rows = [kept.displacement, kept.velocity, kept.delay[:, None]][: 3 if self._noisy else 2]
        return np.concatenate(rows, axis=1)[..., : self._width].transpose(2, 1, 0)

    def set_deviations(self, values: np.ndarray) -> None:
        """Set the deviations (W, D, K); a stuck block has no deviation of its velocity."""
        columns = values[self._source].transpose(2, 1, 0)
        n_blocks, kept = self.n_blocks, self._companion
        stuck = self._chains.direction == 0
        kept.displacement[...] = columns[:, :n_blocks]
        kept.velocity[...] = np.where(stuck, 0.0, columns[:, n_blocks : 2 * n_blocks])
        if self._noisy:
            kept.delay[...] = columns[:, -1]

    def kept(self) -> list[np.ndarray]:
        """All that the deviations need to go on with the same bits, beside the states."""
        return [values.copy() for values in self._variables()]

    def restore(self, kept: list[np.ndarray]) -> None:
        """Go on with the deviations that `kept` gave."""
        for values, before in zip(self._variables(), kept, strict=True):
            values[...] = before

    def _variables(self) -> list[np.ndarray]:
        own = self._companion
        return [own.displacement, own.velocity, own.delay, own.noise_force]

    @property
    def _noisy(self) -> bool:
        return bool(np.any(self._noise > 0))

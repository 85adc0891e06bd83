"""Chains advanced on Taylor series, each at its own pace: what those integrators have in common."""

from collections.abc import Callable

import numpy as np

from beltrepro.engine import simd
from beltrepro.engine.candidates import CANDIDATES_PER_BLOCK
from beltrepro.engine.ensemble import ChainEnsemble
from beltrepro.engine.events import CROSSINGS_FULL, EVENTS_FULL
from beltrepro.engine.memory import zeros
from beltrepro.engine.taylor import LEVELS


class SeriesEnsemble(ChainEnsemble):
    """State, scratch and buffers for kernels that use `beltrepro.engine.taylor`."""

    def __init__(self, parameters, **settings):
        super().__init__(parameters, **settings)
        n_blocks, lanes = shape = self._initial_displacement.shape
        self._displacement = self._initial_displacement
        self._threshold = self._initial_threshold
        self._velocity, self._direction, self._branch_changed, self._dissipated = (
            zeros(shape) for _ in range(4)
        )
        self._wall_impulse = zeros(lanes)
        # samples of a chain lie side by side: it writes where it has just written
        rows, *columns = self._samples.shape
        self._sample_columns = zeros((*columns, rows))
        self._samples = np.moveaxis(self._sample_columns, -1, 0)

        candidates = n_blocks * CANDIDATES_PER_BLOCK
        series, stretching, growth, force, wall_pull, polynomials = (
            zeros(columns * LEVELS * simd.LANES)
            for columns in (n_blocks + 1, *[n_blocks] * 3, 1, candidates)
        )
        rates, tails = (zeros(n_blocks * simd.LANES) for _ in range(2))
        sources = zeros(candidates * simd.LANES, dtype=np.int64)
        self._series = (
            *(series, rates, stretching, growth, force, wall_pull),
            *(polynomials, sources, tails),
        )

    def _advance(self, kernel: Callable[[], int]) -> int:
        """Call a kernel until no buffer is full; the buffers are doubled, which changes no bit.

        kernel : goes on where it has stopped, with the buffers as they are then.

        Returns what it said at last: DONE or STORM.
        """
        while True:
            status = kernel()
            if status == EVENTS_FULL:
                self._events = np.concatenate([self._events] * 2, axis=1)
            elif status == CROSSINGS_FULL:
                self._crossings = np.concatenate([self._crossings] * 2, axis=1)
            else:
                return status

    def _displacements(self):
        return self._displacement

    def _relative_velocities(self):
        return self._velocity

    def _friction_losses(self):
        return self._dissipated

    def _wall_impulses(self):
        return self._wall_impulse

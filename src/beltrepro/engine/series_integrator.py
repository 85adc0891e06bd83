"""Chains advanced on Taylor series, each at its own pace: what those integrators have in common."""

from collections.abc import Callable

import numpy as np

from beltrepro.engine.integrator import Integrator
from beltrepro.engine.memory import zeros
from beltrepro.engine.records import CONTACT, CROSSINGS_FULL, EVENTS_FULL, Records, Samples

_LARGEST_BUFFER = 2**30  # bytes; chunks of the longest chains need a tenth of that


class SeriesIntegrator(Integrator):
    """Buffers for kernels that use `beltrepro.engine.taylor`.

    A subclass has its state in `_chains`, a named tuple of arrays whose last axis is that of the
    chains, among them displacement, velocity, direction, threshold, dissipated (N, W) and
    wall_impulse (W,). Those that only this scheme has are named in `_own`.
    """

    _own: tuple[str, ...]

    def __init__(self, states, **settings):
        super().__init__(states, **settings)
        # samples of a chain lie side by side: it writes where it has just written
        rows, *columns = self._samples.shape
        self._sample_columns = zeros((*columns, rows))
        self._samples = np.moveaxis(self._sample_columns, -1, 0)

    def _advance(self, kernel: Callable[[Records], int], first: float, interval: float, count: int):
        """Call a kernel until no buffer is full; the buffers are doubled, which changes no bit.

        kernel : goes on where it has stopped, with the records as they are then.
        first, interval, count : of the samples, see `Samples`.

        Returns what it said at last: DONE or STORM. CONTACT stops the run.
        """
        samples = Samples(
            values=self._sample_columns,
            following=zeros(len(self._noise), dtype=np.int64),
            first_block=self._first_sampled,
            first=first,
            interval=interval,
            count=count,
        )
        while True:
            status = kernel(Records(samples, self._events, self._crossings))
            if status == EVENTS_FULL:
                self._events = self._doubled(self._events)
            elif status == CROSSINGS_FULL:
                self._crossings = self._doubled(self._crossings)
            elif status == CONTACT:
                lane = int(np.argmin(self._gaps().min(axis=1)))
                self._stop_at_contact(lane, self._reached(lane))
            else:
                return status

    def _doubled(self, buffer):
        if buffer.rows.nbytes > _LARGEST_BUFFER // 2:
            lane = int(np.argmax(buffer.count[: self._width]))
            reason = f"{buffer.count[lane]} events since t = {self.time:g} are too many to record"
            self._stop(lane, reason, self._reached(lane))
        return buffer._replace(rows=np.concatenate([buffer.rows] * 2, axis=1))

    def _reached(self, lane: int) -> float:
        """Instant that a chain has reached in the chunk under way."""
        raise NotImplementedError

    def _write(self, lane, state, variables):
        values = variables | {
            "displacement": state.displacements,
            "velocity": state.relative_velocities,
            "direction": state.directions,
            "threshold": state.thresholds,
            "dissipated": state.friction_losses,
            "wall_impulse": state.wall_impulse,
        }
        for name, value in values.items():
            getattr(self._chains, name)[..., lane] = value

    def _scheme_variables(self, lane):
        return {name: getattr(self._chains, name)[..., lane].copy() for name in self._own}

    def _displacements(self):
        return self._chains.displacement

    def _relative_velocities(self):
        return self._chains.velocity

    def _directions(self):
        return self._chains.direction

    def _thresholds(self):
        return self._chains.threshold

    def _friction_losses(self):
        return self._chains.dissipated

    def _wall_impulses(self):
        return self._chains.wall_impulse

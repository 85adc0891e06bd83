"""Chains advanced on Taylor series, each at its own pace: what those integrators have in common."""

from collections.abc import Callable

import numpy as np

from beltrepro.engine.integrator import Integrator
from beltrepro.engine.memory import zeros
from beltrepro.engine.records import CROSSINGS_FULL, EVENTS_FULL, Records, Samples


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

        Returns what it said at last: DONE, STORM or CONTACT.
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
                self._events = _doubled(self._events)
            elif status == CROSSINGS_FULL:
                self._crossings = _doubled(self._crossings)
            else:
                return status

    def _closest(self):
        """The chain with the shortest spring: that of which a kernel says that blocks meet."""
        return int(np.argmin(self._gaps().min(axis=1)))

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


def _doubled(buffer):
    return buffer._replace(rows=np.concatenate([buffer.rows] * 2, axis=1))

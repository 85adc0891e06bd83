"""Many chains without noise advanced by the paper's scheme in leaps (`beltrepro.engine.leaps`)."""

from collections.abc import Iterator

import numpy as np

from beltrepro.engine import leaps, simd
from beltrepro.engine.candidates import CANDIDATES_PER_BLOCK
from beltrepro.engine.ensemble import ChainEnsemble, Chunk
from beltrepro.engine.memory import zeros
from beltrepro.engine.taylor import LEVELS


class LeapingVerlet(ChainEnsemble):
    """Chains without noise integrated by the scheme of the Appendix, many steps at a leap.

    Parameters as for `ChainEnsemble`.
    """

    def __init__(self, parameters, **settings):
        super().__init__(parameters, **settings)
        self._sample_buffer = self._sample_columns()
        n_blocks, lanes = shape = self._initial_displacement.shape
        self._displacement = self._initial_displacement
        self._slip_step, self._acceleration, self._velocity, self._direction, self._dissipated = (
            zeros(shape) for _ in range(5)
        )
        self._wall_impulse, self._steps_done = (zeros(lanes) for _ in range(2))
        columns = n_blocks * CANDIDATES_PER_BLOCK
        series, stretching, growth, force, wall_pull, polynomials = (
            zeros(count * LEVELS * simd.LANES)
            for count in (n_blocks + 1, *[n_blocks] * 3, 1, columns)
        )
        rates, slopes, tails, pulls = (zeros(n_blocks * simd.LANES) for _ in range(4))
        self._scratch = (
            series,
            rates,
            slopes,
            stretching,
            growth,
            force,
            wall_pull,
            polynomials,
            zeros(columns * simd.LANES, dtype=np.int64),
            tails,
            pulls,
            zeros(simd.LANES),
            zeros(simd.LANES),
        )

    def advance(self, until: float) -> Iterator[Chunk]:
        """Advance all chains to the step nearest to `until`, chunk by chunk."""
        last = round(until / self.time_step)
        done = round(self.time / self.time_step)
        while done < last:
            start = done
            # chunks end at multiples of their length, wherever a run is cut into pieces
            done = min(last, (start // self._chunk_steps + 1) * self._chunk_steps)
            self._event_count[:] = 0
            self._crossing_count[:] = 0
            self._steps_done[:] = 0.0
            self._run(start, done - start)
            self.time = done * self.time_step
            self._check_state()
            first_row = start // self._stride + 1
            yield self._chunk(
                start * self.time_step, first_row, done // self._stride + 1 - first_row
            )

    def _run(self, first_step, n_steps):
        """Advance all chains by `n_steps`; buffers that are full are doubled."""
        sample_row = zeros(len(self._noise), dtype=np.int64)
        while True:
            status = leaps.leap_steps(
                first_step,
                n_steps,
                self.time_step,
                self._constants,
                self._belt_velocity,
                self._displacement,
                self._slip_step,
                self._acceleration,
                self._velocity,
                self._direction,
                self._dissipated,
                self._wall_impulse,
                self._steps_done,
                *self._scratch,
                self._stride,
                sample_row,
                self._first_sampled,
                self._sample_buffer,
                self._events,
                self._event_count,
                self._section_block,
                self._section_displacement,
                self._crossings,
                self._crossing_count,
            )
            if status == leaps.DONE:
                return
            if status == leaps.EVENTS_FULL:
                self._events = np.concatenate([self._events] * 2, axis=1)
            else:
                self._crossings = np.concatenate([self._crossings] * 2, axis=1)

    def _displacements(self):
        return self._displacement

    def _relative_velocities(self):
        return self._velocity / self.time_step

    def _friction_losses(self):
        return self._dissipated

    def _wall_impulses(self):
        return self._wall_impulse

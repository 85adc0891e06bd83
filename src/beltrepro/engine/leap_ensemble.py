"""Many chains without noise advanced by the paper's scheme in leaps (`beltrepro.engine.leaps`)."""

from collections.abc import Iterator

import numpy as np

from beltrepro.engine import leaps, simd
from beltrepro.engine.ensemble import Chunk
from beltrepro.engine.memory import zeros
from beltrepro.engine.series_ensemble import SeriesEnsemble


class LeapingVerlet(SeriesEnsemble):
    """Chains without noise integrated by the scheme of the Appendix, many steps at a leap.

    Parameters as for `ChainEnsemble`.
    """

    def __init__(self, parameters, **settings):
        super().__init__(parameters, **settings)
        shape = self._displacement.shape
        self._slip_step, self._acceleration = (zeros(shape) for _ in range(2))
        self._steps_done = zeros(shape[1])
        self._scratch = tuple(zeros(self.n_blocks * simd.LANES) for _ in range(2))

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
        """Advance all chains by `n_steps`."""
        sample_row = zeros(len(self._noise), dtype=np.int64)
        self._advance(
            lambda: leaps.leap_steps(
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
                self._threshold,
                self._branch_changed,
                self._wall_impulse,
                self._steps_done,
                *self._series,
                *self._scratch,
                self._stride,
                sample_row,
                self._first_sampled,
                self._sample_columns,
                self._events,
                self._event_count,
                self._section_block,
                self._section_displacement,
                self._crossings,
                self._crossing_count,
            )
        )

    def _relative_velocities(self):
        # the kernel keeps it times the step
        return self._velocity / self.time_step

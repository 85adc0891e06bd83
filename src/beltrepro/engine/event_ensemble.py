"""Many chains advanced by the exact dynamics (`beltrepro.engine.event`)."""

from collections.abc import Iterator

import numpy as np

from beltrepro.engine import event, simd
from beltrepro.engine.ensemble import Chunk
from beltrepro.engine.events import STORM
from beltrepro.engine.memory import aligned, zeros
from beltrepro.engine.series_ensemble import SeriesEnsemble

_PASSES_PER_TIME = 5000  # a chain that takes more steps than this in a unit of time is stopped


class EventEnsemble(SeriesEnsemble):
    """Chains integrated exactly between located events; parameters as for `ChainEnsemble`.

    time_step sets the strength of the noise, which the paper draws anew at every step of its
    scheme, and with sample_stride the interval between samples; the steps taken are longer.
    tolerance : force allowed in the last terms of the series at the end of a step; with noise of
    intensity q it is noise_share sqrt(q) where that is more, see docs/event.md.
    """

    def __init__(
        self,
        parameters,
        *,
        tolerance: float = event.TOLERANCE,
        noise_share: float = event.NOISE_SHARE,
        **settings,
    ):
        super().__init__(parameters, **settings)
        shape = self._displacement.shape
        law = self.parameters[0]
        self._noise_power = aligned((law.friction_ratio * self._noise) ** 2 * self.time_step)
        tolerances = np.maximum(tolerance, noise_share * np.sqrt(self._noise_power))
        self._log_tolerance = aligned(np.log2(tolerances))
        # chains with noise and without have kernels of their own, which leave the others alone
        self._kernels = [
            (kernel, own)
            for kernel, own in (
                (event.advance_quiet_chains, self._noise_power == 0),
                (event.advance_noisy_chains, self._noise_power > 0),
            )
            if own.any()
        ]
        deformation = np.diff(self._displacement, axis=0, prepend=0.0)
        beyond = np.abs(deformation) > law.linear_limit
        self._regime = aligned(np.sign(deformation) * beyond)
        self._noise_force = zeros((2, *shape))
        self._local_time, self._cell = (zeros(shape[1]) for _ in range(2))
        self._scratch = (zeros(simd.LANES), zeros(simd.LANES, dtype=np.int64))

    def advance(self, until: float) -> Iterator[Chunk]:
        """Advance all chains to `until`, chunk by chunk."""
        interval = self._stride * self.time_step
        length = self._chunk_steps * self.time_step
        until = float(until)
        while self.time < until:
            start = self.time
            end = min(until, float(np.floor(start / length + 1e-9) + 1) * length)
            # a sample at the very end belongs to the chunk, whatever its multiple rounds to
            first_row = int(np.floor(start / interval + 1e-9)) + 1
            rows = int(np.floor(end / interval + 1e-9)) + 1 - first_row
            self._event_count[:] = 0
            self._crossing_count[:] = 0
            self._local_time[:] = 0.0
            for kernel, own in self._kernels:
                self._run(kernel, own, end - start, first_row * interval - start, interval, rows)
            self.time = end
            self._check_state()
            yield self._chunk(start, first_row, rows)

    def _run(self, kernel, own, span, first_sample, interval, rows):
        """Advance the chains of a kernel by `span`.

        own : (W,) which chains are those of the kernel.
        """
        sample_row = zeros(len(self._noise), dtype=np.int64)
        status = self._advance(
            lambda: kernel(
                span,
                self.time,
                self._constants,
                self._belt_velocity,
                self._noise_power,
                self._noise,
                self._local_time,
                self._displacement,
                self._velocity,
                self._direction,
                self._threshold,
                self._regime,
                self._branch_changed,
                self._noise_force,
                self._cell,
                self._dissipated,
                self._wall_impulse,
                self._streams,
                *self._series,
                *self._scratch,
                interval,
                first_sample,
                rows,
                sample_row,
                self._first_sampled,
                self._sample_columns,
                self._events,
                self._event_count,
                self._section_block,
                self._section_displacement,
                self._crossings,
                self._crossing_count,
                1000 + int(_PASSES_PER_TIME * span),
                self._log_tolerance,
            )
        )
        if status == STORM:
            late = np.where(own, self._local_time, np.inf)[: self._width]
            lane = int(np.argmin(late))
            self.time += float(late[lane])
            self._stop(lane, "slips and sticks follow each other without end")

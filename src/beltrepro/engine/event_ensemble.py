"""Many chains advanced by the exact dynamics (`beltrepro.engine.event`)."""

from collections.abc import Iterator

import numpy as np

from beltrepro.engine import event, simd
from beltrepro.engine.candidates import CANDIDATES_PER_BLOCK
from beltrepro.engine.ensemble import ChainEnsemble, Chunk
from beltrepro.engine.memory import aligned, zeros
from beltrepro.engine.taylor import LEVELS

_PASSES_PER_TIME = 5000  # a chain that takes more steps than this in a unit of time is stopped


class EventEnsemble(ChainEnsemble):
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
        n_blocks, lanes = shape = self._initial_displacement.shape
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
        self._sample_buffer = self._sample_columns()
        self._displacement = self._initial_displacement
        self._threshold = self._initial_threshold
        self._velocity, self._direction, self._branch_changed, self._dissipated = (
            zeros(shape) for _ in range(4)
        )
        deformation = np.diff(self._displacement, axis=0, prepend=0.0)
        beyond = np.abs(deformation) > law.linear_limit
        self._regime = aligned(np.sign(deformation) * beyond)
        self._noise_force = zeros((2, *shape))
        self._local_time, self._cell, self._wall_impulse = (zeros(lanes) for _ in range(3))

        columns = n_blocks * CANDIDATES_PER_BLOCK
        series, stretching, growth, force, wall_pull, polynomials = (
            zeros(count * LEVELS * simd.LANES)
            for count in (n_blocks + 1, *[n_blocks] * 3, 1, columns)
        )
        rates, tails = (zeros(n_blocks * simd.LANES) for _ in range(2))
        self._scratch = (
            series,
            rates,
            stretching,
            growth,
            force,
            wall_pull,
            polynomials,
            zeros(columns * simd.LANES, dtype=np.int64),
            tails,
            zeros(simd.LANES),
            zeros(simd.LANES, dtype=np.int64),
        )

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
        """Advance the chains of a kernel by `span`; full buffers are doubled, which changes no bit.

        own : (W,) which chains are those of the kernel.
        """
        sample_row = zeros(len(self._noise), dtype=np.int64)
        while True:
            status = kernel(
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
                *self._scratch,
                interval,
                first_sample,
                rows,
                sample_row,
                self._first_sampled,
                self._sample_buffer,
                self._events,
                self._event_count,
                self._section_block,
                self._section_displacement,
                self._crossings,
                self._crossing_count,
                1000 + int(_PASSES_PER_TIME * span),
                self._log_tolerance,
            )
            if status == event.DONE:
                return
            if status == event.STORM:
                late = np.where(own, self._local_time, np.inf)[: self._width]
                lane = int(np.argmin(late))
                self.time += float(late[lane])
                self._stop(lane, "slips and sticks follow each other without end")
            if status == event.EVENTS_FULL:
                self._events = np.concatenate([self._events] * 2, axis=1)
            else:
                self._crossings = np.concatenate([self._crossings] * 2, axis=1)

    def _displacements(self):
        return self._displacement

    def _relative_velocities(self):
        return self._velocity

    def _friction_losses(self):
        return self._dissipated

    def _wall_impulses(self):
        return self._wall_impulse

"""Many chains advanced by the exact dynamics (`beltrepro.engine.event`)."""

from collections.abc import Iterator

import numpy as np

from beltrepro.engine import event
from beltrepro.engine.integrator import Chunk
from beltrepro.engine.memory import aligned, zeros
from beltrepro.engine.records import STORM
from beltrepro.engine.series_integrator import SeriesIntegrator

_PASSES_PER_TIME = 5000  # a chain that takes more steps than this in a unit of time is stopped


class EventIntegrator(SeriesIntegrator):
    """Chains integrated exactly between located events; parameters as for `Integrator`.

    time_step sets the strength of the noise, which the paper draws anew at every step of its
    scheme, and with sample_stride the interval between samples; the steps taken are longer.
    tolerance : force allowed in the last terms of the series at the end of a step; with noise of
    intensity q it is noise_share sqrt(q) where that is more, see docs/event.md.
    """

    _quiet_and_noisy = (event.advance_quiet_chains, event.advance_noisy_chains)
    _companion: tuple = ()  # what the hooks of the kernels need

    def __init__(
        self,
        parameters,
        *,
        tolerance: float = event.TOLERANCE,
        noise_share: float = event.NOISE_SHARE,
        **settings,
    ):
        super().__init__(parameters, **settings)
        law = self.parameters[0]
        power = aligned((law.friction_ratio * self._noise) ** 2 * self.time_step)
        tolerances = np.maximum(tolerance, noise_share * np.sqrt(power))
        self._chains = self._initial_chains(law.linear_limit)
        self._group = event.Group(
            self._law,
            event.Conditions(
                belt_velocity=self._belt_velocity,
                noise=self._noise,
                noise_power=power,
                log_tolerance=aligned(np.log2(tolerances)),
            ),
            self._chains,
        )
        self._scratch = event.new_scratch(self.n_blocks)
        # chains with noise and without have kernels of their own, which leave the others alone
        self._kernels = [
            (kernel, own)
            for kernel, own in zip(self._quiet_and_noisy, (power == 0, power > 0), strict=True)
            if own.any()
        ]

    def _initial_chains(self, linear_limit):
        displacement = self._initial_displacement
        n_blocks, lanes = shape = displacement.shape
        deformation = np.diff(displacement, axis=0, prepend=0.0)
        return event.Chains(
            time=zeros(lanes),
            displacement=displacement,
            velocity=zeros(shape),
            direction=zeros(shape),
            threshold=self._initial_threshold,
            branch=aligned(np.sign(deformation) * (np.abs(deformation) > linear_limit)),
            branch_changed=zeros(shape),
            dissipated=zeros(shape),
            wall_impulse=zeros(lanes),
            cell=zeros(lanes),
            noise_force=zeros((2, n_blocks, lanes)),
            streams=self._streams,
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
            self._empty_buffers()
            self._chains.time[:] = 0.0
            for kernel, own in self._kernels:
                self._run(kernel, own, end - start, first_row * interval - start, interval, rows)
            self.time = end
            self._check_state()
            yield self._chunk(start, first_row, rows)

    def _run(self, kernel, own, length, first_sample, interval, rows):
        """Advance the chains of a kernel by `length`.

        own : (W,) which chains are those of the kernel.
        """
        span = event.Span(self.time, length, 1000 + int(_PASSES_PER_TIME * length))
        status = self._advance(
            lambda records: kernel(span, self._group, self._scratch, records, self._companion),
            first_sample,
            interval,
            rows,
        )
        if status == STORM:
            late = np.where(own, self._chains.time, np.inf)[: self._width]
            lane = int(np.argmin(late))
            self.time += float(late[lane])
            self._stop(lane, "slips and sticks follow each other without end")

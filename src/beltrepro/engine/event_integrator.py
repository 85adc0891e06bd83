"""Many chains advanced by the exact dynamics (`beltrepro.engine.event`)."""

import numpy as np

from beltrepro.engine import event
from beltrepro.engine.integrator import TOLERANCE, Integrator, force_unit
from beltrepro.engine.records import STORM
from beltrepro.engine.vector import aligned, zeros
from beltrepro.model.energy import times_as_fast

# The same with noise, as a share of sqrt(q): its impulse in a time h has deviation sqrt(q h), and
# is itself approximate.
NOISE_SHARE = 1e-2
# A chain that takes more steps than these in a chunk is stopped: at any moment, and in a unit of
# time. Springs that a start compresses beyond all measure would make it crawl for days.
_PASSES_AT_ONCE = 10_000
_PASSES_PER_TIME = 5000
_STORM = f"more than {_PASSES_PER_TIME} steps a unit of time are needed"


class EventIntegrator(Integrator):
    """Chains integrated exactly between located events; parameters as for `Integrator`.

    time_step sets the strength of the noise. tolerance : force allowed in the last terms of the
    series, in units of `force_unit`; with noise of intensity q it is noise_share sqrt(q) where that
    is more (docs/integrators.md).
    """

    name = "event"
    _scheme_fields = ("branch", "branch_changed", "cell", "noise_force")
    # what follows the chains: functions, and what they keep
    _hooks = event.Hooks()
    _companion: tuple = ()

    def __init__(
        self,
        states,
        *,
        tolerance: float = TOLERANCE,
        noise_share: float = NOISE_SHARE,
        **settings,
    ):
        super().__init__(states, **settings)
        chain = self.parameters[0]
        ratio = chain.by_block("friction_ratio").max()
        power = aligned((ratio * self._noise) ** 2 * self.time_step)
        tolerances = np.maximum(tolerance * force_unit(chain), noise_share * np.sqrt(power))
        lanes = len(self._noise)
        self._chains = self._new_chains(
            event.EventChains,
            time=zeros(lanes),
            passes=zeros(lanes),
            wall_impulse=zeros(lanes),
            cell=zeros(lanes),
            noise_force=zeros((2, self.n_blocks, lanes)),
            streams=self._streams,
        )
        self._group = event.EventGroup(
            self._law,
            self._varied,
            belt_velocity=self._belt_velocity,
            noise=self._noise,
            noise_power=power,
            noise_cell=event.NOISE_CELL / times_as_fast(chain),
            log_tolerance=aligned(np.log2(tolerances)),
            chains=self._chains,
        )
        self._scratch = event.new_scratch(self.n_blocks, chain.varied)
        # chains with noise and without have kernels of their own, which leave the others alone
        kinds = np.unique(self._noise > 0)
        self._kernels = [event.advance_kernel(noisy, self._hooks) for noisy in kinds.tolist()]
        self._start_from(states)

    def _new_variables(self, lanes):
        """Branches of the springs; the noise begins with a new cell."""
        deformation = np.diff(lanes.displacements, axis=0, prepend=0.0)
        beyond = np.abs(deformation) > self.parameters[0].linear_limit
        return {
            "branch": np.sign(deformation) * beyond,
            "branch_changed": np.zeros(deformation.shape),
            "cell": np.zeros(deformation.shape[1]),
            "noise_force": np.zeros((2, *deformation.shape)),
        }

    def _run(self, until):
        end = min(until, self._chunk_end(self.time))
        length, interval = end - self.time, self._sampling.interval
        span = event.Span(self.time, length, _PASSES_AT_ONCE, _PASSES_PER_TIME)
        first_row = self._rows(self.time) + 1
        samples = first_row * interval - self.time, interval, self._rows(end) + 1 - first_row
        self._chains.time[:] = 0.0
        self._chains.time[self._width :] = length
        self._chains.passes[:] = 0.0
        given = span, self._group, self._scratch
        for kernel in self._kernels:
            status = self._advance(
                lambda records, kernel=kernel: kernel(*given, records, self._companion), *samples
            )
            if status == STORM:
                excess = self._chains.passes - _PASSES_PER_TIME * self._chains.time
                lane = int(np.argmax(excess[: self._width]))
                self._stop(lane, _STORM)
        return end

    def _reached(self, lane):
        return float(self.time + self._chains.time[lane])

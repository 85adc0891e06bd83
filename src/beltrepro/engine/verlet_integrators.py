"""Many chains advanced by the paper's scheme, in the way that suits them."""

from collections.abc import Sequence

import numpy as np

from beltrepro.engine import leaps, verlet
from beltrepro.engine.integrator import Integrator, Lanes, SeriesIntegrator
from beltrepro.engine.law import of_blocks
from beltrepro.engine.state import ChainState
from beltrepro.engine.vector import aligned, zeros
from beltrepro.model.friction import kinetic_friction

# Largest (dt omega)^2 at which leaps reproduce the steps to below the rounding of a plain loop; and
# that up to which leaps are taken in a run, where impacts compress springs further for a short
# time.
_LEAP_LIMIT = 1e-4
_IMPACT_LIMIT = 2.5e-4
_FREQUENCY = 4.0  # omega^2 of a long chain, over the slope of the tension of its springs


def verlet_integrator(states: Sequence[ChainState], *, time_step: float, **settings) -> Integrator:
    """Chains integrated by the scheme of the Appendix; parameters as for `Integrator`.

    In leaps if none of them has noise and the time step is as short as the paper's, else step by
    step; so are, by a plainer kernel, chains with another law than the paper's.
    """
    first = states[0].parameters
    # the stiffest spring that friction can hold: on the compressed branch, or the stretched one
    rate = max(first.compression_rate, first.extension_rate)
    if first.varied:
        chosen = LiteralVerlet
    elif (
        all(state.parameters.noise == 0 for state in states)
        and time_step**2 * _FREQUENCY * (1 + rate * first.static_friction) <= _LEAP_LIMIT
    ):
        chosen = LeapingVerlet
    else:
        chosen = SteppingVerlet
    return chosen(states, time_step=time_step, **settings)


class _InSteps(Integrator):
    """Chains that go from step to step, in whatever kernel."""

    def _step(self, time: float) -> int:
        return round(time / self.time_step)

    def _instant(self, time):
        return self._step(time) * self.time_step

    def _rows(self, time):
        return self._step(time) // self._sampling.steps

    def _new_variables(self, lanes):
        """w and a(t-dt) dt^2 of the smooth motion through W states; zero for stuck blocks.

        From Taylor's series about the states, to the third order in dt.
        """
        chain, time_step = self.parameters[0], self.time_step
        slips = lanes.directions != 0
        mass = chain.by_block("mass")[:, None]
        kinetic = kinetic_friction(chain, lanes.relative_velocities.T).T
        acceleration = (self.forces_on(lanes) - lanes.directions * kinetic) / mass
        belt_velocity = np.array([member.belt_velocity for member in self.parameters])
        travel = (lanes.relative_velocities + belt_velocity) * time_step
        rise = (self.forces_on(lanes, travel) - self.forces_on(lanes, -travel)) / (2 * mass)
        bend = (rise / 6 - acceleration / 2) * time_step**2
        before = (acceleration - rise) * time_step**2
        return {
            "slip_step": np.where(slips, lanes.relative_velocities * time_step + bend, 0.0),
            "acceleration": np.where(slips, before, 0.0),
        }


class LeapingVerlet(_InSteps, SeriesIntegrator):
    """Chains without noise integrated by the scheme of the Appendix, many steps at a leap.

    See `beltrepro.engine.leaps`; parameters as for `Integrator`.
    """

    name = "leaping verlet"
    _scheme_fields = ("slip_step", "acceleration")
    _kernel = staticmethod(leaps.leap_steps)

    def __init__(self, states, **settings):
        super().__init__(states, **settings)
        lanes = len(self._noise)
        self._chains = self._new_chains(
            leaps.Chains, steps_done=zeros(lanes), wall_impulse=zeros(lanes)
        )
        self._group = leaps.Group(
            self._law,
            self._varied,
            self._belt_velocity,
            self.time_step,
            _IMPACT_LIMIT / (_FREQUENCY * self.time_step**2),
            self._chains,
            None,
        )
        self._scratch = leaps.new_scratch(self.n_blocks)
        self.reinit(states)

    def _write(self, lanes, variables):
        super()._write(lanes, variables)
        self._chains.velocity[...] *= self.time_step  # as the kernel keeps it

    def _run(self, until):
        start = self._step(self.time)
        # half a step on: the end of the last chunk may have been rounded down
        end = self._chunk_end((start + 0.5) * self.time_step)
        n_steps = min(self._step(until), self._step(end)) - start
        stride = self._sampling.steps
        first = (start // stride + 1) * stride - start
        self._chains.steps_done[:] = 0.0
        self._advance(
            lambda records: self._kernel(start, n_steps, self._group, self._scratch, records),
            float(first),
            float(stride),
            (n_steps - first) // stride + 1,
        )
        return (start + n_steps) * self.time_step

    def _reached(self, lane):
        return float(self.time + self._chains.steps_done[lane] * self.time_step)

    def _lanes(self):
        # the kernel keeps velocities times the step
        return super()._lanes()._replace(relative_velocities=self._chains.velocity / self.time_step)


class LiteralVerlet(LeapingVerlet):
    """Chains of any law integrated by the scheme of the Appendix, every step taken literally."""

    name = "literal verlet"
    _kernel = staticmethod(leaps.literal_steps)

    def __init__(self, states, **settings):
        super().__init__(states, **settings)
        self._group = self._group._replace(varied=of_blocks(self.parameters[0]))
        if np.any(self._noise > 0):
            deviates = zeros((self.n_blocks + self.n_blocks % 2) * leaps.LANES)
            noise = leaps.Noise(self._noise, self._streams, deviates)
            self._group = self._group._replace(noise=noise)


class SteppingVerlet(_InSteps):
    """Chains integrated step by step (`beltrepro.engine.verlet`)."""

    name = "stepping verlet"
    _vector = verlet.LANES

    def __init__(self, states, **settings):
        super().__init__(states, **settings)
        lanes = len(self._noise)
        belt_step = self._belt_velocity * self.time_step
        self._chains = verlet.Chains(
            state=verlet.empty_state(self.n_blocks, belt_step),
            wall_pull=zeros(lanes),
            streams=self._streams,
            contact=np.full(lanes, np.inf),
        )
        self._group = verlet.Group(
            law=self._law,
            time_step=self.time_step,
            belt_step=aligned(belt_step),
            noise=self._noise,
            noisy=bool(np.any(self._noise > 0)),
            n_blocks=self.n_blocks,
            chains=self._chains,
        )
        self.reinit(states)

    def _write(self, lanes, variables):
        self._chains.wall_pull[:] = variables["wall_pull"]
        verlet.write_blocks(
            self._group,
            self._step(self.time),
            displacement=lanes.displacements,
            velocity=lanes.relative_velocities * self.time_step,
            direction=lanes.directions,
            threshold=lanes.thresholds,
            **{name: variables[name] for name in ("dissipated", "slip_step", "acceleration")},
        )

    def _new_variables(self, lanes):
        return super()._new_variables(lanes) | {
            "dissipated": lanes.friction_losses * self.time_step**2,
            "wall_pull": lanes.wall_impulse / self.time_step,
        }

    def _scheme_variables(self):
        return {
            "slip_step": self._blocks(verlet.SLIP_STEP),
            "acceleration": self._blocks(verlet.ACCELERATION),
            "dissipated": self._blocks(verlet.DISSIPATED),
            "wall_pull": self._chains.wall_pull,
        }

    def _run(self, until):
        start = self._step(self.time)
        samples = verlet.Samples(self._samples, self._first_sampled, self._sampling.steps)
        records = verlet.Records(samples, self._events, self._crossings)
        n_steps = min(max(1, self._step(self._chunk_time)), self._step(until) - start)
        end = start + verlet.verlet_steps(start, n_steps, self._group, records)
        contact = self._chains.contact[: self._width]
        lane = int(np.argmin(contact))
        if np.isfinite(contact[lane]):
            self._stop_at_contact(lane, contact[lane] * self.time_step)
        return end * self.time_step

    def _blocks(self, field):
        return verlet.of_blocks(self._chains.state, field, self.n_blocks)

    def _lanes(self):
        # the kernel keeps velocities times the step, losses times its square
        return Lanes(
            displacements=self._blocks(verlet.DISPLACEMENT),
            relative_velocities=self._blocks(verlet.VELOCITY) / self.time_step,
            directions=self._blocks(verlet.DIRECTION),
            thresholds=self._blocks(verlet.THRESHOLD),
            friction_losses=self._blocks(verlet.DISSIPATED) / self.time_step**2,
            wall_impulse=self._chains.wall_pull * self.time_step,
        )

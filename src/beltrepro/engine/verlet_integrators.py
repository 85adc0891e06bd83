"""Many chains advanced by the paper's scheme, in the way that suits them."""

from collections.abc import Iterator, Sequence

import numpy as np

from beltrepro.engine import leaps, verlet
from beltrepro.engine.integrator import Chunk, Integrator, Lanes, SeriesIntegrator
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
    if states[0].parameters.varied:
        return LiteralVerlet(states, time_step=time_step, **settings)
    # the stiffest spring that friction can hold: on the compressed branch, or the stretched one
    first = states[0].parameters
    rate = max(first.compression_rate, first.extension_rate)
    slope = 1 + rate * first.static_friction
    short = time_step**2 * _FREQUENCY * slope <= _LEAP_LIMIT
    quiet = all(state.parameters.noise == 0 for state in states)
    chosen = LeapingVerlet if quiet and short else SteppingVerlet
    return chosen(states, time_step=time_step, **settings)


class LeapingVerlet(SeriesIntegrator):
    """Chains without noise integrated by the scheme of the Appendix, many steps at a leap.

    See `beltrepro.engine.leaps`; parameters as for `Integrator`.
    """

    name = "leaping verlet"
    _scheme_fields = ("slip_step", "acceleration")
    _kernel = staticmethod(leaps.leap_steps)

    def __init__(self, states, **settings):
        super().__init__(states, **settings)
        lanes = len(self._noise)
        shape = self.n_blocks, lanes
        self._chains = leaps.Chains(
            steps_done=zeros(lanes),
            displacement=zeros(shape),
            slip_step=zeros(shape),
            acceleration=zeros(shape),
            velocity=zeros(shape),
            direction=zeros(shape),
            threshold=zeros(shape),
            branch_changed=zeros(shape),
            dissipated=zeros(shape),
            wall_impulse=zeros(lanes),
        )
        stiffest = _IMPACT_LIMIT / (_FREQUENCY * self.time_step**2)
        self._group = leaps.Group(
            self._law,
            self._varied,
            self._belt_velocity,
            self.time_step,
            stiffest,
            self._chains,
            self._noise_source(),
        )
        self._scratch = leaps.new_scratch(self.n_blocks)
        self.reinit(states)

    def _noise_source(self):
        return None

    def _set_time(self, time):
        self.time = round(time / self.time_step) * self.time_step

    def _write(self, lanes, variables):
        super()._write(lanes, variables)
        self._chains.velocity[...] *= self.time_step  # as the kernel keeps it

    def _new_variables(self, lanes):
        return _smooth_variables(lanes, self)

    def advance(self, until: float) -> Iterator[Chunk]:
        """Advance all chains to the step nearest to `until`, chunk by chunk."""
        last = round(until / self.time_step)
        done = round(self.time / self.time_step)
        while done < last:
            start = done
            # half a step on: the end of the last chunk may have been rounded down
            end = self._chunk_end((start + 0.5) * self.time_step)
            done = min(last, round(end / self.time_step))
            self._empty_buffers()
            self._chains.steps_done[:] = 0.0
            self._run(start, done - start)
            self.time = done * self.time_step
            self._check_state()
            first_row = start // self._sampling.steps + 1
            rows = done // self._sampling.steps + 1 - first_row
            yield self._chunk(start * self.time_step, first_row, rows)

    def _run(self, first_step, n_steps):
        """Advance all chains by `n_steps`."""
        span = leaps.Span(first_step, n_steps)
        stride = self._sampling.steps
        first_sample = (first_step // stride + 1) * stride - first_step
        self._advance(
            lambda records: self._kernel(span, self._group, self._scratch, records),
            float(first_sample),
            float(stride),
            (n_steps - first_sample) // stride + 1,
        )

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
        if self._varied is None:
            self._group = self._group._replace(varied=of_blocks(self.parameters[0]))

    def _noise_source(self):
        if not np.any(self._noise > 0):
            return None
        deviates = zeros((self.n_blocks + self.n_blocks % 2) * leaps.LANES)
        return leaps.Noise(self._noise, self._streams, deviates)


class SteppingVerlet(Integrator):
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
        self._steps_done = 0
        self.reinit(states)

    def _set_time(self, time):
        self._steps_done = round(time / self.time_step)
        self.time = self._steps_done * self.time_step

    def _write(self, lanes, variables):
        self._chains.wall_pull[:] = variables["wall_pull"]
        verlet.write_blocks(
            self._group,
            self._steps_done,
            verlet.BlockState(
                displacement=lanes.displacements,
                velocity=lanes.relative_velocities * self.time_step,
                direction=lanes.directions,
                threshold=lanes.thresholds,
                dissipated=variables["dissipated"],
                slip_step=variables["slip_step"],
                acceleration=variables["acceleration"],
            ),
        )

    def _new_variables(self, lanes):
        return _smooth_variables(lanes, self) | {
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

    def advance(self, until: float) -> Iterator[Chunk]:
        """Advance all chains to the step nearest to `until`, chunk by chunk."""
        last = round(until / self.time_step)
        stride = self._sampling.steps
        samples = verlet.Samples(self._samples, self._first_sampled, stride)
        chunk_steps = max(1, round(self._chunk_time / self.time_step))
        while self._steps_done < last:
            start = self._steps_done
            self._empty_buffers()
            records = verlet.Records(samples, self._events, self._crossings)
            n_steps = min(chunk_steps, last - start)
            self._steps_done += verlet.verlet_steps(start, n_steps, self._group, records)
            self.time = self._steps_done * self.time_step
            self._check_contacts()
            self._check_state()
            first_row = start // stride + 1
            rows = self._steps_done // stride + 1 - first_row
            yield self._chunk(start * self.time_step, first_row, rows)

    def _check_contacts(self):
        contact = self._chains.contact[: self._width]
        lane = int(np.argmin(contact))
        if np.isfinite(contact[lane]):
            self._stop_at_contact(lane, contact[lane] * self.time_step)

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


def _smooth_variables(lanes: Lanes, chains: Integrator) -> dict[str, np.ndarray]:
    """w and a(t-dt) dt^2 of the smooth motion through W states; zero for stuck blocks.

    From Taylor's series about the states, to the third order in dt.
    """
    chain, time_step = chains.parameters[0], chains.time_step
    slips = lanes.directions != 0
    mass = chain.by_block("mass")[:, None]
    kinetic = kinetic_friction(chain, lanes.relative_velocities.T).T
    acceleration = (chains.forces_on(lanes) - lanes.directions * kinetic) / mass
    belt_velocity = np.array([member.belt_velocity for member in chains.parameters])
    travel = (lanes.relative_velocities + belt_velocity) * time_step
    rise = (chains.forces_on(lanes, travel) - chains.forces_on(lanes, -travel)) / (2 * mass)
    bend = (rise / 6 - acceleration / 2) * time_step**2
    before = (acceleration - rise) * time_step**2
    return {
        "slip_step": np.where(slips, lanes.relative_velocities * time_step + bend, 0.0),
        "acceleration": np.where(slips, before, 0.0),
    }

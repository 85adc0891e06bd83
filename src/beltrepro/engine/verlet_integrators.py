"""Many chains advanced by the paper's scheme, in the way that suits them."""

from collections.abc import Iterator, Sequence

import numpy as np

from beltrepro.engine import leaps, verlet
from beltrepro.engine.integrator import Chunk, Integrator
from beltrepro.engine.memory import aligned, zeros
from beltrepro.engine.series_integrator import SeriesIntegrator
from beltrepro.model import ChainParameters

# Largest (dt omega)^2 at which leaps reproduce the steps to below the rounding of a plain loop.
_LEAP_LIMIT = 1e-4


def verlet_integrator(
    parameters: Sequence[ChainParameters], *, time_step: float, **settings
) -> Integrator:
    """Chains integrated by the scheme of the Appendix; parameters as for `Integrator`.

    In leaps if none of them has noise and the time step is as short as the paper's, else step by
    step.
    """
    # the stiffest spring that friction can hold: on the compressed branch, or the stretched one
    first = parameters[0]
    rate = max(first.compression_rate, first.extension_rate)
    frequency_squared = 4 * (1 + rate * first.static_friction)
    short = time_step**2 * frequency_squared <= _LEAP_LIMIT
    quiet = all(chain.noise == 0 for chain in parameters)
    chosen = LeapingVerlet if quiet and short else SteppingVerlet
    return chosen(parameters, time_step=time_step, **settings)


class LeapingVerlet(SeriesIntegrator):
    """Chains without noise integrated by the scheme of the Appendix, many steps at a leap.

    See `beltrepro.engine.leaps`; parameters as for `Integrator`.
    """

    def __init__(self, parameters, **settings):
        super().__init__(parameters, **settings)
        shape = self._initial_displacement.shape
        self._chains = leaps.Chains(
            steps_done=zeros(shape[1]),
            displacement=self._initial_displacement,
            slip_step=zeros(shape),
            acceleration=zeros(shape),
            velocity=zeros(shape),
            direction=zeros(shape),
            threshold=self._initial_threshold,
            branch_changed=zeros(shape),
            dissipated=zeros(shape),
            wall_impulse=zeros(shape[1]),
        )
        self._group = leaps.Group(self._law, self._belt_velocity, self.time_step, self._chains)
        self._scratch = leaps.new_scratch(self.n_blocks)

    def advance(self, until: float) -> Iterator[Chunk]:
        """Advance all chains to the step nearest to `until`, chunk by chunk."""
        last = round(until / self.time_step)
        done = round(self.time / self.time_step)
        while done < last:
            start = done
            # chunks end at multiples of their length, wherever a run is cut into pieces
            done = min(last, (start // self._chunk_steps + 1) * self._chunk_steps)
            self._empty_buffers()
            self._chains.steps_done[:] = 0.0
            self._run(start, done - start)
            self.time = done * self.time_step
            self._check_state()
            first_row = start // self._stride + 1
            yield self._chunk(
                start * self.time_step, first_row, done // self._stride + 1 - first_row
            )

    def _run(self, first_step, n_steps):
        """Advance all chains by `n_steps`."""
        span = leaps.Span(first_step, n_steps)
        first_sample = (first_step // self._stride + 1) * self._stride - first_step
        self._advance(
            lambda records: leaps.leap_steps(span, self._group, self._scratch, records),
            float(first_sample),
            float(self._stride),
            (n_steps - first_sample) // self._stride + 1,
        )

    def _relative_velocities(self):
        # the kernel keeps it times the step
        return self._chains.velocity / self.time_step


class SteppingVerlet(Integrator):
    """Chains integrated step by step (`beltrepro.engine.verlet`)."""

    _vector = verlet.LANES

    def __init__(self, parameters, **settings):
        super().__init__(parameters, **settings)
        belt_step = self._belt_velocity * self.time_step
        self._chains = verlet.Chains(
            state=verlet.initial_state(
                self._initial_displacement, self._initial_threshold, belt_step
            ),
            wall_pull=zeros(len(self._noise)),
            streams=self._streams,
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

    def advance(self, until: float) -> Iterator[Chunk]:
        """Advance all chains to the step nearest to `until`, chunk by chunk."""
        last = round(until / self.time_step)
        samples = verlet.Samples(self._samples, self._first_sampled, self._stride)
        while self._steps_done < last:
            start = self._steps_done
            self._empty_buffers()
            records = verlet.Records(samples, self._events, self._crossings)
            n_steps = min(self._chunk_steps, last - start)
            self._steps_done += verlet.verlet_steps(start, n_steps, self._group, records)
            self.time = self._steps_done * self.time_step
            self._check_state()
            first_row = start // self._stride + 1
            rows = self._steps_done // self._stride + 1 - first_row
            yield self._chunk(start * self.time_step, first_row, rows)

    def _displacements(self):
        return verlet.of_blocks(self._chains.state, verlet.DISPLACEMENT, self.n_blocks)

    def _relative_velocities(self):
        # the kernel keeps it times the step
        velocity = verlet.of_blocks(self._chains.state, verlet.VELOCITY, self.n_blocks)
        return velocity / self.time_step

    def _friction_losses(self):
        loss = verlet.of_blocks(self._chains.state, verlet.DISSIPATED, self.n_blocks)
        return loss / self.time_step**2

    def _wall_impulses(self):
        return self._chains.wall_pull * self.time_step

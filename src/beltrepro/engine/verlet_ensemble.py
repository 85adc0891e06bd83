"""Many chains advanced by the paper's scheme, in the way that suits them."""

from collections.abc import Iterator, Sequence

import numpy as np

from beltrepro.engine import verlet
from beltrepro.engine.ensemble import ChainEnsemble, Chunk
from beltrepro.engine.leap_ensemble import LeapingVerlet
from beltrepro.engine.memory import zeros
from beltrepro.model import ChainParameters

# Largest (dt omega)^2 at which leaps reproduce the steps to below the rounding of a plain loop.
_LEAP_LIMIT = 1e-4


def verlet_ensemble(
    parameters: Sequence[ChainParameters], *, time_step: float, **settings
) -> ChainEnsemble:
    """Chains integrated by the scheme of the Appendix; parameters as for `ChainEnsemble`.

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


class SteppingVerlet(ChainEnsemble):
    """Chains integrated step by step (`beltrepro.engine.verlet`)."""

    _vector = verlet.LANES

    def __init__(self, parameters, **settings):
        super().__init__(parameters, **settings)
        self._noisy = bool(np.any(self._noise > 0))
        self._state = verlet.initial_state(
            self._initial_displacement,
            self._initial_threshold,
            self._belt_velocity * self.time_step,
        )
        self._wall_pull = zeros(len(self._noise))
        self._steps_done = 0

    def advance(self, until: float) -> Iterator[Chunk]:
        """Advance all chains to the step nearest to `until`, chunk by chunk."""
        last = round(until / self.time_step)
        while self._steps_done < last:
            start = self._steps_done
            self._event_count[:] = 0
            self._crossing_count[:] = 0
            self._steps_done += verlet.verlet_steps(
                self.n_blocks,
                start,
                min(self._chunk_steps, last - start),
                self.time_step,
                self._constants,
                self._belt_velocity * self.time_step,
                self._noise,
                self._noisy,
                self._state,
                self._wall_pull,
                self._streams,
                self._stride,
                self._first_sampled,
                self._samples,
                self._events,
                self._event_count,
                self._section_block,
                self._section_displacement,
                self._crossings,
                self._crossing_count,
            )
            self.time = self._steps_done * self.time_step
            self._check_state()
            first_row = start // self._stride + 1
            rows = self._steps_done // self._stride + 1 - first_row
            yield self._chunk(start * self.time_step, first_row, rows)

    def _displacements(self):
        return verlet.of_blocks(self._state, verlet.DISPLACEMENT, self.n_blocks)

    def _relative_velocities(self):
        # the kernel keeps it times the step
        return verlet.of_blocks(self._state, verlet.VELOCITY, self.n_blocks) / self.time_step

    def _friction_losses(self):
        loss = verlet.of_blocks(self._state, verlet.DISSIPATED, self.n_blocks)
        return loss / self.time_step**2

    def _wall_impulses(self):
        return self._wall_pull * self.time_step

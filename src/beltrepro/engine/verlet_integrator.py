"""Many chains advanced by the paper's scheme, in leaps or step for step."""

import math

import numpy as np

from beltrepro.engine import leaps
from beltrepro.engine.integrator import TOLERANCE, Integrator, force_unit
from beltrepro.engine.law import of_blocks
from beltrepro.engine.simd import LANES
from beltrepro.engine.vector import zeros
from beltrepro.model import ChainParameters
from beltrepro.model.friction import kinetic_friction

# Largest (dt omega)^2 at which leaps reproduce the steps to below the rounding of a plain loop; and
# that up to which leaps are taken in a run, where impacts compress springs further for a short
# time.
_LEAP_LIMIT = 1e-4
_IMPACT_LIMIT = 2.5e-4
_BELOW, _SWING = 0.995, 0.2  # share of the step that is not stable; phase of a swing in a step
_FREQUENCY = 4.0  # omega^2 of a long chain, over the slope of the tension of its springs


def longest_step(chain: ChainParameters) -> float:
    """Longest step at which the scheme is stable where springs are linear and blocks slip.

    Nor is it longer for the fastest swing than 0.1 is in the paper's chain.
    """
    # unstable where w^2 dt^2 + g dt / 0.15 = 4, with the largest frequency w and the damping g of a
    # block; Gershgorin's theorem bounds w^2
    springs, mass = chain.by_block("stiffness"), chain.by_block("mass")
    squares = 2 * (springs + np.append(springs[1:], 0.0))
    squares[0] -= springs[0]
    damping = chain.viscosity / mass
    stable = 1.2 / (damping + np.sqrt(damping**2 + 0.36 * squares / mass))
    return float(np.minimum(_BELOW * stable, _SWING / np.sqrt(squares / mass)).min())


class VerletIntegrator(Integrator):
    """Chains integrated by the scheme of the Appendix (`beltrepro.engine.leaps`).

    Parameters as for `Integrator`, and literal : whether every step is taken literally. If it is
    not given, many steps are taken at a leap where that gives the same numbers.
    """

    _scheme_fields = ("slip_step", "acceleration")

    def __init__(self, states, *, literal: bool | None = None, **settings):
        super().__init__(states, **settings)
        if literal is None:
            literal = not self._can_leap()
        self.name = "literal verlet" if literal else "leaping verlet"
        self._kernel = leaps.literal_steps if literal else leaps.leap_steps
        lanes, noise = len(self._noise), None
        if np.any(self._noise > 0):
            deviates = zeros((self.n_blocks + self.n_blocks % 2) * LANES)
            noise = leaps.Noise(self._noise, self._streams, deviates)
        self._chains = self._new_chains(
            leaps.SchemeChains, steps_done=zeros(lanes), wall_impulse=zeros(lanes)
        )
        self._group = leaps.SchemeGroup(
            law=self._law,
            varied=of_blocks(self.parameters[0]) if literal else None,
            belt_velocity=self._belt_velocity,
            time_step=self.time_step,
            log_tolerance=math.log2(TOLERANCE * force_unit(self.parameters[0])),
            stiffest=_IMPACT_LIMIT / (_FREQUENCY * self.time_step**2),
            chains=self._chains,
            noise=noise,
        )
        self._scratch = leaps.new_scratch(self.n_blocks)
        self._velocity_unit = self.time_step
        self._start_from(states)

    def _can_leap(self) -> bool:
        """Whether they have the paper's law, no noise, and a time step as short as the paper's."""
        chain = self.parameters[0]
        if chain.varied or np.any(self._noise > 0):
            return False
        # the stiffest spring that friction can hold: on the compressed branch, or the stretched one
        rate = max(chain.compression_rate, chain.extension_rate)
        stiffest = 1 + rate * chain.static_friction
        return self.time_step**2 * _FREQUENCY * stiffest <= _LEAP_LIMIT

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

    def _run(self, until):
        start = self._step(self.time)
        # half a step on: the end of the last chunk may have been rounded down
        end = self._chunk_end((start + 0.5) * self.time_step)
        n_steps = min(self._step(until), self._step(end)) - start
        stride = self._sampling.steps
        first = (start // stride + 1) * stride - start
        self._chains.steps_done[:] = 0.0
        self._chains.steps_done[self._width :] = n_steps
        self._advance(
            lambda records: self._kernel(start, n_steps, self._group, self._scratch, records),
            float(first),
            float(stride),
            (n_steps - first) // stride + 1,
        )
        return (start + n_steps) * self.time_step

    def _reached(self, lane):
        return float(self.time + self._chains.steps_done[lane] * self.time_step)

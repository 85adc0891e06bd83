"""One chain without noise by a general solver that locates events: SciPy's solve_ivp.

Between two events the motion is smooth. A slipping block has an event where its velocity relative
to the belt returns to zero, a stuck one where |F_ex| reaches F_st. SciPy steps over the kinks of
the spring law, and its error control shortens the steps there.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

from beltrepro.base.errors import ModelStateError
from beltrepro.extras.bench.plain import (
    DIRECTION,
    POSITION,
    REST_LENGTH,
    VELOCITY,
    PlainChain,
    spring_force,
)
from beltrepro.model.friction import next_direction
from beltrepro.model.spring import external_force

METHOD = "DOP853"
TOLERANCE = 1e-9  # relative and absolute
_MISSED = 1e-7  # an event function below minus this has passed its event
_SHORTEST = 1e-6  # model time


class SolveIvpChain:
    """One chain without noise advanced by `solve_ivp`, piece by piece from event to event."""

    chains = 1

    def __init__(self, start: PlainChain):
        chain = self.parameters = start.parameters
        # with the events done that the scheme does one step late
        velocity, before = start.state[VELOCITY].copy(), start.state[DIRECTION]
        relative = velocity - chain.belt_velocity
        forces = external_force(start.state[POSITION], chain)
        self.direction = next_direction(before, relative, forces, chain.static_friction)
        velocity[before * relative <= 0] = chain.belt_velocity
        self._state = np.concatenate([start.state[POSITION], velocity])
        self.time = 0.0

    @property
    def positions(self) -> np.ndarray:
        """Positions (N,) of the blocks now, laboratory frame."""
        return self._state[: self.parameters.n_blocks]

    def advance(self, span: float) -> None:
        """Advance by `span` of model time."""
        end = self.time + span
        while self.time < end:
            piece = self._piece(end)
            self.time = float(piece.t[-1])
            self._state = piece.y[:, -1].copy()
            for block, instants in enumerate(piece.t_events):
                if len(instants):
                    self._turn(block)

    def _piece(self, end):
        """The motion to the next event, or to `end`.

        solve_ivp looks at event functions at the ends of its steps, and misses one that goes below
        zero and comes back. If the piece ends in between, it is done again in shorter steps. A
        pair of events within one step stays unseen.
        """
        events = [self._event(block) for block in range(self.parameters.n_blocks)]
        longest = np.inf
        while True:
            control = {"max_step": longest, "rtol": TOLERANCE, "atol": TOLERANCE}
            span, motion = (self.time, end), self._motion()
            piece = solve_ivp(motion, span, self._state, method=METHOD, events=events, **control)
            lowest = min(event(piece.t[-1], piece.y[:, -1]) for event in events)
            if piece.status < 0 or longest < _SHORTEST:
                raise ModelStateError(f"{self.parameters.describe()}: solve_ivp: {piece.message}")
            if lowest > -_MISSED:
                return piece
            longest = np.diff(piece.t).max() / 4

    def _turn(self, block):
        chain = self.parameters
        force = _external_force(self.positions, block, chain.n_blocks)
        if self.direction[block]:
            turned = next_direction(self.direction[block], 0.0, force, chain.static_friction)
        else:
            turned = math.copysign(1.0, force)
        self.direction[block] = turned
        self._state[chain.n_blocks + block] = chain.belt_velocity

    def _motion(self):
        chain = self.parameters
        n_blocks = chain.n_blocks
        moving = (self.direction != 0).astype(float)
        kinetic = self.direction * (chain.friction_ratio * chain.static_friction)

        def motion(time, state):
            force = external_force(state[:n_blocks], chain) - kinetic
            return np.concatenate([state[n_blocks:], moving * force])

        return motion

    def _event(self, block):
        chain = self.parameters
        direction, velocity = self.direction[block], chain.n_blocks + block
        if direction:

            def event(time, state):
                return direction * (state[velocity] - chain.belt_velocity)
        else:

            def event(time, state):
                return chain.static_friction - abs(_external_force(state, block, chain.n_blocks))

        event.terminal, event.direction = True, -1
        return event


def _external_force(positions, block, n_blocks) -> float:
    """F_ex on one block (Eq. 1): the solver spends its time here, so without arrays."""
    before = positions[block - 1] if block else 0.0
    force = spring_force(positions[block] - before - REST_LENGTH)
    if block + 1 < n_blocks:
        force -= spring_force(positions[block + 1] - positions[block] - REST_LENGTH)
    return force

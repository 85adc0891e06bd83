"""One chain without noise by general solvers that locate events: SciPy's solve_ivp, and heyoka.

Between two events the motion is smooth. A slipping block has an event where its velocity relative
to the belt returns to zero, a stuck one where |F_ex| reaches F_st. SciPy steps over the kinks of
the spring law, and its error control shortens the steps there. A Taylor series does not hold across
a kink, so heyoka also stops where a spring changes its branch.
"""

import importlib
import math

import numpy as np

from beltrepro.base.errors import ModelStateError
from beltrepro.extras.bench.plain import DIRECTION, POSITION, VELOCITY, PlainChain
from beltrepro.model import ChainParameters
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
        from scipy.integrate import solve_ivp

        self._solve = solve_ivp
        self.parameters = start.parameters
        self._state, self.direction = _begin(start)
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
        pair of events within one step stays unseen; heyoka finds it.
        """
        events = [self._event(block) for block in range(self.parameters.n_blocks)]
        longest = np.inf
        while True:
            piece = self._solve(
                self._motion(),
                (self.time, end),
                self._state,
                method=METHOD,
                events=events,
                max_step=longest,
                rtol=TOLERANCE,
                atol=TOLERANCE,
            )
            lowest = min(event(piece.t[-1], piece.y[:, -1]) for event in events)
            if piece.status < 0 or longest < _SHORTEST:
                raise ModelStateError(f"{self.parameters.describe()}: solve_ivp: {piece.message}")
            if lowest > -_MISSED:
                return piece
            longest = np.diff(piece.t).max() / 4

    def _turn(self, block):
        chain = self.parameters
        force = _external_force(self.positions, block, chain)
        self.direction[block] = _turned(self.direction[block], force, chain)
        self._state[chain.n_blocks + block] = chain.belt_velocity

    def _motion(self):
        chain = self.parameters
        n_blocks = chain.n_blocks
        moving = (self.direction != 0).astype(float)
        kinetic = self.direction * (chain.friction_ratio * chain.static_friction)
        limit, rest = chain.linear_limit, chain.rest_length
        compression, extension = chain.compression_rate, chain.extension_rate

        def motion(time, state):
            deformation = state[:n_blocks] - rest
            deformation[1:] -= state[: n_blocks - 1]
            size = np.abs(deformation)
            linear = np.minimum(size, limit)
            rate = np.where(deformation < 0, compression, extension)
            tension = np.copysign(linear + np.expm1(rate * (size - linear)) / rate, deformation)
            force = -tension - kinetic
            force[:-1] += tension[1:]
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
                return chain.static_friction - abs(_external_force(state, block, chain))

        event.terminal, event.direction = True, -1
        return event


def heyoka_version() -> str | None:
    """Version of heyoka, None if it cannot be imported."""
    try:
        return importlib.import_module("heyoka").__version__
    except ImportError:
        return None


class HeyokaChain:
    """One chain without noise advanced by heyoka's Taylor integrator with terminal events.

    Direction of slip and branch of the springs are parameters of one compiled integrator; the
    callbacks of the events change them.
    """

    chains = 1
    _PER_BLOCK = 8  # moving, direction, kinetic friction, and five constants of the spring's branch

    def __init__(self, start: PlainChain):
        heyoka = importlib.import_module("heyoka")
        chain = self.parameters = start.parameters
        n_blocks = chain.n_blocks
        state, self.direction = _begin(start)
        names = [f"{kind}{block}" for kind in "xv" for block in range(n_blocks)]
        variables = heyoka.make_vars(*names)
        x, v = variables[:n_blocks], variables[n_blocks:]
        at = [
            [heyoka.par[self._PER_BLOCK * block + number] for number in range(self._PER_BLOCK)]
            for block in range(n_blocks)
        ]
        stretches = [x[i] - (x[i - 1] if i else 0.0) - chain.rest_length for i in range(n_blocks)]
        tensions = [
            slope * stretch + factor * heyoka.exp(rate * stretch + offset) + constant
            for stretch, (_, _, _, slope, factor, rate, offset, constant) in zip(
                stretches, at, strict=True
            )
        ]
        pulls = [b - a for a, b in zip(tensions, [*tensions[1:], 0.0], strict=True)]
        system, events = [(place, velocity) for place, velocity in zip(x, v, strict=True)], []
        falling = heyoka.event_direction.negative
        for block, (moving, direction, kinetic, *_) in enumerate(at):
            system.append((v[block], moving * (pulls[block] - kinetic)))
            slip = direction * (v[block] - chain.belt_velocity)
            stick = chain.static_friction**2 - pulls[block] * pulls[block]
            function = moving * slip + (1.0 - moving) * stick
            events.append(heyoka.t_event(function, callback=self._turns(block), direction=falling))
            kink = stretches[block] * stretches[block] - chain.linear_limit**2
            events.append(heyoka.t_event(kink, callback=self._bends(block)))
        parameters = np.zeros(self._PER_BLOCK * n_blocks)
        self._integrator = heyoka.taylor_adaptive(
            system, state, pars=parameters, t_events=events, compact_mode=True
        )
        positions = start.state[POSITION]
        deformations = np.diff(positions, prepend=0.0) - chain.rest_length
        for block, deformation in enumerate(deformations):
            self._set_direction(self._integrator, block)
            outside = abs(deformation) > chain.linear_limit
            self._set_branch(self._integrator, block, np.sign(deformation) * outside)

    @property
    def positions(self) -> np.ndarray:
        """Positions (N,) of the blocks now, laboratory frame."""
        return self._integrator.state[: self.parameters.n_blocks].copy()

    def advance(self, span: float) -> None:
        """Advance by `span` of model time."""
        outcome = self._integrator.propagate_for(span)[0]
        if not np.all(np.isfinite(self._integrator.state)):
            raise ModelStateError(f"{self.parameters.describe()}: heyoka: {outcome}")

    def _turns(self, block):
        chain = self.parameters

        def callback(integrator, sign):
            force = _external_force(integrator.state, block, chain)
            self.direction[block] = _turned(self.direction[block], force, chain)
            integrator.state[chain.n_blocks + block] = chain.belt_velocity
            self._set_direction(integrator, block)
            return True

        return callback

    def _bends(self, block):
        def callback(integrator, sign):
            x = integrator.state
            deformation = x[block] - (x[block - 1] if block else 0.0) - self.parameters.rest_length
            self._set_branch(integrator, block, math.copysign(1.0, deformation) if sign > 0 else 0)
            return True

        return callback

    def _set_direction(self, integrator, block):
        chain, direction = self.parameters, self.direction[block]
        kinetic = direction * chain.friction_ratio * chain.static_friction
        first = self._PER_BLOCK * block
        integrator.pars[first : first + 3] = (direction != 0, direction, kinetic)

    def _set_branch(self, integrator, block, branch):
        chain, limit = self.parameters, self.parameters.linear_limit
        if branch == 0:
            constants = (1.0, 0.0, 0.0, 0.0, 0.0)
        elif branch > 0:
            rate = chain.extension_rate
            constants = (0.0, 1 / rate, rate, -rate * limit, limit - 1 / rate)
        else:
            rate = chain.compression_rate
            constants = (0.0, -1 / rate, -rate, -rate * limit, -(limit - 1 / rate))
        first = self._PER_BLOCK * block + 3
        integrator.pars[first : first + 5] = constants


def _begin(start: PlainChain):
    """State (2N,) and directions (N,), with the events done that the scheme does one step late."""
    chain = start.parameters
    velocity, before = start.state[VELOCITY].copy(), start.state[DIRECTION]
    relative = velocity - chain.belt_velocity
    forces = external_force(start.state[POSITION], chain)
    direction = next_direction(before, relative, forces, chain.static_friction)
    velocity[before * relative <= 0] = chain.belt_velocity
    return np.concatenate([start.state[POSITION], velocity]), direction


def _turned(direction, force, chain):
    """Direction of a block after its event; a stuck one has reached its threshold."""
    if direction == 0:
        return math.copysign(1.0, force)
    return float(next_direction(direction, 0.0, force, chain.static_friction))


def _external_force(positions, block, chain: ChainParameters) -> float:
    """F_ex on one block (Eq. 1): the solvers spend their time here, so without arrays."""
    before = positions[block - 1] if block else 0.0
    force = -_tension(positions[block] - before - chain.rest_length, chain)
    if block + 1 < chain.n_blocks:
        force += _tension(positions[block + 1] - positions[block] - chain.rest_length, chain)
    return force


def _tension(deformation, chain):
    size = abs(deformation)
    if size > chain.linear_limit:
        rate = chain.compression_rate if deformation < 0 else chain.extension_rate
        size = chain.linear_limit + math.expm1(rate * (size - chain.linear_limit)) / rate
    return math.copysign(size, deformation)

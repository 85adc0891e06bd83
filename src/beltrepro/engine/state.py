"""The state of one chain as a value: all that it needs to go on."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.engine.noise import normal_deviates, stream_key, stream_states
from beltrepro.engine.simd import LANES
from beltrepro.engine.vector import zeros
from beltrepro.model import ChainParameters
from beltrepro.model.friction import kinetic_friction, next_direction
from beltrepro.model.parameters import LONGEST, check_chain
from beltrepro.model.spring import external_force, potential_energy, spring_extension

_BALANCED = 3  # purpose of a random stream: states at the balance, not friction or other starts
_HELD = 1 - 1e-6  # of a threshold: what holds against more has no stuck state at the balance


@dataclass(frozen=True, eq=False)
class Scheme:
    """What an integrator needs beside the physical state to go on with the same bits."""

    integrator: str  # name of the integrator that these are the variables of
    time_step: float  # dt, on which they depend
    variables: dict[str, np.ndarray] = field(repr=False)  # as the integrator names them


@dataclass(frozen=True, eq=False, repr=False)
class ChainState:
    """A chain at one instant, in model units: a run can begin here.

    Made by `Run.final_state`, from positions and velocities by `at_rest` and `in_motion`, or at
    random by `at_balance`. To move the blocks of a state, use `moved`.

    Attributes
    ----------
    parameters : ChainParameters
        The chain.
    time : float
        Instant, counted from the start of the first run.
    displacements : array (N,)
        Of the blocks from their rest positions.
    relative_velocities : array (N,)
        Of the blocks to the belt, exactly 0 while stuck.
    directions : array (N,)
        Of the slip over the belt: -1, 1, or 0 while stuck.
    thresholds : array (N,)
        Static friction force F_st, drawn when the block stuck last.
    friction_losses : array (N,)
        Friction force times slip since the energy audit began.
    wall_impulse : float
        Integral of the first spring's pull since then.
    initial_energy, initial_momentum : float
        Of the chain when the audit began: at t = 0, or when its parameters changed last.
    seed, replicate : int
        What the random stream was keyed by.
    stream : array (4,) of uint64
        The random stream as it is now.
    scheme : Scheme or None
        Variables of the integrator that made the state, the noise cell of "event" among them. Where
        another one goes on they are made anew from the rest.
    """

    parameters: ChainParameters
    time: float
    displacements: np.ndarray
    relative_velocities: np.ndarray
    directions: np.ndarray
    thresholds: np.ndarray
    friction_losses: np.ndarray
    wall_impulse: float
    initial_energy: float
    initial_momentum: float
    seed: int
    replicate: int
    stream: np.ndarray
    scheme: Scheme | None = None

    def __post_init__(self) -> None:
        if not math.isfinite(self.initial_energy):
            raise InputError(
                f"positions = {self.positions.tolist()}, velocities = {self.velocities.tolist()}: "
                "the energy of such a state is beyond all numbers"
            )

    @classmethod
    @names.checked
    def at_rest(
        cls,
        parameters: ChainParameters,
        positions: ArrayLike | None = None,
        *,
        time: float = 0.0,
        seed: int = 1,
        replicate: int = 0,
    ) -> ChainState:
        """The state in which a run begins: all blocks stuck to the belt (Sec. III).

        Parameters
        ----------
        parameters : ChainParameters
            The chain.
        positions : array (N,)
            Of the blocks, model length; undeformed springs if not given.
        time : float
            Instant, model time.
        seed, replicate : int
            Key of the random stream, with the parameters; the thresholds are its first numbers.

        Returns
        -------
        ChainState
            From which a run can begin.

        Raises
        ------
        InputError
            The positions are not N increasing numbers, or another value is not allowed.
        """
        check_chain(parameters)
        if positions is not None:
            positions = checks.positions("positions", positions, parameters.n_blocks)
        key = [checks.key("seed", seed)], [checks.key("replicate", replicate)]
        time = checks.not_negative("time", time, LONGEST)
        return states_at_rest([parameters], [positions], *key, time)[0]

    @classmethod
    @names.checked
    def in_motion(
        cls,
        parameters: ChainParameters,
        positions: ArrayLike | None = None,
        velocities: ArrayLike | None = None,
        *,
        time: float = 0.0,
        seed: int = 1,
        replicate: int = 0,
    ) -> ChainState:
        """A state of given positions and velocities: all slips but at the velocity of the belt.

        Parameters
        ----------
        parameters, positions : as for `at_rest`
            The chain, and where its blocks are.
        velocities : array (N,)
            Of the blocks in the laboratory frame, model velocity; that of the belt if not given. A
            block with exactly that is stuck, and slips at once if F_ex is beyond its threshold.
        time, seed, replicate : as for `at_rest`
            When, and the key of the random stream.

        Returns
        -------
        ChainState
            From which a run can begin.

        Raises
        ------
        InputError
            A value is not allowed, as in `at_rest`, or the velocities are not N numbers.
        """
        state = cls.at_rest(parameters, positions, time=time, seed=seed, replicate=replicate)
        return state if velocities is None else state.moved(velocities=velocities)

    @classmethod
    @names.checked
    def at_balance(
        cls,
        parameters: ChainParameters,
        *,
        spread: float = 1.0,
        time: float = 0.0,
        seed: int = 1,
        replicate: int = 0,
    ) -> ChainState:
        """All blocks stuck near the balance of springs and friction: a start that needs no loading.

        The springs pull block i back by F_st,i (f + spread (1 - f) q_i), with f its kinetic over
        its static friction and q_i random, uniform from -1 to 1. On average that is kinetic
        friction, as in stationary motion. With a spread of 1 the pulls are distributed as that on
        a single block on a slow belt, which each slip takes from F_st to 2 F_k - F_st.

        What a run must leave out is short beside loading. But the warning about loading counts from
        undeformed springs: a run that is shorter than they take is watched, and a slow swing in it
        may be told as loading. The transient that the warning names is that of this start.

        Parameters
        ----------
        parameters : ChainParameters
            The chain.
        spread : float
            Half the width of the distribution of the pulls over F_st - F_k, 0 to 1.
        time, seed, replicate : as for `at_rest`
            When, and the key of the pulls and of the random stream.

        Returns
        -------
        ChainState
            From which a run can begin. No block slips at once, unless its threshold is below 0.

        Raises
        ------
        InputError
            A value is not allowed, or blocks would begin on the wrong side of each other.
        """
        spread = checks.within("spread", spread, ge=0, le=1)
        state = cls.at_rest(parameters, time=time, seed=seed, replicate=replicate)
        kinetic = kinetic_friction(parameters, parameters.belt_velocity)
        share = np.minimum(kinetic / parameters.by_block("static_friction"), _HELD)
        key = stream_key(parameters, state.seed, state.replicate, _BALANCED)
        random = np.random.default_rng(key).uniform(-1.0, 1.0, parameters.n_blocks)
        share = share + spread * (1 - share) * random
        # each spring holds all blocks beyond it
        tension = np.cumsum((share * np.maximum(state.thresholds, 0.0))[::-1])[::-1]
        lengths = np.asarray(parameters.rest_length) + spring_extension(tension, parameters)
        if not np.all(lengths > 0):
            where = f"springs as short as rest_length = {np.min(parameters.rest_length):g} let"
            raise InputError(f"spread = {spread:g}: {where} blocks begin beyond each other")
        return state.moved(np.cumsum(lengths))

    @property
    def positions(self) -> np.ndarray:
        """Positions (N,) of the blocks in the laboratory frame, model length."""
        return self.displacements + self.parameters.rest_positions

    @property
    def velocities(self) -> np.ndarray:
        """Velocities (N,) of the blocks in the laboratory frame, model velocity."""
        return self.relative_velocities + self.parameters.belt_velocity

    @property
    def forces(self) -> np.ndarray:
        """External force F_ex (N,) on the blocks (Eq. 1), unit of force."""
        return external_force(self.positions, self.parameters)

    @names.checked
    def moved(
        self, positions: ArrayLike | None = None, velocities: ArrayLike | None = None
    ) -> ChainState:
        """This state with other positions or velocities; the energy audit begins anew.

        Parameters
        ----------
        positions : array (N,)
            In the laboratory frame, model length; as they are if not given.
        velocities : array (N,)
            In the laboratory frame, model velocity; as they are if not given. A block with exactly
            the velocity of the belt is stuck.

        Returns
        -------
        ChainState
            At the same time, with the same random stream.

        Raises
        ------
        InputError
            The positions are not N increasing numbers, or the velocities not N numbers.
        """
        rest, changes = self.parameters.rest_positions, {}
        if positions is not None:
            positions = checks.positions("positions", positions, len(rest))
            changes["displacements"] = positions - rest
        if velocities is not None:
            velocities = checks.numbers("velocities", velocities, len(rest))
            relative = velocities - self.parameters.belt_velocity
            changes |= {"relative_velocities": relative, "directions": np.sign(relative)}
        return self._audited_anew(**changes)

    @names.checked
    def under(self, parameters: ChainParameters) -> ChainState:
        """This state as one of a chain with other parameters, for instance another belt velocity.

        Stuck blocks stay on the belt, slipping ones keep their velocity in the laboratory frame.
        A threshold keeps its deviation from the mean, in units of the noise. The random stream goes
        on; the energy audit begins anew.

        Parameters
        ----------
        parameters : ChainParameters
            Of as many blocks.

        Returns
        -------
        ChainState
            The same one if the parameters are.

        Raises
        ------
        InputError
            It is none, or the number of blocks is another.
        """
        check_chain(parameters)
        old = self.parameters
        if parameters == old:
            return self
        if parameters.n_blocks != old.n_blocks:
            raise InputError(
                f"initial_state of {old.n_blocks} blocks: "
                f"a chain of n_blocks = {parameters.n_blocks} needs a state of as many"
            )
        if not np.isfinite(self.displacements).all():  # a chain that has failed stays so
            return dataclasses.replace(self, parameters=parameters, scheme=None)
        slips = self.directions != 0
        relative = np.where(slips, self.velocities - parameters.belt_velocity, 0.0)
        thresholds = self.thresholds
        if (old.static_friction, old.noise) != (parameters.static_friction, parameters.noise):
            deviates = 0.0
            if old.noise > 0:
                deviates = (thresholds - np.asarray(old.static_friction)) / old.noise
            thresholds = parameters.by_block("static_friction") + parameters.noise * deviates
        return self._audited_anew(
            parameters=parameters,
            displacements=self.positions - parameters.rest_positions,
            relative_velocities=relative,
            directions=np.sign(relative),
            thresholds=thresholds,
        )

    @names.checked
    def keyed(self, seed: int, replicate: int) -> ChainState:
        """This state with the random stream of another seed or replicate, from its beginning.

        Parameters
        ----------
        seed, replicate : int
            Of 0 or greater. With those of the state the stream goes on where it is.

        Returns
        -------
        ChainState
            The same one if the key is.

        Raises
        ------
        InputError
            A value is not allowed.
        """
        seed, replicate = checks.key("seed", seed), checks.key("replicate", replicate)
        if (seed, replicate) == (self.seed, self.replicate):
            return self
        (stream,), _ = _drawn([self.parameters], [seed], [replicate])
        return dataclasses.replace(self, seed=seed, replicate=replicate, stream=stream)

    def _audited_anew(self, **changes: Any) -> ChainState:
        """This state with some changes; the energy audit begins with it."""
        state = dataclasses.replace(self, **changes, scheme=None)
        speed, relative = state.parameters.belt_velocity, state.relative_velocities
        energy, momentum = _audit(state.parameters, speed, state.positions, relative)
        return dataclasses.replace(
            state,
            friction_losses=np.zeros(len(relative)),
            wall_impulse=0.0,
            initial_energy=float(energy),
            initial_momentum=float(momentum),
        )

    def __repr__(self) -> str:
        slipping = int(np.count_nonzero(self.directions))
        return f"ChainState({self.parameters.describe()}, t={self.time:g}, {slipping} slipping)"

    def __eq__(self, other: object) -> bool:
        """Whether all numbers are the same bit by bit."""
        return isinstance(other, ChainState) and equal_fields(self, other)


def states_at_rest(
    chains: Sequence[ChainParameters],
    positions: Sequence[np.ndarray | None],
    seeds: Sequence[int],
    replicates: Sequence[int],
    time: float = 0.0,
) -> list[ChainState]:
    """States in which all blocks of some chains are stuck, made together: see `at_rest`."""
    states: dict[int, ChainState] = {}
    alike: dict[tuple, list[int]] = {}
    for number, chain in enumerate(chains):
        alike.setdefault((chain.n_blocks, chain.law), []).append(number)
    for numbers in alike.values():
        members = [chains[number] for number in numbers]
        key = [seeds[number] for number in numbers], [replicates[number] for number in numbers]
        streams, thresholds = _drawn(members, *key)
        n_blocks, rest = members[0].n_blocks, members[0].rest_positions
        begin = np.array([rest if positions[i] is None else positions[i] for i in numbers]) - rest
        speeds = np.array([chain.belt_velocity for chain in members])
        energies, momenta = _audit(members[0], speeds, begin + rest, np.zeros_like(begin))
        for row, number in enumerate(numbers):
            states[number] = ChainState(
                chains[number],
                time,
                begin[row],
                *np.zeros((2, n_blocks)),
                thresholds[row],
                np.zeros(n_blocks),
                0.0,
                float(energies[row]),
                float(momenta[row]),
                seeds[number],
                replicates[number],
                streams[row],
            )
    return [states[number] for number in range(len(chains))]


def _audit(chain: ChainParameters, speed, positions, relative_velocities):
    """Energy and momentum of states (..., N) of chains of one law, at belt velocities (...)."""
    mass = chain.by_block("mass")
    total = mass.sum()
    # in the frame of the belt first: for blocks at rest there the sums round like a product
    slip = (mass * relative_velocities).sum(axis=-1)
    with np.errstate(over="ignore"):
        slipping = speed * slip + (mass * relative_velocities**2).sum(axis=-1) / 2
        energy = potential_energy(positions, chain) + (total * (speed * speed) / 2 + slipping)
    return energy, total * speed + slip


def settled(directions, relative_velocities, forces, thresholds) -> tuple[np.ndarray, np.ndarray]:
    """Directions and relative velocities of blocks, the stick and slip rules applied.

    A scheme in steps may hold a block that is to turn in the next step: it slips one way and
    already moves the other.
    """
    turning = (directions != 0) & (directions * relative_velocities <= 0)
    ruled = next_direction(directions, relative_velocities, forces, thresholds)
    directions = np.where(turning, ruled, directions)
    return directions, np.where(directions * relative_velocities <= 0, 0.0, relative_velocities)


def equal_fields(one, other) -> bool:
    """Whether two values of one dataclass agree in every field, numbers bit by bit."""
    return all(_same(getattr(one, field.name), getattr(other, field.name)) for field in fields(one))


def _same(one, other) -> bool:
    if isinstance(one, Scheme) and isinstance(other, Scheme):
        return equal_fields(one, other)
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[name], other[name]) for name in one)
    if isinstance(one, np.ndarray | float):  # NaN is NaN
        one, other = np.asarray(one), np.asarray(other)
        alike = (one.dtype, one.shape) == (other.dtype, other.shape)
        return alike and one.tobytes() == other.tobytes()
    return one == other


def _drawn(chains: Sequence[ChainParameters], seeds, replicates) -> tuple[np.ndarray, np.ndarray]:
    """New streams (W, 4) of chains of N blocks, and the thresholds (W, N), their first numbers."""
    width, n_blocks = len(chains), chains[0].n_blocks
    lanes = -(-width // LANES) * LANES
    streams, normals = zeros((4, lanes), np.uint64), zeros((n_blocks + n_blocks % 2, lanes))
    streams[:, :width] = stream_states(chains, seeds, replicates)
    normal_deviates(streams, normals)
    noise = np.array([[chain.noise] for chain in chains])
    thresholds = np.asarray(chains[0].static_friction) + noise * normals[:n_blocks, :width].T
    return np.ascontiguousarray(streams[:, :width].T), np.ascontiguousarray(thresholds)

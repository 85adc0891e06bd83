"""The state of one chain as a value: all that it needs to go on."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.engine.noise import normal_deviates, stream_states
from beltrepro.engine.simd import LANES
from beltrepro.engine.vector import aligned, zeros
from beltrepro.model import ChainParameters
from beltrepro.model.friction import next_direction
from beltrepro.model.parameters import LONGEST
from beltrepro.model.spring import external_force, potential_energy


@dataclass(frozen=True, eq=False)
class Scheme:
    """What an integrator needs beside the physical state to go on with the same bits."""

    integrator: str  # name of the integrator that these are the variables of
    time_step: float  # dt, on which they depend
    variables: dict[str, np.ndarray]  # by the names that the integrator gives them

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scheme):
            return NotImplemented
        return equal_fields(self, other)


@dataclass(frozen=True, eq=False, repr=False)
class ChainState:
    """A chain at one instant, in model units: a run can begin here.

    Made by `Run.final_state`, or from positions and velocities by `at_rest` and `in_motion`. To
    move the blocks of a state, use `moved`.

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
        return cls.in_motion(parameters, positions, None, time=time, seed=seed, replicate=replicate)

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
        """A state of given positions and velocities.

        A block with exactly the velocity of the belt is stuck; it slips at once if the external
        force is beyond its threshold. All others slip.

        Parameters
        ----------
        parameters : ChainParameters
            The chain.
        positions : array (N,)
            Of the blocks, model length; undeformed springs if not given.
        velocities : array (N,)
            Of the blocks in the laboratory frame, model velocity; that of the belt if not given.
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
            The positions are not N increasing numbers, the velocities not N numbers, or another
            value is not allowed.
        """
        _check_chain(parameters)
        rest = parameters.rest_positions
        if positions is not None:
            positions = checks.positions("positions", positions, len(rest))
        seed, replicate = checks.key("seed", seed), checks.key("replicate", replicate)
        stream, thresholds = _drawn(parameters, seed, replicate)
        state = cls(
            parameters=parameters,
            time=checks.not_negative("time", time, LONGEST),
            displacements=np.zeros_like(rest) if positions is None else positions - rest,
            relative_velocities=np.zeros_like(rest),
            directions=np.zeros_like(rest),
            thresholds=thresholds,
            friction_losses=np.zeros_like(rest),
            wall_impulse=0.0,
            initial_energy=0.0,
            initial_momentum=0.0,
            seed=seed,
            replicate=replicate,
            stream=stream,
        )
        return state.moved(velocities=velocities)

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
        rest = self.parameters.rest_positions
        displacements, relative = self.displacements, self.relative_velocities
        if positions is not None:
            displacements = checks.positions("positions", positions, len(rest)) - rest
        if velocities is not None:
            velocities = checks.numbers("velocities", velocities, len(rest))
            relative = velocities - self.parameters.belt_velocity
        directions = np.sign(relative) if velocities is not None else self.directions
        state = dataclasses.replace(
            self,
            displacements=displacements,
            relative_velocities=relative,
            directions=directions,
            scheme=None,
        )
        return state._audited_anew()

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
        _check_chain(parameters)
        old = self.parameters
        if parameters == old:
            return self
        if parameters.n_blocks != old.n_blocks:
            raise InputError(
                f"initial_state of {old.n_blocks} blocks: "
                f"a chain of n_blocks = {parameters.n_blocks} needs a state of as many"
            )
        slips = self.directions != 0
        relative = np.where(slips, self.velocities - parameters.belt_velocity, 0.0)
        deviates = (self.thresholds - old.static_friction) / old.noise if old.noise > 0 else 0.0
        thresholds = np.zeros(old.n_blocks) + parameters.static_friction
        thresholds += parameters.noise * deviates
        if (old.static_friction, old.noise) == (parameters.static_friction, parameters.noise):
            thresholds = self.thresholds
        state = dataclasses.replace(
            self,
            parameters=parameters,
            displacements=self.positions - parameters.rest_positions,
            relative_velocities=relative,
            directions=np.sign(relative),
            thresholds=thresholds,
            scheme=None,
        )
        return state._audited_anew()

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
        stream, _ = _drawn(self.parameters, seed, replicate)
        return dataclasses.replace(self, seed=seed, replicate=replicate, stream=stream)

    def _audited_anew(self) -> ChainState:
        # in the frame of the belt first: for blocks at rest there the sums round like a product
        speed, relative = self.parameters.belt_velocity, self.relative_velocities
        n_blocks, slip = len(relative), relative.sum()
        with np.errstate(over="ignore"):
            kinetic = n_blocks * speed**2 / 2 + (speed * slip + (relative**2).sum() / 2)
            energy = float(potential_energy(self.positions, self.parameters) + kinetic)
        if not np.isfinite(energy):
            raise InputError(
                f"positions = {self.positions.tolist()}, velocities = {self.velocities.tolist()}: "
                "the energy of such a state is beyond all numbers"
            )
        return dataclasses.replace(
            self,
            friction_losses=np.zeros(n_blocks),
            wall_impulse=0.0,
            initial_energy=energy,
            initial_momentum=float(n_blocks * speed + slip),
        )

    def __repr__(self) -> str:
        slipping = int(np.count_nonzero(self.directions))
        return f"ChainState({self.parameters.describe()}, t={self.time:g}, {slipping} slipping)"

    def __eq__(self, other: object) -> bool:
        """Whether all numbers are the same bit by bit."""
        if not isinstance(other, ChainState):
            return NotImplemented
        return equal_fields(self, other)


def scheme_variables(
    state: ChainState, integrator: str, time_step: float
) -> dict[str, np.ndarray] | None:
    """Variables of the scheme, if that integrator made the state with that time step."""
    scheme = state.scheme
    if scheme and (scheme.integrator, scheme.time_step) == (integrator, time_step):
        return scheme.variables
    return None


def settled(state: ChainState) -> ChainState:
    """A state without variables of a scheme, the stick and slip rules applied.

    A scheme in steps may hold a block that is to turn in the next step: it slips one way and
    already moves the other.
    """
    relative = state.relative_velocities
    turning = (state.directions != 0) & (state.directions * relative <= 0)
    ruled = next_direction(state.directions, relative, state.forces, state.thresholds)
    directions = np.where(turning, ruled, state.directions)
    backwards = directions * relative <= 0
    return dataclasses.replace(
        state,
        directions=directions,
        relative_velocities=np.where(backwards, 0.0, relative),
        scheme=None,
    )


def equal_fields(one, other) -> bool:
    """Whether two values of one dataclass agree in every field, arrays bit by bit (NaN is NaN)."""
    return all(_same(getattr(one, field.name), getattr(other, field.name)) for field in fields(one))


def _same(one, other) -> bool:
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[name], other[name]) for name in one)
    if isinstance(one, np.ndarray) != isinstance(other, np.ndarray):
        return False
    if not isinstance(one, np.ndarray):
        return one == other or (one != one and other != other)
    if one.dtype != other.dtype or one.shape != other.shape:
        return False
    if one.dtype.names:
        return all(_same(one[name], other[name]) for name in one.dtype.names)
    return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


def _check_chain(value) -> None:
    """That a value is a chain."""
    if not isinstance(value, ChainParameters):
        raise InputError(f"parameters = {checks.shown(value)}: a ChainParameters is needed")


def _drawn(parameters: ChainParameters, seed: int, replicate: int):
    """A new stream (4,) of a chain, and the thresholds (N,) that are its first numbers."""
    n_blocks = parameters.n_blocks
    streams = aligned(np.repeat(stream_states([parameters], seed, [replicate]), LANES, axis=1))
    normals = zeros((n_blocks + n_blocks % 2, LANES))
    normal_deviates(streams, normals)
    thresholds = parameters.static_friction + parameters.noise * normals[:n_blocks, 0]
    return streams[:, 0].copy(), thresholds

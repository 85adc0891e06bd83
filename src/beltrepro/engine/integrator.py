"""Many chains advanced together: what the integrators have in common.

An integrator yields `Chunk`s: views of buffers that are overwritten by the next chunk, so the
memory of a run does not grow with its length. Observers (`beltrepro.observe`) read chunks.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from beltrepro.base.errors import ModelStateError
from beltrepro.engine.law import law_constants, of_blocks
from beltrepro.engine.noise import STATE_WORDS
from beltrepro.engine.records import (
    CONTACT,
    CROSSINGS_FULL,
    EVENT_FIELDS,
    EVENTS_FULL,
    Crossings,
    Events,
    Records,
    Samples,
)
from beltrepro.engine.simd import LANES
from beltrepro.engine.state import ChainState, Scheme, settled
from beltrepro.engine.vector import aligned, zeros
from beltrepro.model import ChainParameters
from beltrepro.model.energy import kinetic_energy
from beltrepro.model.spring import (
    acceleration,
    external_force,
    potential_energy,
)

GROUP_SIZE = 32  # chains advanced together, at most
CUT_TIME = 250.0  # chunks end at its multiples: a run that is cut there has the bits of the uncut
_CHUNK_SAMPLES = 4000  # about, at most
_ROUNDING = 1e-9  # share of a chunk or an interval by which an instant may miss a multiple
_UNSTABLE = "the time step is too long for springs so stiff: a shorter one is needed"
_FROM_NOTHING = 0.5  # of the energy that a chain had and got: more than that only a scheme makes
# Last terms of the series of F_ex allowed at the end of a step or a leap: the last, and the one
# before it. The first that is left out moves a position by less, by two powers of the step and a
# factor of some hundreds. Below 1e-11 only rounding is left of the error.
TOLERANCE = 1e-10  # in units of `force_unit`
_LARGEST_BUFFER = 2**30  # bytes; chunks of the longest chains need a tenth of that
_EVENTS, _CROSSINGS = 4096, 1024  # room for those of a chain in a chunk, to begin with


def force_unit(chain: ChainParameters) -> float:
    """Unit of the tolerance of a step: 1, or the static friction where that is less."""
    return min(1.0, float(chain.by_block("static_friction").max()))


@dataclass(frozen=True)
class Chunk:
    """What happened to W chains between two instants, all arrays views of shared buffers."""

    start: float  # model time
    end: float
    time: np.ndarray  # (S,) instants of the samples
    displacement: np.ndarray  # (S, B, W) of the last B blocks, from the rest positions
    relative_velocity: np.ndarray
    kinetic_friction: np.ndarray  # that of the mean F_st; of the noise if all blocks are sampled
    events: np.ndarray  # (W, E, 6), see `beltrepro.engine.records`; blocks from 0
    event_count: np.ndarray  # (W,)
    crossings: np.ndarray  # (W, C, 1+2N) time, displacements, relative velocities
    crossing_count: np.ndarray


@dataclass(frozen=True)
class Section:
    """Downward crossings to record: block (1-based) and one position for each chain (W,)."""

    block: int
    positions: np.ndarray


class Sampling(NamedTuple):
    """Samples are taken at the multiples of `steps` times `step`."""

    steps: int
    step: float  # model time

    @property
    def interval(self) -> float:
        """Model time between samples."""
        return self.steps * self.step


class Lanes(NamedTuple):
    """What chains do now, in whatever scheme; arrays (N, lanes), by the names of `ChainState`."""

    displacements: np.ndarray  # from the rest positions
    relative_velocities: np.ndarray
    directions: np.ndarray
    thresholds: np.ndarray
    friction_losses: np.ndarray  # friction force times slip since the audit began
    wall_impulse: np.ndarray  # (lanes,) integral of the first spring's pull since then


# what the kernels call them
_IN_KERNELS = ("displacement", "velocity", "direction", "threshold", "dissipated", "wall_impulse")


class Integrator:
    """W chains of equal n_blocks and law that go on from states of one time; for subclasses."""

    name: str  # of the variables that its states carry, see `Scheme`
    _chains: Any  # what its kernel knows of them: a named tuple of arrays (..., lanes)
    _scheme_fields: tuple[str, ...]  # of these, what only this scheme has
    _velocity_unit = 1.0  # what it keeps for the relative velocity 1

    def __init__(
        self,
        states: Sequence[ChainState],
        *,
        time_step: float,
        sampling: Sampling,
        sampled_blocks: int,
        section: Section | None = None,
    ):
        self.parameters = [state.parameters for state in states]
        first = self.parameters[0]
        self.n_blocks = first.n_blocks
        self.time_step = time_step
        self.time = 0.0  # model time reached
        self._width = len(states)
        self._sampling = sampling
        self._first_sampled = self.n_blocks - sampled_blocks
        # lanes that fill up the last vector hold the last chain as it begins, and stand still
        lanes = -(-self._width // LANES) * LANES
        self._source = np.minimum(np.arange(lanes), self._width - 1)
        chains = [self.parameters[lane] for lane in self._source]
        self._belt_velocity = aligned([chain.belt_velocity for chain in chains])
        self._noise = aligned([chain.noise for chain in chains])
        self._law, self._varied = law_constants(first), of_blocks(first) if first.varied else None
        self._streams = zeros((STATE_WORDS, lanes), dtype=np.uint64)
        parts = math.ceil(CUT_TIME / (_CHUNK_SAMPLES * sampling.interval))
        self._chunk_time = CUT_TIME / parts
        rows = math.ceil(self._chunk_time / sampling.interval) + 2
        # samples of a chain lie side by side: it writes where it has just written
        self._samples = zeros((3, sampled_blocks, lanes, rows))
        self._events = Events(
            rows=np.empty((lanes, max(_EVENTS, 8 * self.n_blocks), EVENT_FIELDS)),
            count=np.zeros(lanes, dtype=np.int64),
        )
        level = zeros(lanes)
        if section is not None:
            rest = first.rest_positions[section.block - 1]
            level[:] = section.positions[self._source] - rest
        self._crossings = Crossings(
            block=-1 if section is None else section.block - 1,
            level=level,
            rows=np.empty((lanes, _CROSSINGS, 1 + 2 * self.n_blocks)),
            count=np.zeros(lanes, dtype=np.int64),
        )

    # --- states ---

    def state(self) -> list[ChainState]:
        """The states of the W chains now."""
        now = self._lanes()._asdict() | {"stream": self._streams}
        states = []
        for lane, state in enumerate(self._begun):
            values = {name: array[..., lane].copy() for name, array in now.items()}
            values["wall_impulse"] = float(values["wall_impulse"])
            chains = self._chains._asdict()
            variables = {name: chains[name][..., lane].copy() for name in self._scheme_fields}
            scheme = Scheme(self.name, self.time_step, variables)
            states.append(dataclasses.replace(state, time=self.time, scheme=scheme, **values))
        return states

    def _start_from(self, states: Sequence[ChainState]) -> None:
        """Go on from states, as the last thing that a subclass does when it is made.

        A state that another integrator made, or this one with another time step, has no variables
        of this scheme: they are made from its positions, velocities and forces.
        """
        self._begun = list(states)
        for state in states:
            if not np.isfinite(state.displacements).all():
                raise ModelStateError(f"{state.parameters.describe()}: the chain has failed before")
        self.time = self._instant(states[0].time)
        columns = ([getattr(state, name) for state in states] for name in Lanes._fields)
        lanes = Lanes(*map(_stacked, columns))
        schemes = [state.scheme for state in states]
        made_here = [
            one is not None and (one.integrator, one.time_step) == (self.name, self.time_step)
            for one in schemes
        ]
        old = lanes.directions, lanes.relative_velocities
        new = settled(*old, self.forces_on(lanes), lanes.thresholds)
        directions, relative = (np.where(made_here, *pair) for pair in zip(old, new, strict=True))
        lanes = lanes._replace(directions=directions, relative_velocities=relative)
        variables = self._new_variables(lanes)
        for lane in np.flatnonzero(made_here):
            for name, values in schemes[lane].variables.items():
                variables[name][..., lane] = values
        named = dict(zip(_IN_KERNELS, lanes, strict=True))
        named["velocity"] = lanes.relative_velocities * self._velocity_unit
        for name, values in (named | variables).items():
            getattr(self._chains, name)[...] = values[..., self._source]
        self._streams[...] = _stacked([state.stream for state in states])[:, self._source]

    def forces_on(self, lanes, change=0.0):
        """External forces (N, W) on the blocks of W chains, moved by `change` (N, W)."""
        chain = self.parameters[0]
        positions = lanes.displacements + chain.rest_positions[:, None] + change
        return external_force(positions.T, chain).T

    def advance(self, until: float) -> Iterator[Chunk]:
        """Advance all chains to `until`, in steps to the nearest one, chunk by chunk."""
        until = self._instant(until)
        while self.time < until:
            start, first_row = self.time, self._rows(self.time) + 1
            self._events.count[:] = 0
            self._crossings.count[:] = 0
            end = self._run(until)
            self._check_state()
            self.time = end
            yield self._chunk(start, first_row, self._rows(self.time) + 1 - first_row)

    # --- what an integrator provides ---

    def _run(self, until: float) -> float:
        """Advance all chains by one chunk, at most to `until`; returns how far they are."""
        raise NotImplementedError

    def _new_variables(self, lanes: Lanes) -> dict[str, np.ndarray]:
        """Variables (..., W) of the scheme for W states that have none."""
        raise NotImplementedError

    def _reached(self, lane: int) -> float:
        """Instant that a chain has reached in the chunk under way."""
        raise NotImplementedError

    def _lanes(self) -> Lanes:
        """What all chains do now."""
        lanes = Lanes(*(getattr(self._chains, name) for name in _IN_KERNELS))
        return lanes._replace(relative_velocities=self._chains.velocity / self._velocity_unit)

    def _instant(self, time: float) -> float:
        """The instant nearest to `time` at which chains can be."""
        return float(time)

    def _rows(self, time: float) -> int:
        """Samples taken until `time`; one at that very instant counts, whatever it rounds to."""
        return math.floor(time / self._sampling.interval + _ROUNDING)

    # --- how it calls its kernel ---

    def _new_chains(self, kind, **given):
        """What a kernel knows of the chains: arrays (N, lanes) of zeros but for those given."""
        shape = self.n_blocks, len(self._noise)
        return kind(**{name: zeros(shape) for name in kind._fields} | given)

    def _advance(self, kernel: Callable[[Records], int], first: float, interval: float, count: int):
        """Call a kernel until no buffer is full; full ones are doubled.

        kernel : goes on where it has stopped, before the step that might not fit, so that no bit
        depends on the size of the buffers. first, interval, count : of the samples, see
        `Samples`. Returns what it said at last: DONE or STORM. CONTACT stops the run.
        """
        samples = Samples(
            values=self._samples,
            following=zeros(len(self._noise), dtype=np.int64),
            first_block=self._first_sampled,
            first=first,
            interval=interval,
            count=count,
        )
        while True:
            status = kernel(Records(samples, self._events, self._crossings))
            if status == EVENTS_FULL:
                self._events = self._doubled(self._events)
            elif status == CROSSINGS_FULL:
                self._crossings = self._doubled(self._crossings)
            elif status == CONTACT:
                self._stop_at_contact(int(np.argmin(self._gaps().min(axis=1))))
            else:
                return status

    def _doubled(self, buffer):
        if buffer.rows.nbytes > _LARGEST_BUFFER // 2:
            lane = int(np.argmax(buffer.count[: self._width]))
            reason = f"{buffer.count[lane]} events since t = {self.time:g} are too many to record"
            self._stop(lane, reason)
        return buffer._replace(rows=np.concatenate([buffer.rows] * 2, axis=1))

    # --- what follows from it ---

    def positions(self) -> np.ndarray:
        """Positions (W, N) of the blocks now."""
        return self._of_chains(self._lanes().displacements) + self.parameters[0].rest_positions

    def velocities(self) -> np.ndarray:
        """Velocities (W, N) of the blocks now, in the laboratory frame."""
        return self._of_chains(self._lanes().relative_velocities + self._belt_velocity)

    def accelerations(self, noise: np.ndarray) -> np.ndarray:
        """Accelerations (W, N) of the blocks now, with forces (W, N) of the noise."""
        lanes = self._lanes()
        moving = self._of_chains(lanes.relative_velocities), self._of_chains(lanes.directions)
        return acceleration(self.positions(), *moving, self.parameters[0], noise)

    def energy_balance(self) -> tuple[np.ndarray, np.ndarray]:
        """What the energy balance does not account for (W,), and the belt's work (W,).

        Work of the belt (the support does not move and does none) minus friction loss minus the
        change of energy. The belt's impulse follows from the momentum of the chain and the impulse
        of the wall; friction losses are summed by the integrator as force times slip.
        """
        initial_momentum = np.array([state.initial_momentum for state in self._begun])
        initial_energy = np.array([state.initial_energy for state in self._begun])
        mass = np.asarray(self.parameters[0].mass)
        momentum = (mass * self.velocities()).sum(axis=1) - initial_momentum
        impulse = momentum + self._lanes().wall_impulse[: self._width]
        belt = self._belt_velocity[: self._width] * impulse
        loss = self._of_chains(self._lanes().friction_losses).sum(axis=1)
        energy = potential_energy(self.positions(), self.parameters[0])
        energy += kinetic_energy(self.parameters[0], self.velocities())
        return belt - loss - (energy - initial_energy), belt

    def energy_residual(self) -> np.ndarray:
        """What the energy balance does not account for (W,), as a share of the belt's work."""
        return share_of_work(*self.energy_balance())

    def _of_chains(self, values):
        # contiguous, so that sums over blocks round the same way for any number of chains
        return values[:, : self._width].T.copy()

    def _chunk_end(self, time: float) -> float:
        """End of the chunk that begins at `time`, on a grid that no run changes."""
        return (math.floor(time / self._chunk_time + _ROUNDING) + 1) * self._chunk_time

    def _chunk(self, start: float, first_row: int, rows: int) -> Chunk:
        """The chunk that ends now; its samples begin with sample number `first_row` of the run."""
        width, sampling = self._width, self._sampling
        numbers = np.arange(first_row, first_row + rows)
        samples = np.moveaxis(self._samples, -1, 0)[:rows, :, :, :width]
        return Chunk(
            start=start,
            end=self.time,
            time=numbers * sampling.steps * sampling.step,
            displacement=samples[:, 0],
            relative_velocity=samples[:, 1],
            kinetic_friction=samples[:, 2],
            events=self._events.rows[:width],
            event_count=self._events.count[:width],
            crossings=self._crossings.rows[:width],
            crossing_count=self._crossings.count[:width],
        )

    def _check_state(self):
        """At the end of a chunk; kernels look for contacts on the way."""
        gaps = self._gaps()
        # a NaN compares false, so it fails this test as well
        good = np.all((gaps > 0) & np.isfinite(gaps), axis=1)
        if not good.all():
            lane = int(np.argmin(good))
            if np.isfinite(gaps[lane]).all():
                self._stop_at_contact(lane)
            self._stop(lane, "the state is not finite")

    def _gaps(self):
        """Lengths (W, N) of the springs now."""
        return np.diff(self.positions(), axis=1, prepend=0.0)

    def _stop_at_contact(self, lane: int):
        with np.errstate(over="ignore", invalid="ignore"):  # a scheme that is unstable overflows
            missing, belt = (values[lane] for values in self.energy_balance())
            initial = self._begun[lane].initial_energy
            balanced = abs(missing) <= _FROM_NOTHING * (abs(belt) + initial)
        if not balanced:
            self._stop(lane, _UNSTABLE)
        place = int(np.argmin(self._gaps()[lane]))
        meet = f"blocks {place} and {place + 1} meet" if place else "block 1 reaches the support"
        raise ModelStateError(
            f"{self.parameters[lane].describe()}: {meet} at t = {self._reached(lane):g} "
            "(a longer rest_length prevents it: forces stay, and all lengths grow by as much)"
        )

    def _stop(self, lane: int, reason: str):
        raise ModelStateError(
            f"{self.parameters[lane].describe()}: {reason} at t = {self._reached(lane):g} "
            f"(time_step = {self.time_step:g})"
        )


def share_of_work(missing: np.ndarray, work: np.ndarray) -> np.ndarray:
    """Energy that is not accounted for, as a share of the belt's work."""
    return missing / np.maximum(np.abs(work), np.finfo(float).tiny)


def _stacked(values: Sequence) -> np.ndarray:
    """Arrays of W chains as one (..., W)."""
    return np.moveaxis(np.array(values), 0, -1)

"""Many chains advanced together: what the integrators have in common.

An integrator yields `Chunk`s: views of buffers that are overwritten by the next chunk, so the
memory of a run does not grow with its length. Observers (`beltrepro.observe`) read chunks.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from beltrepro.engine import simd
from beltrepro.engine.law import law_constants
from beltrepro.engine.memory import aligned, zeros
from beltrepro.engine.noise import normal_deviates, stream_states
from beltrepro.engine.records import EVENT_FIELDS, Crossings, Events
from beltrepro.errors import ModelStateError
from beltrepro.model import ChainParameters
from beltrepro.model.spring import potential_energy

GROUP_SIZE = 32  # chains advanced together, at most
_CHUNK_TIME = 250.0
_CHUNK_SAMPLES = 4000
_EVENTS = 4096
_CROSSINGS = 1024


@dataclass(frozen=True)
class Chunk:
    """What happened to W chains between two instants, all arrays views of shared buffers.

    start, end : model time.
    time (S,) : instants of the samples; displacement, relative_velocity, kinetic_friction
    (S, B, W) : of the last B blocks; displacement is from the rest position.
    events (W, E, 6), event_count (W,) : see `beltrepro.engine.records`; blocks from 0.
    crossings (W, C, 1+2N), crossing_count (W,) : time, displacements, relative velocities.
    """

    start: float
    end: float
    time: np.ndarray
    displacement: np.ndarray
    relative_velocity: np.ndarray
    kinetic_friction: np.ndarray
    events: np.ndarray
    event_count: np.ndarray
    crossings: np.ndarray
    crossing_count: np.ndarray


@dataclass(frozen=True)
class Section:
    """Downward crossings to record: block (1-based) and one position for each chain (W,)."""

    block: int
    positions: np.ndarray


class Integrator:
    """W chains of equal n_blocks and law, all stuck at t = 0; an integrator is a subclass.

    Parameters
    ----------
    parameters : W chains.
    seed, replicates : key the random streams, see `beltrepro.engine.noise`.
    initial_positions : (W, N) positions of the blocks at t = 0, all stuck, velocity u.
    time_step : dt. sample_stride : steps between samples. sampled_blocks : the last B blocks.
    section : crossings to record, or None.
    """

    _vector = simd.LANES  # chains in a vector of the integrator

    def __init__(
        self,
        parameters: Sequence[ChainParameters],
        *,
        seed: int,
        replicates: Sequence[int],
        initial_positions: np.ndarray,
        time_step: float,
        sample_stride: int,
        sampled_blocks: int,
        section: Section | None = None,
    ):
        first = parameters[0]
        rest = first.rest_positions
        self.parameters = list(parameters)
        self.n_blocks = first.n_blocks
        self.time_step = time_step
        self._width = len(parameters)
        self._stride = sample_stride
        self._first_sampled = self.n_blocks - sampled_blocks
        # lanes that fill up the last vector repeat the last chain; nobody looks at them
        lanes = -(-self._width // self._vector) * self._vector
        source = np.minimum(np.arange(lanes), self._width - 1)
        chains = [self.parameters[lane] for lane in source]
        self._belt_velocity = aligned([chain.belt_velocity for chain in chains])
        self._noise = aligned([chain.noise for chain in chains])
        self._law = law_constants(first)
        self._initial_displacement = aligned((initial_positions[source] - rest).T)
        keys = [replicates[lane] for lane in source]
        self._streams = aligned(stream_states(chains, seed, keys))
        normals = zeros((self.n_blocks + self.n_blocks % 2, lanes))
        normal_deviates(self._streams, normals)
        draws = self._noise * normals[: self.n_blocks]
        self._initial_threshold = aligned(first.static_friction + draws)

        steps = min(max(1, round(_CHUNK_TIME / time_step)), _CHUNK_SAMPLES * sample_stride)
        self._chunk_steps = -(-steps // sample_stride) * sample_stride
        rows = self._chunk_steps // sample_stride + 1
        self._samples = zeros((rows, 3, sampled_blocks, lanes))
        self._events = Events(
            rows=np.empty((lanes, max(_EVENTS, 8 * self.n_blocks), EVENT_FIELDS)),
            count=np.zeros(lanes, dtype=np.int64),
        )
        level = zeros(lanes)
        if section is not None:
            level[:] = section.positions[source] - rest[section.block - 1]
        self._crossings = Crossings(
            block=-1 if section is None else section.block - 1,
            level=level,
            rows=np.empty((lanes, _CROSSINGS, 1 + 2 * self.n_blocks)),
            count=np.zeros(lanes, dtype=np.int64),
        )
        self.time = 0.0  # model time reached
        speed = self._belt_velocity[: self._width]
        stored = potential_energy(np.asarray(initial_positions), first)
        self._initial_energy = stored + self.n_blocks * speed**2 / 2
        self._initial_momentum = self.n_blocks * speed

    # --- what an integrator provides ---

    def advance(self, until: float) -> Iterator[Chunk]:
        """Advance all chains to `until`, chunk by chunk.

        Raises
        ------
        ModelStateError : a state is not finite, or blocks pass each other.
        """
        raise NotImplementedError

    def _displacements(self) -> np.ndarray:
        """(N, lanes) from the rest positions, now."""
        raise NotImplementedError

    def _relative_velocities(self) -> np.ndarray:
        """(N, lanes) now."""
        raise NotImplementedError

    def _friction_losses(self) -> np.ndarray:
        """(N, lanes) friction force times slip since t = 0."""
        raise NotImplementedError

    def _wall_impulses(self) -> np.ndarray:
        """(lanes,) integral of the first spring's pull since t = 0."""
        raise NotImplementedError

    # --- what follows from it ---

    def positions(self) -> np.ndarray:
        """Positions (W, N) of the blocks now."""
        return self._of_chains(self._displacements()) + self.parameters[0].rest_positions

    def velocities(self) -> np.ndarray:
        """Velocities (W, N) of the blocks now, in the laboratory frame."""
        return self._of_chains(self._relative_velocities() + self._belt_velocity)

    def energy_residual(self) -> np.ndarray:
        """Energy audit (W,): what the books do not account for, as a share of the belt's work.

        Work of the belt (the support does not move and does none) minus friction loss minus the
        change of energy. The belt's impulse follows from the momentum of the chain and the impulse
        of the wall; friction losses are summed by the integrator as force times slip.
        """
        momentum = self.velocities().sum(axis=1) - self._initial_momentum
        impulse = momentum + self._wall_impulses()[: self._width]
        belt = self._belt_velocity[: self._width] * impulse
        loss = self._of_chains(self._friction_losses()).sum(axis=1)
        energy = potential_energy(self.positions(), self.parameters[0])
        energy += (self.velocities() ** 2).sum(axis=1) / 2
        missing = belt - loss - (energy - self._initial_energy)
        return missing / np.maximum(np.abs(belt), np.finfo(float).tiny)

    def _of_chains(self, values):
        # contiguous, so that sums over blocks round the same way for any number of chains
        return np.ascontiguousarray(values[:, : self._width].T)

    def _empty_buffers(self):
        """Forget the events and crossings of the last chunk."""
        self._events.count[:] = 0
        self._crossings.count[:] = 0

    def _chunk(self, start: float, first_row: int, rows: int) -> Chunk:
        """The chunk that ends now; its samples begin with sample number `first_row` of the run."""
        width = self._width
        samples = self._samples[:rows, :, :, :width]
        return Chunk(
            start=start,
            end=self.time,
            time=np.arange(first_row, first_row + rows) * self._stride * self.time_step,
            displacement=samples[:, 0],
            relative_velocity=samples[:, 1],
            kinetic_friction=samples[:, 2],
            events=self._events.rows[:width],
            event_count=self._events.count[:width],
            crossings=self._crossings.rows[:width],
            crossing_count=self._crossings.count[:width],
        )

    def _check_state(self):
        positions = self.positions()
        gaps = np.diff(positions, axis=1, prepend=0.0)
        # a NaN compares false, so it fails this test as well
        good = np.all(gaps > 0, axis=1) & np.all(np.isfinite(positions), axis=1)
        if not good.all():
            lane = int(np.argmin(good))
            reason = "blocks pass through each other"
            if not np.isfinite(positions[lane]).all():
                reason = "the state is not finite"
            self._stop(lane, reason)

    def _stop(self, lane: int, reason: str):
        raise ModelStateError(
            f"{self.parameters[lane].describe()}: {reason} at t = {self.time:g} "
            f"(time_step = {self.time_step:g})"
        )

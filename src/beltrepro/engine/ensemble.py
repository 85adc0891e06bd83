"""Many chains advanced together: allocates the state, runs the kernel, hands out chunks of time.

An ensemble yields `Chunk`s: views of buffers that are overwritten by the next chunk, so the memory
of a run does not grow with its length. Observers (`beltrepro.observe`) read chunks.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from beltrepro.engine import verlet
from beltrepro.engine.events import EVENT_FIELDS
from beltrepro.engine.law import law_constants
from beltrepro.engine.noise import normal_deviates, stream_states
from beltrepro.errors import ModelStateError
from beltrepro.model import ChainParameters
from beltrepro.model.spring import potential_energy

LANES = 32  # chains advanced together; vectors hold 8
_VECTOR = 8
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
    events (W, E, 6), event_count (W,) : see `beltrepro.engine.events`, EVENT_*; blocks from 0.
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


class VerletEnsemble:
    """Up to `LANES` chains of equal n_blocks and law, integrated by the scheme of the Appendix.

    Parameters
    ----------
    parameters : W chains.
    seed, replicates : key the random streams, see `beltrepro.engine.noise`.
    initial_positions : (W, N) positions of the blocks at t = 0, all stuck, velocity u.
    time_step : dt. sample_stride : steps between samples. sampled_blocks : the last B blocks.
    section : crossings to record, or None.

    Raises
    ------
    ModelStateError : from `advance`, when a state is not finite or blocks pass each other.
    """

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
        self.parameters = list(parameters)
        self.n_blocks = first.n_blocks
        self.time_step = time_step
        self._width = len(parameters)
        self._stride = sample_stride
        self._first_sampled = self.n_blocks - sampled_blocks
        # lanes that fill up the last vector repeat the last chain; nobody looks at them
        lanes = -(-self._width // _VECTOR) * _VECTOR
        source = np.minimum(np.arange(lanes), self._width - 1)
        chains = [self.parameters[lane] for lane in source]
        self._velocity = np.array([chain.belt_velocity for chain in chains])
        self._noise = np.array([chain.noise for chain in chains])
        self._noisy = bool(np.any(self._noise > 0))
        self._constants = law_constants(first)

        shape = (self.n_blocks, lanes)
        rest = first.rest_positions
        self._displacement = np.ascontiguousarray((initial_positions[source] - rest).T)
        (
            self._slip_step,
            self._relative_velocity,
            self._acceleration,
            self._direction,
            self._known_direction,
            self._dissipated,
        ) = (np.zeros(shape) for _ in range(6))
        self._wall_impulse = np.zeros(lanes)
        self._pull = np.zeros((self.n_blocks + 1, lanes))
        self._streams = stream_states(chains, seed, [replicates[lane] for lane in source])
        self._normals = np.zeros((self.n_blocks + self.n_blocks % 2, lanes))
        normal_deviates(self._streams, self._normals)
        draws = self._noise * self._normals[: self.n_blocks]
        self._threshold = first.static_friction + draws

        self._steps_done = 0
        self._chunk_steps = max(1, round(_CHUNK_TIME / time_step))
        self._chunk_steps = min(self._chunk_steps, _CHUNK_SAMPLES * sample_stride)
        rows = self._chunk_steps // sample_stride + 1
        self._samples = np.empty((rows, 3, sampled_blocks, lanes))
        self._events = np.empty((lanes, _EVENTS, EVENT_FIELDS))
        self._event_count = np.zeros(lanes, dtype=np.int64)
        self._crossings = np.empty((lanes, _CROSSINGS, 1 + 2 * self.n_blocks))
        self._crossing_count = np.zeros(lanes, dtype=np.int64)
        self._section_block = -1 if section is None else section.block - 1
        self._section_displacement = np.zeros(lanes)
        if section is not None:
            self._section_displacement[:] = section.positions[source] - rest[section.block - 1]
        self._initial_energy = self.energy()
        self._initial_momentum = self.velocities().sum(axis=1)

    @property
    def time(self) -> float:
        """Model time reached."""
        return self._steps_done * self.time_step

    def positions(self) -> np.ndarray:
        """Positions (W, N) of the blocks now."""
        # contiguous, so that sums over blocks round the same way for any number of chains
        displacement = np.ascontiguousarray(self._displacement[:, : self._width].T)
        return displacement + self.parameters[0].rest_positions

    def velocities(self) -> np.ndarray:
        """Velocities (W, N) of the blocks now, in the laboratory frame."""
        velocity = self._relative_velocity + self._velocity
        return np.ascontiguousarray(velocity[:, : self._width].T)

    def energy(self) -> np.ndarray:
        """Kinetic and potential energy (W,) now."""
        kinetic = (self.velocities() ** 2).sum(axis=1) / 2
        return kinetic + potential_energy(self.positions(), self.parameters[0])

    def energy_residual(self) -> np.ndarray:
        """Energy audit (W,): what the books do not account for, as a share of the belt's work.

        Work of the belt (the support does not move and does none) minus friction loss minus the
        change of energy. The belt's impulse follows from the momentum of the chain and the impulse
        of the wall; friction losses are summed in the kernel as force times slip.
        """
        momentum = self.velocities().sum(axis=1) - self._initial_momentum
        belt = self._velocity[: self._width] * (momentum + self._wall_impulse[: self._width])
        loss = self._dissipated[:, : self._width].sum(axis=0)
        missing = belt - loss - (self.energy() - self._initial_energy)
        return missing / np.maximum(np.abs(belt), np.finfo(float).tiny)

    def advance(self, until: float) -> Iterator[Chunk]:
        """Advance all chains to the step nearest to `until`, chunk by chunk."""
        last = round(until / self.time_step)
        while self._steps_done < last:
            start = self._steps_done
            self._event_count[:] = 0
            self._crossing_count[:] = 0
            done = verlet.verlet_steps(
                start,
                min(self._chunk_steps, last - start),
                self.time_step,
                self._constants,
                self._velocity * self.time_step,
                self._noise,
                self._displacement,
                self._slip_step,
                self._relative_velocity,
                self._acceleration,
                self._threshold,
                self._direction,
                self._known_direction,
                self._dissipated,
                self._wall_impulse,
                self._streams,
                self._normals,
                self._pull,
                self._stride,
                self._first_sampled,
                self._samples,
                self._events,
                self._event_count,
                self._section_block,
                self._section_displacement,
                self._crossings,
                self._crossing_count,
                self._noisy,
            )
            self._steps_done += done
            self._check_state()
            yield self._chunk(start)

    def _chunk(self, start: int) -> Chunk:
        width = self._width
        first_row = start // self._stride + 1
        rows = self._steps_done // self._stride + 1 - first_row
        samples = self._samples[:rows, :, :, :width]
        return Chunk(
            start=start * self.time_step,
            end=self.time,
            time=np.arange(first_row, first_row + rows) * self._stride * self.time_step,
            displacement=samples[:, 0],
            relative_velocity=samples[:, 1],
            kinetic_friction=samples[:, 2],
            events=self._events[:width],
            event_count=self._event_count[:width],
            crossings=self._crossings[:width],
            crossing_count=self._crossing_count[:width],
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
            raise ModelStateError(
                f"{self.parameters[lane].describe()}: {reason} at t = {self.time:g} "
                f"(time_step = {self.time_step:g})"
            )

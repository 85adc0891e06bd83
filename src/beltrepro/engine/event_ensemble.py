"""Many chains advanced by the exact dynamics (`beltrepro.engine.event`)."""

from collections.abc import Iterator, Sequence

import numpy as np

from beltrepro.engine import event
from beltrepro.engine.ensemble import Chunk, Section
from beltrepro.engine.events import EVENT_FIELDS
from beltrepro.engine.law import law_constants
from beltrepro.engine.memory import aligned, zeros
from beltrepro.engine.noise import normal_deviates, stream_states
from beltrepro.engine.simd import LANES as VECTOR
from beltrepro.engine.taylor import LEVELS
from beltrepro.errors import ModelStateError
from beltrepro.model import ChainParameters
from beltrepro.model.spring import potential_energy

_CHUNK_TIME = 250.0
_CHUNK_SAMPLES = 4000
_EVENTS = 4096
_CROSSINGS = 1024


class EventEnsemble:
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
        self.n_blocks = n_blocks = first.n_blocks
        self.time_step = time_step
        self._width = len(parameters)
        lanes = -(-self._width // VECTOR) * VECTOR
        source = np.minimum(np.arange(lanes), self._width - 1)
        chains = [self.parameters[lane] for lane in source]
        self._velocity = aligned([chain.belt_velocity for chain in chains])
        self._noise = aligned([chain.noise for chain in chains])
        self._power = aligned((first.friction_ratio * self._noise) ** 2 * time_step)
        self._constants = law_constants(first)
        shape = (n_blocks, lanes)
        rest = first.rest_positions
        self._displacement = aligned((initial_positions[source] - rest).T)
        self._relative_velocity = zeros(shape)
        self._direction = zeros(shape)
        self._branch_changed = zeros(shape)
        self._dissipated = zeros(shape)
        self._noise_force = zeros((2, *shape))
        self._cell = zeros(lanes)
        self._local_time = zeros(lanes)
        self._wall_impulse = zeros(lanes)
        deformation = np.diff(self._displacement, axis=0, prepend=0.0)
        self._regime = aligned(np.sign(deformation) * (np.abs(deformation) > first.linear_limit))
        self._streams = aligned(stream_states(chains, seed, [replicates[lane] for lane in source]))
        normals = zeros((n_blocks + n_blocks % 2, lanes))
        normal_deviates(self._streams, normals)
        self._threshold = aligned(first.static_friction + self._noise * normals[:n_blocks])

        candidates = n_blocks * event.CANDIDATES_PER_BLOCK
        columns = (n_blocks + 1, n_blocks, n_blocks, n_blocks, n_blocks, 1, candidates // VECTOR)
        series, growth, stretching, force, friction, wall_pull, polynomials = (
            zeros(count * LEVELS * VECTOR) for count in columns
        )
        self._scratch = (
            series,
            zeros(n_blocks * VECTOR),
            growth,
            stretching,
            force,
            friction,
            wall_pull,
            polynomials,
            zeros(candidates, dtype=np.int64),
            zeros(candidates, dtype=np.int64),
            zeros(candidates),
            zeros(n_blocks * VECTOR),
            zeros((4, VECTOR)),
            zeros(VECTOR, dtype=np.int64),
        )
        self._interval = sample_stride * time_step
        self._first_sampled = n_blocks - sampled_blocks
        self._chunk_time = self._interval * min(
            _CHUNK_SAMPLES, max(1, round(_CHUNK_TIME / self._interval))
        )
        rows = round(self._chunk_time / self._interval) + 1
        self._samples = np.empty((rows, 3, sampled_blocks, lanes))
        self._events = np.empty((lanes, _EVENTS, EVENT_FIELDS))
        self._event_count = zeros(lanes, dtype=np.int64)
        self._crossings = np.empty((lanes, _CROSSINGS, 1 + 2 * n_blocks))
        self._crossing_count = zeros(lanes, dtype=np.int64)
        self._section_block = -1 if section is None else section.block - 1
        self._section_displacement = zeros(lanes)
        if section is not None:
            self._section_displacement[:] = section.positions[source] - rest[section.block - 1]
        self.time = 0.0
        self._initial_energy = self.energy()
        self._initial_momentum = self.velocities().sum(axis=1)

    def positions(self):
        displacement = np.ascontiguousarray(self._displacement[:, : self._width].T)
        return displacement + self.parameters[0].rest_positions

    def velocities(self):
        velocity = self._relative_velocity + self._velocity
        return np.ascontiguousarray(velocity[:, : self._width].T)

    def energy(self):
        kinetic = (self.velocities() ** 2).sum(axis=1) / 2
        return kinetic + potential_energy(self.positions(), self.parameters[0])

    def energy_residual(self):
        momentum = self.velocities().sum(axis=1) - self._initial_momentum
        belt = self._velocity[: self._width] * (momentum + self._wall_impulse[: self._width])
        loss = self._dissipated[:, : self._width].sum(axis=0)
        missing = belt - loss - (self.energy() - self._initial_energy)
        return missing / np.maximum(np.abs(belt), np.finfo(float).tiny)

    def advance(self, until: float) -> Iterator[Chunk]:
        while self.time < until:
            start = self.time
            end = min(float(until), (round(start / self._chunk_time) + 1) * self._chunk_time)
            span = end - start
            self._event_count[:] = 0
            self._crossing_count[:] = 0
            self._local_time[:] = 0.0
            first_row = int(np.floor(start / self._interval + 1e-9)) + 1
            n_samples = int(np.floor(end / self._interval + 1e-9)) + 1 - first_row
            sample_row = zeros(len(self._velocity), dtype=np.int64)
            while True:
                status = event.advance_chains(
                    span,
                    start,
                    self._constants,
                    self._velocity,
                    self._power,
                    self._noise,
                    self._local_time,
                    self._displacement,
                    self._relative_velocity,
                    self._direction,
                    self._threshold,
                    self._regime,
                    self._branch_changed,
                    self._noise_force,
                    self._cell,
                    self._dissipated,
                    self._wall_impulse,
                    self._streams,
                    *self._scratch,
                    self._interval,
                    first_row * self._interval - start,
                    n_samples,
                    sample_row,
                    self._first_sampled,
                    self._samples,
                    self._events,
                    self._event_count,
                    self._section_block,
                    self._section_displacement,
                    self._crossings,
                    self._crossing_count,
                    int(1000 + 2000 * span),
                )
                if status == event.DONE:
                    break
                if status == event.EVENTS_FULL:
                    self._events = np.concatenate([self._events] * 2, axis=1)
                elif status == event.CROSSINGS_FULL:
                    self._crossings = np.concatenate([self._crossings] * 2, axis=1)
                else:
                    raise ModelStateError("storm")
            self.time = end
            width = self._width
            samples = self._samples[:n_samples, :, :, :width]
            yield Chunk(
                start=start,
                end=end,
                time=np.arange(first_row, first_row + n_samples) * self._interval,
                displacement=samples[:, 0],
                relative_velocity=samples[:, 1],
                kinetic_friction=samples[:, 2],
                events=self._events[:width],
                event_count=self._event_count[:width],
                crossings=self._crossings[:width],
                crossing_count=self._crossing_count[:width],
            )

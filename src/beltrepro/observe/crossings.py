"""Crossings of a section: bifurcation diagrams (Fig. 12), Poincaré sections (Fig. 10), returns."""

import numpy as np

from beltrepro.engine.integrator import Chunk
from beltrepro.engine.records import EVENT_BLOCK, EVENT_SLIP, EVENT_TIME
from beltrepro.engine.vector import kernel


class SectionVelocities:
    """Velocity of the last block at the first crossings, the count of all, and that in each bin.

    edges : array (B+1,)
        Of the bins, rising, model velocity.
    """

    def __init__(
        self, belt_velocity: np.ndarray, n_values: int, edges: np.ndarray, start: float
    ) -> None:
        self._belt_velocity = belt_velocity
        self._edges = edges
        self._start = start
        self.count = np.zeros(len(belt_velocity), dtype=np.int64)
        self.values = np.full((len(belt_velocity), n_values), np.nan, dtype=np.float32)
        self.histogram = np.zeros((len(belt_velocity), len(edges) - 1), dtype=np.uint32)

    def observe(self, chunk: Chunk) -> None:
        crossed = chunk.crossings, chunk.crossing_count, self._belt_velocity, self._start
        _add_crossings(*crossed, self._edges, self.count, self.values, self.histogram)


@kernel
def _add_crossings(
    crossings, crossing_count, belt_velocity, start, edges, count, values, histogram
):
    """Count the crossings since `start`, also by bin; keep the velocities that find a place."""
    last = crossings.shape[2] - 1
    for lane in range(len(count)):
        for row in range(crossing_count[lane]):
            if crossings[lane, row, 0] >= start:
                velocity = crossings[lane, row, last] + belt_velocity[lane]
                if count[lane] < values.shape[1]:
                    values[lane, count[lane]] = velocity
                count[lane] += 1
                place = np.searchsorted(edges, velocity, side="right") - 1
                if 0 <= place < histogram.shape[1]:
                    histogram[lane, place] += 1


class ReturnLog:
    """Full states of W chains at all crossings of a section, and all slips on the way."""

    def __init__(self, width: int) -> None:
        self._states: list[list[np.ndarray]] = [[] for _ in range(width)]
        self._slips: list[list[tuple[np.ndarray, np.ndarray]]] = [[] for _ in range(width)]
        self.last_event = np.full(width, -np.inf)

    def observe(self, chunk: Chunk) -> None:
        for lane in range(len(self.last_event)):
            self._states[lane].append(chunk.crossings[lane, : chunk.crossing_count[lane]].copy())
            events = chunk.events[lane, : chunk.event_count[lane]]
            slips = events[events[:, EVENT_SLIP] > 0]
            blocks = slips[:, EVENT_BLOCK].astype(np.uint32)
            self._slips[lane].append((slips[:, EVENT_TIME].copy(), blocks))
            if len(events):
                self.last_event[lane] = events[-1, EVENT_TIME]

    def returns(self, lane: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times, states and the number of slips before of all crossings of one chain, in order."""
        rows = np.concatenate(self._states[lane])
        return rows[:, 0], rows[:, 1:], np.searchsorted(self.slips(lane)[0], rows[:, 0])

    def slips(self, lane: int) -> tuple[np.ndarray, np.ndarray]:
        """Times and blocks, from 0, of all slips of one chain, in order."""
        times, blocks = map(np.concatenate, zip(*self._slips[lane], strict=True))
        return times, blocks

"""Returns to a section: full states there, and the slips between them."""

import numpy as np

from beltrepro.engine.integrator import Chunk
from beltrepro.engine.records import EVENT_SLIP, EVENT_TIME


class ReturnLog:
    """Full states of W chains at all crossings of a section, with the slips so far."""

    def __init__(self, width: int) -> None:
        self._states: list[list[np.ndarray]] = [[] for _ in range(width)]
        self._slips: list[list[np.ndarray]] = [[] for _ in range(width)]
        self._slip_count = np.zeros(width, dtype=np.int64)
        self.last_event = np.full(width, -np.inf)

    def observe(self, chunk: Chunk) -> None:
        """Add the crossings of a chunk, and count its slips."""
        for lane in range(len(self.last_event)):
            events = chunk.events[lane, : chunk.event_count[lane]]
            states = chunk.crossings[lane, : chunk.crossing_count[lane]]
            slips = events[events[:, EVENT_SLIP] > 0, EVENT_TIME]
            before = self._slip_count[lane] + np.searchsorted(slips, states[:, 0])
            self._states[lane].append(states.copy())
            self._slips[lane].append(before)
            self._slip_count[lane] += len(slips)
            if len(events):
                self.last_event[lane] = events[-1, EVENT_TIME]

    def returns(self, lane: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All crossings of one chain, in the order of time."""
        rows = np.concatenate(self._states[lane])
        return rows[:, 0], rows[:, 1:], np.concatenate(self._slips[lane])

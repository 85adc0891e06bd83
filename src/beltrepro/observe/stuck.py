"""How many blocks are stuck at once: each of them has lost its velocity as a freedom of its own."""

import numpy as np

from beltrepro.engine.integrator import Chunk
from beltrepro.engine.records import EVENT_BLOCK, EVENT_SLIP, EVENT_TIME


class MostStuck:
    """The largest number of blocks that were stuck at one time."""

    def __init__(self, n_stuck: np.ndarray) -> None:
        self._now = np.array(n_stuck)
        self.most = self._now.copy()

    def observe(self, chunk: Chunk) -> None:
        """Follow the events of a chunk."""
        for lane, count in enumerate(chunk.event_count):
            if count:
                events = chunk.events[lane, :count]
                stuck = self._now[lane] + np.cumsum(np.where(events[:, EVENT_SLIP] > 0, -1, 1))
                self._now[lane] = stuck[-1]
                lasting = np.concatenate([stuck[:-1][~_turns(events)], stuck[-1:]])
                self.most[lane] = max(self.most[lane], lasting.max())


def _turns(events: np.ndarray) -> np.ndarray:
    """Which of all events (E, 6) but the last are the first half of a reversal: (E-1,) of bool."""
    same = np.diff(events[:, [EVENT_TIME, EVENT_BLOCK]], axis=0) == 0
    return same.all(axis=1) & (events[:-1, EVENT_SLIP] == 0)

"""How many blocks are stuck at once: each of them has lost its velocity as a freedom of its own."""

import numpy as np

from beltrepro.engine.records import EVENT_SLIP


class MostStuck:
    """The largest number of blocks that were stuck at one time.

    n_stuck : (W,) at the start. `most` (W,) is the largest number so far.
    """

    def __init__(self, n_stuck: np.ndarray) -> None:
        self._now = np.array(n_stuck)
        self.most = self._now.copy()

    def observe(self, chunk) -> None:
        """Follow the events of a chunk."""
        for lane, count in enumerate(chunk.event_count):
            if count:
                slips = chunk.events[lane, :count, EVENT_SLIP] > 0
                stuck = self._now[lane] + np.cumsum(np.where(slips, -1, 1))
                self._now[lane] = stuck[-1]
                self.most[lane] = max(self.most[lane], stuck.max())

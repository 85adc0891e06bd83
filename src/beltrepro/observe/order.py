"""The order in which blocks slip."""

import numpy as np

from beltrepro.engine.integrator import Chunk
from beltrepro.engine.records import EVENT_BLOCK, EVENT_SLIP, EVENT_TIME


class SlipOrder:
    """Which block slips when, for each of W chains."""

    def __init__(self, width: int) -> None:
        self._times: list[list[np.ndarray]] = [[] for _ in range(width)]
        self._blocks: list[list[np.ndarray]] = [[] for _ in range(width)]

    def observe(self, chunk: Chunk) -> None:
        """Add the slips of a chunk."""
        for lane in range(len(self._times)):
            events = chunk.events[lane, : chunk.event_count[lane]]
            slips = events[events[:, EVENT_SLIP] > 0]
            self._times[lane].append(slips[:, EVENT_TIME].copy())
            self._blocks[lane].append(slips[:, EVENT_BLOCK].astype(np.uint8))

    def slips(self, lane: int) -> tuple[np.ndarray, np.ndarray]:
        """All slips of one chain, in the order of time."""
        return np.concatenate(self._times[lane]), np.concatenate(self._blocks[lane])

"""Slips of the blocks: counts, order, laminar phases of the last block, avalanches."""

from typing import NamedTuple

import numpy as np

from beltrepro.engine.integrator import Chunk
from beltrepro.engine.law import Law, of_blocks, tension
from beltrepro.engine.records import (
    EVENT_BLOCK,
    EVENT_DISSIPATED,
    EVENT_FIELDS,
    EVENT_POSITION,
    EVENT_SLIP,
    EVENT_TIME,
)
from beltrepro.engine.state import ChainState
from beltrepro.engine.vector import allocating_kernel, inlined, kernel

# State of one chain in `_follow`: when the present slip of the last block began (NaN: stuck) and
# when the last block stuck last; then the laminar phases met so far.
_SLIPPING_SINCE, _LAST_STICK, _LAMINAR_COUNT, _LAMINAR_TIME, _LAMINAR_LONGEST = range(5)


class SlipActivity:
    """Slips per block, laminar phases and last stick of the last block of W chains.

    A laminar phase is a slip of the last block that lasts longer than `laminar_time` (Sec. IV.B:
    the periodic state is one of continuous slip); only time after `start` counts.
    """

    def __init__(
        self,
        width: int,
        n_blocks: int,
        start: float,
        laminar_time: float,
        slipping_since: np.ndarray | float = np.nan,
    ) -> None:
        self._start = start
        self._laminar_time = laminar_time
        self.slip_count = np.zeros((width, n_blocks), dtype=np.int64)
        self.stick_count = np.zeros((width, n_blocks), dtype=np.int64)
        self._state = np.zeros((width, 5))
        self._state[:, _SLIPPING_SINCE] = slipping_since
        self._state[:, _LAST_STICK] = np.nan
        self._end = start

    def observe(self, chunk: Chunk) -> None:
        """Follow the events of a chunk."""
        self._end = chunk.end
        seen = self.slip_count, self.stick_count, self._state
        _follow(chunk.events, chunk.event_count, self._start, self._laminar_time, *seen)

    @property
    def last_stick_time(self) -> np.ndarray:
        """Last instant (W,) at which the last block stuck; NaN if it never did."""
        return self._state[:, _LAST_STICK].copy()

    @property
    def slipping_since(self) -> np.ndarray:
        """Start (W,) of the slip of the last block that is going on; NaN while it is stuck."""
        return self._state[:, _SLIPPING_SINCE].copy()

    def laminar(self) -> dict[str, np.ndarray]:
        """laminar_fraction, _count, _mean, _longest (W,), the slip going on included."""
        _, _, count, total, longest = self._state.T
        going_on = self._end - np.maximum(self._state[:, _SLIPPING_SINCE], self._start)
        going_on = np.where(going_on > self._laminar_time, going_on, 0.0)  # NaN while it is stuck
        count, total = count + (going_on > 0), total + going_on
        observed = self._end - self._start
        return {
            "laminar_fraction": total / observed if observed > 0 else np.full(len(total), np.nan),
            "laminar_count": count.astype(np.int64),
            "laminar_mean": np.divide(total, count, out=np.zeros_like(total), where=count > 0),
            "laminar_longest": np.maximum(longest, going_on),
        }


@kernel
def _follow(events, event_count, start, laminar_time, slip_count, stick_count, states):
    last_block = slip_count.shape[1] - 1
    for lane in range(events.shape[0]):
        state = states[lane]
        for index in range(event_count[lane]):
            time = events[lane, index, EVENT_TIME]
            block = int(events[lane, index, EVENT_BLOCK])
            slips = events[lane, index, EVENT_SLIP] > 0.0
            if time >= start:
                if slips:
                    slip_count[lane, block] += 1
                else:
                    stick_count[lane, block] += 1
            if block != last_block:
                continue
            if slips:
                state[_SLIPPING_SINCE] = time
                continue
            length = time - max(state[_SLIPPING_SINCE], start)
            if time > start and length > laminar_time:
                state[_LAMINAR_COUNT] += 1
                state[_LAMINAR_TIME] += length
                state[_LAMINAR_LONGEST] = max(state[_LAMINAR_LONGEST], length)
            state[_SLIPPING_SINCE] = np.nan
            state[_LAST_STICK] = time


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
            self._blocks[lane].append(slips[:, EVENT_BLOCK].astype(np.uint16))

    def slips(self, lane: int) -> tuple[np.ndarray, np.ndarray]:
        """All slips of one chain, in the order of time."""
        return np.concatenate(self._times[lane]), np.concatenate(self._blocks[lane])


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


class EventLog:
    """Keeps the events of all chains: for single runs and catalogues."""

    def __init__(self, width: int, rest_positions: np.ndarray) -> None:
        self._rest_positions = rest_positions
        self._parts: list[list[np.ndarray]] = [[] for _ in range(width)]
        self.counts = np.zeros(width, dtype=np.int64)  # of events

    def observe(self, chunk: Chunk) -> None:
        """Copy the events of a chunk."""
        for lane, parts in enumerate(self._parts):
            parts.append(chunk.events[lane, : chunk.event_count[lane]].copy())
        self.counts += chunk.event_count

    @property
    def nbytes(self) -> int:
        """Memory of the events of all chains."""
        return int(self.counts.sum()) * EVENT_FIELDS * np.dtype(float).itemsize

    def events(self, lane: int) -> np.ndarray:
        """Events of one chain in the order of time, which the log then no longer keeps."""
        events = np.concatenate([np.empty((0, EVENT_FIELDS)), *self._parts[lane]])
        self._parts[lane].clear()  # a long run has millions
        events[:, EVENT_POSITION] += self._rest_positions[events[:, EVENT_BLOCK].astype(int)]
        return events


_TIMES = [("start_time", "f8"), ("stop_time", "f8")]
_PLACES = [("start_position", "f8"), ("stop_position", "f8")]
_CHANGES = [("dissipated", "f8"), ("spring_energy_drop", "f8"), ("last_block_displacement", "f8")]
SLIP = np.dtype([("point", "i4"), ("block", "i4"), *_TIMES, *_PLACES, ("dissipated", "f8")])
AVALANCHE = np.dtype([("point", "i4"), *_TIMES, ("slips", "i4"), ("blocks", "i4"), *_CHANGES])


def slips_and_avalanches(
    events: np.ndarray, point: int, state: ChainState, law_constants: Law, start: float
) -> tuple[np.ndarray, np.ndarray]:
    """Slips of all blocks and avalanches of one chain (Sec. IV.A, Fig. 9).

    A slip runs from slip to stick of one block. An avalanche is a maximal interval in which at
    least one block slips; before and after it all blocks are stuck. What has begun before the first
    event is left out.
    """
    slips = np.zeros((len(events), 6))
    avalanches = np.zeros((len(events), 7))
    n_blocks, moving = len(state.positions), int(np.count_nonzero(state.directions))
    blocks = _Blocks(
        belt_velocity=state.parameters.belt_velocity,
        stuck_at=np.full(n_blocks, state.time),
        stuck_position=state.positions,
        slip_time=np.full(n_blocks, np.nan),
        slip_position=np.zeros(n_blocks),
        slip_loss=np.zeros(n_blocks),
        slipped=np.zeros(n_blocks),
    )
    laws = law_constants, of_blocks(state.parameters)
    n_slips, n_avalanches = _collect(events, start, moving, *laws, blocks, slips, avalanches)
    records = _records(avalanches[:n_avalanches], point, AVALANCHE)
    return _records(slips[:n_slips], point, SLIP), records


class _Blocks(NamedTuple):
    """What is known of the blocks while the events are read; arrays (N,)."""

    belt_velocity: float
    stuck_at: np.ndarray  # time of the last stick
    stuck_position: np.ndarray
    slip_time: np.ndarray  # start of the slip going on, else NaN
    slip_position: np.ndarray
    slip_loss: np.ndarray  # friction loss at its start
    slipped: np.ndarray  # 1.0 if the block has slipped in the avalanche


# The avalanche going on: when it began, energy of the springs and x_N then, loss and slips so far.
_BEGAN, _ENERGY, _LENGTH, _LOSS, _SLIPS = range(5)


def _records(columns, point, dtype):
    records = np.zeros(len(columns), dtype=dtype)
    records["point"] = point
    for name, column in zip(dtype.names[1:], columns.T, strict=True):
        records[name] = column
    return records


@allocating_kernel
def _collect(events, start, moving, law, varied, blocks, slips, avalanches):
    """Write slips (K, 6) and avalanches (A, 7), and count them; `moving` blocks slip before."""
    avalanche = np.zeros(5)
    avalanche[_BEGAN] = -np.inf  # earlier than any start
    last = len(blocks.stuck_at) - 1
    goes_on = False
    n_slips, n_avalanches = 0, 0
    for index in range(len(events)):
        event = events[index]
        time, block = event[EVENT_TIME], int(event[EVENT_BLOCK])
        if event[EVENT_SLIP] > 0.0:
            if moving == 0 and not goes_on:
                avalanche[_BEGAN] = time
                avalanche[_ENERGY] = _energy_at_rest(time, law, varied, blocks)
                avalanche[_LENGTH] = _position_at_rest(time, last, blocks)
                avalanche[_LOSS] = 0.0
                avalanche[_SLIPS] = 0.0
                blocks.slipped[:] = 0.0
            avalanche[_SLIPS] += 1.0
            blocks.slipped[block] = 1.0
            blocks.slip_time[block] = time
            blocks.slip_position[block] = event[EVENT_POSITION]
            blocks.slip_loss[block] = event[EVENT_DISSIPATED]
            moving += 1
            continue
        moving -= 1
        loss = event[EVENT_DISSIPATED] - blocks.slip_loss[block]
        if blocks.slip_time[block] >= start:
            row = slips[n_slips]
            row[0] = block + 1
            row[1], row[2] = blocks.slip_time[block], time
            row[3], row[4] = blocks.slip_position[block], event[EVENT_POSITION]
            row[5] = loss
            n_slips += 1
        avalanche[_LOSS] += loss
        blocks.slip_time[block] = np.nan
        blocks.stuck_at[block] = time
        blocks.stuck_position[block] = event[EVENT_POSITION]
        # a block that reverses sticks and slips at one instant
        goes_on = _slips_at_once(events, index)
        if moving == 0 and not goes_on and avalanche[_BEGAN] >= start:
            row = avalanches[n_avalanches]
            row[0], row[1] = avalanche[_BEGAN], time
            row[2], row[3] = avalanche[_SLIPS], blocks.slipped.sum()
            row[4] = avalanche[_LOSS]
            row[5] = avalanche[_ENERGY] - _energy_at_rest(time, law, varied, blocks)
            row[6] = _position_at_rest(time, last, blocks) - avalanche[_LENGTH]
            n_avalanches += 1
    return n_slips, n_avalanches


@inlined
def _slips_at_once(events, index):
    """Whether the event that follows is the start of a slip at the same time."""
    if index + 1 == len(events):
        return False
    following = events[index + 1]
    return following[EVENT_TIME] == events[index, EVENT_TIME] and following[EVENT_SLIP] > 0.0


@inlined
def _position_at_rest(time, block, blocks):
    """Position of a block that has been stuck since its last stick."""
    age = time - blocks.stuck_at[block]
    return blocks.stuck_position[block] + blocks.belt_velocity * age


@inlined
def _energy_at_rest(time, law, varied, blocks):
    """Energy of the springs while all blocks are stuck, as `beltrepro.model.spring` has it."""
    energy = 0.0
    previous = 0.0
    for block in range(len(blocks.stuck_at)):
        position = _position_at_rest(time, block, blocks)
        deformation = position - previous - varied.rest_length[block]
        previous = position
        rate = law.compression_rate if deformation < 0.0 else law.extension_rate
        linear = min(abs(deformation), law.linear_limit)
        excess = abs(deformation) - linear
        beyond = abs(tension(deformation, law)) - linear
        stored = 0.5 * linear * linear + excess * linear + (beyond - excess) / rate
        energy += stored * varied.stiffness[block]
    return energy

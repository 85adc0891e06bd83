"""Slips of the blocks: counts, laminar phases of the last block, avalanches."""

from collections.abc import Sequence

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
from beltrepro.engine.vector import inlined, kernel


class SlipActivity:
    """Slips and sticks per block, laminar phases and last stick of the last block of W chains.

    A laminar phase is a slip of the last block that lasts longer than `laminar_time` (Sec. IV.B:
    the periodic state is one of continuous slip); only time after `start` counts.
    """

    def __init__(self, states: Sequence[ChainState], start: float, laminar_time: float) -> None:
        self._start, self._end = start, start
        self._laminar_time = laminar_time
        width, n_blocks = len(states), states[0].parameters.n_blocks
        self._counts = np.zeros((2, width, n_blocks), dtype=np.int64)
        self.stick_count, self.slip_count = self._counts
        # of the last block, NaN while it is stuck; where it slips already, since when is not known
        moving = [state.directions[-1] != 0 for state in states]
        self.slipping_since = np.where(moving, states[0].time, np.nan)
        self.last_stick_time = np.full(width, np.nan)
        self._laminar = np.zeros((3, width))  # count, sum and maximum of the lengths

    def observe(self, chunk: Chunk) -> None:
        self._end = chunk.end
        limits, events = (self._start, self._laminar_time), (chunk.events, chunk.event_count)
        last = self.slipping_since, self.last_stick_time, self._laminar
        _follow(*events, limits, self._counts, *last)

    def laminar(self) -> dict[str, np.ndarray]:
        """laminar_fraction, _count, _mean (NaN of none), _longest (W,), with the slip going on.

        Where no phase fits into the time observed its share and the longest are not known, NaN.
        """
        count, total, longest = self._laminar
        going_on = self._end - np.maximum(self.slipping_since, self._start)
        going_on = np.where(going_on > self._laminar_time, going_on, 0.0)  # NaN while it is stuck
        count, total = count + (going_on > 0), total + going_on
        observed = self._end - self._start
        if observed <= self._laminar_time:
            total, longest = np.full((2, len(total)), np.nan)
        return {
            "laminar_fraction": total / max(observed, np.finfo(float).tiny),
            "laminar_count": count.astype(np.int64),
            "laminar_mean": np.divide(
                total, count, out=np.full_like(total, np.nan), where=count > 0
            ),
            "laminar_longest": np.maximum(longest, going_on),
        }


@kernel
def _follow(events, event_count, limits, counts, slipping_since, last_stick_time, laminar):
    start, laminar_time = limits
    last_block = counts.shape[2] - 1
    for lane in range(events.shape[0]):
        for index in range(event_count[lane]):
            time = events[lane, index, EVENT_TIME]
            block = int(events[lane, index, EVENT_BLOCK])
            slips = events[lane, index, EVENT_SLIP] > 0.0
            if time >= start:
                counts[int(slips), lane, block] += 1
            if block != last_block:
                continue
            if slips:
                slipping_since[lane] = time
                continue
            length = time - max(slipping_since[lane], start)
            if time > start and length > laminar_time:
                laminar[0, lane] += 1
                laminar[1, lane] += length
                laminar[2, lane] = max(laminar[2, lane], length)
            slipping_since[lane] = np.nan
            last_stick_time[lane] = time


class MostStuck:
    """The largest number of blocks that were stuck at one time, and the number of events."""

    def __init__(self, n_stuck: np.ndarray) -> None:
        self._now = np.array(n_stuck)
        self.most, self.events = self._now.copy(), np.zeros_like(self._now)

    def observe(self, chunk: Chunk) -> None:
        self.events += chunk.event_count
        for lane, count in enumerate(chunk.event_count):
            events = chunk.events[lane, :count]
            changes = np.where(events[:, EVENT_SLIP] > 0, -1, 1)
            stuck = self._now[lane] + np.cumsum(changes)
            # a block that reverses sticks and slips at one instant: it does not count in between
            lasts = np.diff(events[:, EVENT_TIME], append=np.inf) > 0
            self.most[lane] = stuck[lasts].max(initial=self.most[lane])
            self._now[lane] += changes.sum()


class EventLog:
    """Keeps the events of all chains: for single runs and catalogues."""

    def __init__(self, width: int, rest_positions: np.ndarray) -> None:
        self._rest_positions = rest_positions
        self._parts: list[list[np.ndarray]] = [[] for _ in range(width)]

    def observe(self, chunk: Chunk) -> None:
        for lane, parts in enumerate(self._parts):
            parts.append(chunk.events[lane, : chunk.event_count[lane]].copy())

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
# What is known of a block while the events are read: its last stick, and its last slip with the
# friction loss before it.
_KNOWN = ("stick_time", "stick_position", "slip_time", "slip_position", "slip_loss")
_BLOCK = np.dtype([*((name, "f8") for name in _KNOWN), ("in_avalanche", "?")])


def slips_and_avalanches(
    events: np.ndarray, point: int, state: ChainState, law_constants: Law, start: float
) -> tuple[np.ndarray, np.ndarray]:
    """Slips of all blocks and avalanches of one chain (Sec. IV.A, Fig. 9).

    A slip runs from slip to stick of one block. An avalanche is a maximal interval in which at
    least one block slips; before and after it all blocks are stuck. What has begun before the first
    event is left out.
    """
    chain = state.parameters
    blocks = np.zeros(chain.n_blocks, _BLOCK)
    blocks["stick_time"], blocks["stick_position"] = state.time, state.positions
    blocks["slip_time"] = -np.inf  # earlier than any start
    slips, avalanches = np.zeros(len(events), SLIP), np.zeros(len(events), AVALANCHE)
    slips["point"] = avalanches["point"] = point
    law, moving = (law_constants, of_blocks(chain)), np.count_nonzero(state.directions)
    counts = _collect(events, start, moving, chain.belt_velocity, *law, blocks, slips, avalanches)
    return slips[: counts[0]].copy(), avalanches[: counts[1]].copy()


@kernel
def _collect(events, start, moving, belt_velocity, law, varied, blocks, slips, avalanches):
    """Write slips and avalanches, and count them; `moving` blocks slip before the first event."""
    began, energy, length, loss, n_starts = -np.inf, 0.0, 0.0, 0.0, 0
    n_slips, n_avalanches = 0, 0
    goes_on = False
    for index in range(len(events)):
        time = events[index, EVENT_TIME]
        block = blocks[int(events[index, EVENT_BLOCK])]
        if events[index, EVENT_SLIP] > 0.0:
            if moving == 0 and not goes_on:
                began, loss, n_starts = time, 0.0, 0
                energy, length = _at_rest(time, belt_velocity, law, varied, blocks)
                for other in range(len(blocks)):
                    blocks[other].in_avalanche = False
            moving += 1
            n_starts += 1
            block.in_avalanche = True
            block.slip_time = time
            block.slip_position = events[index, EVENT_POSITION]
            block.slip_loss = events[index, EVENT_DISSIPATED]
            continue
        moving -= 1
        block.stick_time = time
        block.stick_position = events[index, EVENT_POSITION]
        dissipated = events[index, EVENT_DISSIPATED] - block.slip_loss
        loss += dissipated
        if block.slip_time >= start:
            slip = slips[n_slips]
            slip.block = int(events[index, EVENT_BLOCK]) + 1
            slip.start_time, slip.stop_time = block.slip_time, time
            slip.start_position, slip.stop_position = block.slip_position, block.stick_position
            slip.dissipated = dissipated
            n_slips += 1
        # a block that reverses sticks and slips at one instant: the avalanche goes on
        goes_on = (
            index + 1 < len(events)
            and events[index + 1, EVENT_TIME] == time
            and events[index + 1, EVENT_SLIP] > 0.0
        )
        if moving == 0 and not goes_on and began >= start:
            energy_after, length_after = _at_rest(time, belt_velocity, law, varied, blocks)
            avalanche = avalanches[n_avalanches]
            avalanche.start_time, avalanche.stop_time = began, time
            avalanche.slips = n_starts
            for other in range(len(blocks)):
                avalanche.blocks += blocks[other].in_avalanche
            avalanche.dissipated = loss
            avalanche.spring_energy_drop = energy - energy_after
            avalanche.last_block_displacement = length_after - length
            n_avalanches += 1
    return n_slips, n_avalanches


@inlined
def _at_rest(time, belt_velocity, law, varied, blocks):
    """Energy of the springs, and place of the last block, while the belt carries all blocks."""
    energy, position = 0.0, 0.0
    for block in range(len(blocks)):
        before = position
        age = time - blocks[block].stick_time
        position = blocks[block].stick_position + belt_velocity * age
        deformation = position - before - varied.rest_length[block]
        energy += _stored(deformation, law) * varied.stiffness[block]
    return energy, position


@inlined
def _stored(deformation, law):
    """Energy of a spring of stiffness 1.

    By the tension, as in `beltrepro.model.spring`: catalogues keep their bits. That of the engine,
    `spring_energy`, is the same to rounding.
    """
    rate = law.compression_rate if deformation < 0.0 else law.extension_rate
    linear = min(abs(deformation), law.linear_limit)
    excess = abs(deformation) - linear
    beyond = abs(tension(deformation, law)) - linear
    return 0.5 * linear * linear + excess * linear + (beyond - excess) / rate

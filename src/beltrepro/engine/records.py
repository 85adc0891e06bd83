"""What kernels record, shared by the integrators and the observers, and how kernels return.

Positions are displacements from the rest positions, times are those since the start of the run.
"""

from typing import NamedTuple

import numpy as np

from beltrepro.engine.simd import load, mask_bits, store_where
from beltrepro.engine.vector import inlined

EVENT_TIME, EVENT_BLOCK, EVENT_SLIP, EVENT_FORCE, EVENT_POSITION, EVENT_DISSIPATED = range(6)
EVENT_FIELDS = 6
CROSSINGS_AT_ONCE = 8  # of one chain in one step of the series; more wait for the next chunk

# What a kernel says when it returns: all is done; a buffer is full; a chain hardly advances; two
# blocks, or a block and the wall, meet.
DONE, EVENTS_FULL, CROSSINGS_FULL, STORM, CONTACT = range(5)


class Events(NamedTuple):
    """Starts and ends of slips of W chains."""

    rows: np.ndarray  # (W, E, EVENT_FIELDS), columns as above, blocks from 0
    count: np.ndarray  # (W,) rows in use


class Crossings(NamedTuple):
    """Downward crossings of a section by W chains."""

    block: int  # whose position is looked at, from 0; -1: no section
    level: np.ndarray  # (W,) its displacement from the rest position
    rows: np.ndarray  # (W, C, 1+2N) time, displacements, relative velocities
    count: np.ndarray  # (W,) rows in use


class Samples(NamedTuple):
    """Samples of W chains at instants first + m interval, m = 0, 1, ..., of one call of a kernel.

    first and interval are model times, or numbers of steps, since the start of the call.
    """

    values: np.ndarray  # (3, B, W, S) displacement, relative velocity, kinetic friction
    following: np.ndarray  # (W,) the next m of each chain
    first_block: int  # the first of the B blocks, from 0
    first: float
    interval: float
    count: int  # instants


class Records(NamedTuple):
    """All that a kernel records."""

    samples: Samples
    events: Events
    crossings: Crossings


@inlined
def record_event(chain, time, block, slips, force, position, loss, events):
    """Add a record to the events of a chain; slips : 1 start of a slip, 0 its end."""
    slot = events.count[chain]
    events.rows[chain, slot, EVENT_TIME] = time
    events.rows[chain, slot, EVENT_BLOCK] = block
    events.rows[chain, slot, EVENT_SLIP] = slips
    events.rows[chain, slot, EVENT_FORCE] = force
    events.rows[chain, slot, EVENT_POSITION] = position
    events.rows[chain, slot, EVENT_DISSIPATED] = loss
    events.count[chain] = slot + 1


@inlined
def write_samples(samples, chain, block, row, position, relative, friction, due):
    """Write those of eight samples of a block of a chain, from a row on, that are due."""
    shown = block - samples.first_block
    store_where(samples.values, (0, shown, chain, row), position, due)
    store_where(samples.values, (1, shown, chain, row), relative, due)
    store_where(samples.values, (2, shown, chain, row), friction, due)


@inlined
def full_buffer(lane, n_events, n_crossings, records):
    """What is full if one of eight chains has no room for so many more, else DONE."""
    events, crossings = records.events, records.crossings
    if mask_bits(load(events.count, (lane,)) + n_events > events.rows.shape[1]) != 0:
        return EVENTS_FULL
    crossed = load(crossings.count, (lane,)) + n_crossings > crossings.rows.shape[1]
    if crossings.block >= 0 and mask_bits(crossed) != 0:
        return CROSSINGS_FULL
    return DONE

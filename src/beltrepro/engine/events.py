"""The record of one event, shared by the integrators and the observers, and how kernels return.

The position is a displacement from the rest position, the time is that since the start of the run.
"""

from beltrepro.engine.vector import inlined

EVENT_TIME, EVENT_BLOCK, EVENT_SLIP, EVENT_FORCE, EVENT_POSITION, EVENT_DISSIPATED = range(6)
EVENT_FIELDS = 6

# What a kernel says when it returns: all is done; a buffer is full; a chain hardly advances.
DONE, EVENTS_FULL, CROSSINGS_FULL, STORM = range(4)


@inlined
def record_event(chain, time, block, slips, force, position, loss, events, event_count):
    """Add a record to those of a chain: events (W, E, 6), fields as above; event_count (W,)."""
    slot = event_count[chain]
    events[chain, slot, EVENT_TIME] = time
    events[chain, slot, EVENT_BLOCK] = block
    events[chain, slot, EVENT_SLIP] = slips
    events[chain, slot, EVENT_FORCE] = force
    events[chain, slot, EVENT_POSITION] = position
    events[chain, slot, EVENT_DISSIPATED] = loss
    event_count[chain] = slot + 1

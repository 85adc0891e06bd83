"""Layout of the record of one event, shared by the integrators and the observers.

The position is a displacement from the rest position, the time is that since the start of the run.
"""

EVENT_TIME, EVENT_BLOCK, EVENT_SLIP, EVENT_FORCE, EVENT_POSITION, EVENT_DISSIPATED = range(6)
EVENT_FIELDS = 6

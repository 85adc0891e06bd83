"""The periodic orbit on which a sampled motion settles."""

import numpy as np
import pytest

from beltrepro.replication.studies.transition.measure import settled_orbit

INTERVAL = 0.1


def motion(phase, *, blocks=3):
    """Positions and velocities of blocks that follow a phase in time (T,)."""
    shift = 0.7 * np.arange(blocks)
    angle = phase[:, np.newaxis] + shift
    positions = 600 + 30 * np.sin(angle) + 12 * np.cos(3 * angle)
    return positions, np.gradient(positions, INTERVAL, axis=0)


def with_transient(until, period, *, length=20_000):
    """The phase wanders up to an instant and then runs on evenly."""
    time = INTERVAL * np.arange(length)
    rate = np.full(length, 2 * np.pi / period)
    early = time < until
    wander = np.random.default_rng(4).uniform(0.3, 2, int(until) + 1)
    rate[early] *= wander[time[early].astype(int)]
    return time, *motion(np.cumsum(rate) * INTERVAL)


@pytest.mark.parametrize(("until", "period"), [(1000.0, 13.7), (300.0, 40.3)])
def test_orbit_after_a_transient(until, period):
    since, length = settled_orbit(*with_transient(until, period))
    assert length == pytest.approx(period, rel=1e-3)
    # the end of the transient is seen at the next crossing
    assert until - period < since < until + 2 * period


def test_a_motion_of_two_frequencies_does_not_repeat_itself():
    time = INTERVAL * np.arange(20_000)
    first, second = (motion(time * rate) for rate in (0.5, 0.5 / np.sqrt(3)))
    both = (first[0] + 0.5 * (second[0] - 600), first[1] + 0.5 * second[1])
    assert settled_orbit(time, *both) is None

"""What stops a run that cannot go on: states that are no numbers, events that fill a buffer."""

from dataclasses import replace

import numpy as np
import pytest

from advancing import small_buffers
from beltrepro import ChainParameters, ChainState
from beltrepro.base.errors import ModelStateError
from beltrepro.engine import integrator as engine
from beltrepro.simulation.groups import integrator_of
from beltrepro.simulation.setup import Setup

CHAINS = [ChainParameters(2, 5.0), ChainParameters(2, 9.0), ChainParameters(2, 7.0)]


@pytest.mark.parametrize("method", ["event", "verlet"])
@pytest.mark.parametrize("share", [0.8, 1.2])
def test_a_buffer_of_events_doubles_up_to_a_size(monkeypatch, method, share):
    group = integrator_of(Setup(CHAINS, method=method).cases)
    small_buffers(group, 4, 4)
    largest = group._events.rows.nbytes * 8  # after three doublings
    monkeypatch.setattr(engine, "_LARGEST_BUFFER", int(share * largest))
    with pytest.raises(
        ModelStateError, match=r"u=\d.*: \d+ events since t = 0 are too many to record"
    ):
        for _ in group.advance(200.0):
            pass
    assert group._events.rows.nbytes == largest / (2 if share < 1 else 1)


@pytest.mark.parametrize("method", ["event", "verlet"])
@pytest.mark.parametrize("lane", [0, 2])
def test_a_state_that_is_no_number_stops_with_the_chain_and_the_time(method, lane):
    group = integrator_of(Setup(CHAINS, method=method).cases)
    group._lanes().displacements[1, lane] = np.nan
    with pytest.raises(ModelStateError, match=rf"u={CHAINS[lane].belt_velocity:g}.*not finite at"):
        for _ in group.advance(5.0):
            pass


def test_states_are_equal_bit_by_bit():
    state = ChainState.at_rest(CHAINS[0])
    assert state == replace(state) and state != replace(state, time=1.0)
    near = state.displacements + np.array([0.0, 1e-300])
    assert state != replace(state, displacements=near) and state != 5
    kept = replace(state, scheme={"a": np.array([1.0, np.nan])})
    assert kept == replace(state, scheme={"a": np.array([1.0, np.nan])}) != state
    for other in ({"b": kept.scheme["a"]}, {"a": np.array([1.0, 2.0])}, {"a": np.ones((1, 2))}):
        assert kept != replace(state, scheme=other)

"""Kicks at the starts of slips: their size, what they stand for, and what they leave alone."""

import numpy as np
import pytest
from scipy import stats

from beltrepro import ChainParameters, Setup
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import Sampling
from beltrepro.engine.kicks import KickedIntegrator
from beltrepro.engine.records import EVENT_BLOCK, EVENT_POSITION, EVENT_SLIP, EVENT_TIME
from beltrepro.model.scheme_error import equivalent_kick
from beltrepro.observe.slips import EventLog
from beltrepro.simulation.groups import integrator_of, observe

SAMPLING = Sampling(1000, 0.001)


def chains_of(chain, replicates, kick, *, method="event", time_step=0.001, **settings):
    how = {"method": method, "time_step": time_step, "kick": kick, "initial_spread": 1.0} | settings
    return Setup(chain, replicate=replicates, **how).cases


def run(members, duration):
    integrator = integrator_of(members, sampling=SAMPLING, sampled_blocks=1)
    log = EventLog(len(members), np.zeros(members[0].parameters.n_blocks))  # displacements
    observe(integrator, duration, [log], lambda fraction: None)
    return integrator, log


def kicked_integrator(members):
    """Chains of which some have a kick of zero, advanced together."""
    states, sizes = zip(*((case.state, case.kick) for case in members), strict=True)
    settings = {"time_step": 0.001, "sampling": SAMPLING, "sampled_blocks": 1}
    integrator = KickedIntegrator(states, sizes=sizes, **settings)
    observe(integrator, 500.0, [], lambda fraction: None)
    return integrator


def first_slips(members):
    """How far on the belt the first slip of a chain of one block brings it (W,)."""
    _, log = run(members, 40.0)
    ends = []
    for lane, point in enumerate(members):
        rows = log.events(lane)
        stick = rows[rows[:, EVENT_SLIP] == 0][0]
        moved = stick[EVENT_POSITION] - point.state.displacements[0]
        ends.append(moved - point.parameters.belt_velocity * stick[EVENT_TIME])
    return np.array(ends)


def scattered(chain, kick=0.0, **how):
    """First slips from 320 starts, beside that of the exact motion."""
    exact = first_slips(chains_of(ChainParameters(1, 3.0), [1], 0.0))
    starts = [range(first, first + 32) for first in range(1, 320, 32)]
    return np.concatenate([first_slips(chains_of(chain, s, kick, **how)) for s in starts]) - exact


def test_a_kick_scatters_the_places_of_sticks_as_late_starts_do():
    """One block: the scheme lets it stick 2 u t less far on the belt, t within half a step."""
    step, chain = 0.001, ChainParameters(1, 3.0)
    late = scattered(chain, method="verlet", time_step=step)
    kicked = scattered(chain, equivalent_kick(3.0, step), time_step=step)
    # 2 t / dt is uniform, beside a dt^2 / 2 = 2e-5 at the stick, one part in 150
    assert stats.kstest(late / (3.0 * step), stats.uniform(-1.0, 2.0).cdf).pvalue > 1e-3
    assert stats.kstest(kicked / (3.0 * step), stats.norm(0, 3**-0.5).cdf).pvalue > 1e-3
    # five standard errors of a ratio of standard deviations
    assert late.std() / kicked.std() == pytest.approx(1.0, abs=5 / np.sqrt(320))


def test_a_threshold_scatters_them_as_a_kick_of_twice_its_size_for_one_spring():
    """A threshold larger by f lets one spring stretch f further: u t = f, and s = 2 u t."""
    size = 0.01
    # in so short a step noise does nothing to a block that slips
    noisy = scattered(ChainParameters(1, 3.0, noise=size), time_step=1e-9)
    for places in (noisy, scattered(ChainParameters(1, 3.0), 2 * size)):
        assert stats.kstest(places / (2 * size), "norm").pvalue > 1e-3


def moves_of_stuck_blocks(integrator, log, lane):
    """How far blocks are from where they stuck, on the belt, at the start of their next slip."""
    rows, belt = log.events(lane), integrator.parameters[lane].belt_velocity
    moves = []
    for block in range(integrator.n_blocks):
        chosen = rows[rows[:, EVENT_BLOCK] == block]
        place = chosen[:, EVENT_POSITION] - belt * chosen[:, EVENT_TIME]
        ends = np.flatnonzero(chosen[:-1, EVENT_SLIP] == 0)
        moves.append(place[ends + 1] - place[ends])
    return np.concatenate(moves)


def test_blocks_rest_on_the_belt_until_they_are_kicked():
    """The record of a start is that of the event itself, before the kick."""
    integrator, log = run(chains_of(ChainParameters(5, 7.0), [1], 0.1), 200.0)
    assert np.abs(moves_of_stuck_blocks(integrator, log, 0)).max() < 1e-11


def test_a_kick_of_zero_gives_the_bits_of_event_and_the_energy_balance_closes():
    sizes = np.array([0.0, 1e-8, 1e-3, 0.1, 1.0])
    members = [chains_of(ChainParameters(5, 7.0), [2], size)[0] for size in sizes]
    together = kicked_integrator(members)
    assert np.abs(together.energy_residual()).max() < 1e-13
    plain, _ = run([members[0]], 500.0)
    assert together.state()[0] == plain.state()[0]
    apart = np.abs(together.positions() - together.positions()[0]).max(axis=1)
    assert 0 < apart[1] < 1e-5 < apart[2] < apart[4]
    noisy, _ = run(chains_of(ChainParameters(5, 7.0, noise=2.2), range(1, 9), 0.1), 500.0)
    assert np.abs(noisy.energy_residual()).max() < 1e-8


def displaced(size, count):
    """Moves of block 1 of `count` chains at its first start, on the series of the next instant."""
    chain = ChainParameters(2, 1.0)
    exact, log = run(chains_of(chain, [0], 0.0), 100.0)
    begins = log.events(0)[0, EVENT_TIME]
    soon = begins + 1e-9
    exact, _ = run(chains_of(chain, [0], 0.0), soon)
    moved, _ = run(chains_of(chain, range(1, count + 1), size, initial_spread=0.0), soon)
    return moved.positions()[:, 0] - exact.positions()[0, 0]


def test_kicks_are_normal_with_the_size_given():
    moves = displaced(0.01, 32)
    assert stats.kstest(moves / 0.01, "norm").pvalue > 1e-3
    np.testing.assert_allclose(displaced(0.02, 32), 2 * moves, rtol=1e-5, atol=1e-9)


def test_a_kicked_run_does_not_depend_on_its_company_nor_on_where_it_was_cut():
    chain = ChainParameters(5, 7.0)
    company = [
        chains_of(chain, [replicate], kick)[0] for replicate, kick in ((1, 0.1), (2, 1e-3), (3, 0))
    ]
    together = kicked_integrator(company)
    for lane in 0, 1:
        first, _ = run([company[lane]], 250.0)
        rest = {"initial_spread": 0.0, "initial_state": first.state()[0]}
        again = chains_of(chain, [lane + 1], company[lane].kick, **rest)
        alone, _ = run(again, 250.0)
        assert alone.state()[0] == together.state()[lane]


def test_the_scheme_has_no_kicks():
    with pytest.raises(InputError, match=r"^kick = 0.1: method 'verlet' has none, only 'event'$"):
        chains_of(ChainParameters(5, 7.0), [1], 0.1, method="verlet")

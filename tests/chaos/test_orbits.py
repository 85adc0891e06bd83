"""Periodic orbits: those of tests/data/periodic_orbits.json, and what has no orbit.

Each record of the file says how its orbit was `found` in double precision; Newton's method in the
arithmetic of exact.py then closed it. What follows it again needs neither.
"""

import dataclasses
import json
import math
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from mpmath import mp

from advancing import sliding
from beltrepro import ChainParameters, ChainState, classify, periodic_orbit, simulate
from beltrepro.base.errors import InputError
from beltrepro.chaos.periodic_orbits import _undivided, close_orbit
from exact import ONE, Deviations, ExactChain, fixed, real

RECORDS = json.loads((Path(__file__).parents[1] / "data" / "periodic_orbits.json").read_text())
SHORT = 4  # slips in a period that is followed with forty digits in a second
MIDDLE = 70  # and with deviations in minutes
CLOSED = 1e-30
FIVE = next(
    number
    for number, record in enumerate(RECORDS)
    if (record["n_blocks"], record["belt_velocity"], record["period_events"]) == (5, 16.0, 18)
)


def orbits(slow_above=10**6, most=10**6):
    """Tests of the records up to so many slips; those of more than some are slow."""
    return pytest.mark.parametrize(
        "number",
        [
            pytest.param(
                number,
                marks=[pytest.mark.slow] if record["period_events"] > slow_above else [],
                id="N{n_blocks}-u{belt_velocity:g}-{period_events}slips".format(**record),
            )
            for number, record in enumerate(RECORDS)
            if record["period_events"] <= most
        ],
    )


@cache
def in_double(number):
    record = RECORDS[number]
    names = ("displacements", "relative_velocities", "directions")
    numbers = {name: np.array(list(map(float, record[name]))) for name in names}
    chain = ChainParameters(record["n_blocks"], record["belt_velocity"])
    state = dataclasses.replace(ChainState.at_rest(chain), **numbers)
    return state, close_orbit(state, float(record["period_time"]))


def once_around(record, *, tangent=False):
    """Follow an orbit for its period: the chain, by how much it misses its start, tangent map.

    In the coordinates of docs/chaos.md; the map (D, D) is None if not asked for. With the flow.
    """
    names = ("belt_velocity", "displacements", "relative_velocities", "directions")
    chain = ExactChain.of(*(record[name] for name in names))
    begin, flow, blocks = (chain.y, chain.v), chain.flow(), range(1, len(chain.y))
    free = [(0, i) for i in blocks] + [(1, i) for i in blocks if chain.direction[i]]
    if tangent:
        unit = np.zeros((len(free), 2, len(chain.y)), dtype=object)
        for column, (what, i) in zip(unit, free, strict=True):
            column[what, i] = ONE
        chain.deviations = Deviations(unit.tolist())
    chain.advance(until=fixed(record["period_time"]))
    end, matrix = (chain.y, chain.v), None
    if tangent:
        columns = chain.deviations.columns()
        matrix = mp.matrix([[real(column[what][i]) for column in columns] for what, i in free])
    apart = [real(end[what][i] - begin[what][i]) for what, i in free]
    return chain, apart, mp.matrix([real(flow[what][i]) for what, i in free]), matrix


def multipliers(matrix):
    """Eigenvalues of a tangent map of a period but the trivial one, largest modulus first."""
    values = sorted(mp.eig(matrix, right=False), key=lambda mu: abs(mu - 1))
    return sorted(values[1:], key=lambda mu: -abs(mu))


@orbits()
def test_each_closes_in_double_precision(number):
    record, (_, orbit) = RECORDS[number], in_double(number)
    assert orbit.residual < 1e-11
    assert orbit.period_events == record["period_events"]
    assert len(orbit.run(sample_interval=None).events) == record["n_events"]
    assert orbit.period_time == pytest.approx(float(record["period_time"]), rel=1e-11)
    assert orbit.erased == np.sum(orbit.multipliers == 0) == record["erased"]
    assert orbit.multipliers[orbit.trivial] == 1
    sizes = [abs(complex(*map(float, parts))) for parts in record["multipliers"]]
    assert abs(orbit.largest_multiplier) == pytest.approx(max(sizes, default=0), rel=1e-5, abs=1e-9)


@orbits(slow_above=SHORT)
def test_each_closes_with_forty_digits(number):
    """One period in exact arithmetic, by the events of the run in double precision."""
    record, (start, _) = RECORDS[number], in_double(number)
    chain, apart, *_ = once_around(record)
    assert max(map(abs, apart)) < CLOSED
    assert chain.direction[1:] == record["directions"]
    how = {"initial_state": start, "sample_interval": None}
    events = simulate(start.parameters, duration=float(record["period_time"]), **how).events
    instants = [float(real(time)) for time, *_ in chain.events]
    assert [event[1:] for event in chain.events] == events[["block", "kind"]].tolist()
    assert instants == pytest.approx(events["time"], abs=1e-8)


@orbits(slow_above=SHORT, most=MIDDLE)
def test_each_attracts_by_deviations_with_forty_digits(number):
    record, (_, orbit) = RECORDS[number], in_double(number)
    with mp.workdps(50):
        _, _, flow, matrix = once_around(record, tangent=True)
        carried = max(abs(value) for value in matrix * flow - flow)
        assert carried < CLOSED * max(map(abs, flow))
        calculated = multipliers(matrix)
    exact = np.array(matrix.tolist(), dtype=float)
    assert np.abs(orbit.monodromy - exact).max() < 1e-9 * np.abs(exact).max()
    # of a conjugate pair, which has one modulus, either may come first
    printed = [complex(*map(float, parts)) for parts in record["multipliers"]]
    upper, expected = (
        [complex(mu.real, abs(mu.imag)) for mu in each] for each in (calculated, printed)
    )
    assert upper == pytest.approx(expected, rel=1e-12, abs=1e-15)
    assert all(abs(mu) < 1 for mu in calculated)


def test_any_instant_of_the_orbit_will_do():
    """States of the orbit by turns of a period, with some blocks slipping."""
    state, five = in_double(FIVE)
    how = {"initial_state": state, "sample_interval": None}
    states = [
        simulate(state.parameters, duration=share * five.period_time, **how).final_state
        for share in (0.21, 0.55, 0.83)
    ]
    assert any(np.any(state.directions != 0) for state in states)
    for state in states:
        orbit = close_orbit(state, five.period_time)
        assert orbit.period_time == pytest.approx(five.period_time, abs=1e-10)
        assert orbit.multipliers == pytest.approx(five.multipliers, abs=1e-9)


LENGTHS = {"duration": 4000.0, "transient": 2000.0, "replicate": 1, "initial_spread": 1.0}


def test_r_and_mean_length_are_those_of_a_run_of_whole_periods():
    """Samples every 0.1 in one, samples that divide the period in the other."""
    two = periodic_orbit(ChainParameters(2, 5.0), **LENGTHS)
    how = {"initial_state": two.state, "sample_interval": None}
    run = simulate(two.parameters, duration=100 * two.period_time, **how)
    assert run.disorder_parameter == pytest.approx(two.disorder_parameter, rel=1e-4)
    assert run.mean_length == pytest.approx(two.mean_length, rel=1e-5)
    motion = classify([two.parameters], **LENGTHS)
    assert motion["period_time"][0] == pytest.approx(two.period_time, abs=1e-9)
    for name in ("period_events", "period_returns"):
        assert motion[name][0] == getattr(two, name)


def test_one_period_of_an_orbit_is_no_run_that_is_too_short():
    orbit = periodic_orbit(ChainParameters(1, 0.5), duration=2000, transient=500)
    with warnings.catch_warnings(action="error"):
        assert orbit.run().final_state.time == orbit.period_time


def test_an_orbit_of_one_block_closes_where_its_spring_is_slack():
    """After whole periods it is back where it began, up to rounding, with all coordinates zero."""
    chain = ChainParameters(1, 3.0, friction_ratio=0.01, rest_length=300, linear_limit=math.inf)
    drop, swing = 0.99 * 71.4, 2 * math.pi - 2 * math.atan2(0.99 * 71.4, 3.0)
    period = 2 * drop / 3.0 + swing  # stuck, and slipping
    orbit = periodic_orbit(chain, duration=210 * period, transient=10 * period)
    assert orbit.period_time == pytest.approx(period, rel=1e-12)
    assert abs(orbit.state.displacements[0]) < 1e-6 and orbit.residual < 1e-11


@pytest.mark.parametrize("transient", [1.0, 3.0, 5.0])
def test_an_orbit_is_found_in_whatever_is_left_of_the_loading(transient):
    orbit = periodic_orbit(ChainParameters(3, 12.0), duration=4000, transient=transient)
    assert orbit.period_time == pytest.approx(29.09813323, abs=1e-6)


def test_an_orbit_that_comes_back_after_two_periods_first_is_one_of_one_period():
    """As close to a period doubling, where what is left of a deviation changes sides for long."""
    orbit = periodic_orbit(ChainParameters(2, 5.0), **LENGTHS)
    twice = close_orbit(orbit.state, 2 * orbit.period_time)
    assert twice.period_events == 2 * orbit.period_events
    single = _undivided(twice, None)
    assert single.period_events == orbit.period_events
    assert single.period_time == pytest.approx(orbit.period_time, rel=1e-12)
    assert _undivided(single, None) is single


def test_an_orbit_closes_to_the_tolerance_that_is_asked_for():
    """It is that of rough series, which is not the exact one."""
    about = {"chains": ChainParameters(3, 25.0), "duration": 6000.0, "transient": 4000.0}
    exact, rough = periodic_orbit(**about), periodic_orbit(**about, tolerance=1e-3)
    again = close_orbit(rough.state, rough.period_time, 1e-3)
    apart = abs(rough.period_time - exact.period_time)
    assert rough.residual < 1e-11 and abs(again.period_time - rough.period_time) < 1e-3 * apart
    assert 1e-9 < apart < 1e-2


def test_a_short_orbit_of_a_light_chain_has_the_r_of_a_long_one():
    """Of a mass of 1e-4 all times are 1/100, and a period is hardly longer than 0.1."""
    long = periodic_orbit(ChainParameters(2, 10.0), duration=6000.0, transient=1000.0)
    light = ChainParameters(2, 1000.0, mass=1e-4)
    short = periodic_orbit(light, duration=60.0, transient=10.0)
    assert 100 * short.period_time == pytest.approx(long.period_time, rel=1e-9)
    for name in ("disorder_parameter", "mean_length"):
        assert getattr(short, name) == pytest.approx(getattr(long, name), rel=1e-6)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"chains": ChainParameters(2, 5.0, 1.0)}, "noise = 1: must be 0"),
        ({"chains": ChainParameters(7, 10.0)}, "N=7, u=10, sigma=0: no state comes back"),
        ({"duration": 2010.0}, "N=2, u=5, sigma=0: no state comes back in the last 10 time units"),
        ({"transient": 0.0}, "transient = 0: must be greater than 0"),
    ],
)
def test_bad_input_is_one_line(changes, message):
    settings = {"chains": ChainParameters(2, 5.0), **LENGTHS} | changes
    with pytest.raises(InputError) as caught:
        periodic_orbit(**settings)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_what_does_not_come_back_is_one_line():
    chain = ChainParameters(7, 10.0)
    start = ChainState.at_rest(chain, chain.rest_positions + np.arange(7.0))
    irregular = simulate(chain, duration=3000.0, initial_state=start).final_state
    with pytest.raises(InputError, match="no orbit closes near the state after about the time 50"):
        close_orbit(irregular, 50.0)
    with pytest.raises(InputError, match="equilibrium slip"):
        close_orbit(sliding(ChainParameters(3, 60.0), np.array([0.5, -1.0, 1.5])), 50.0)

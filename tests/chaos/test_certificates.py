"""The orbits of tests/data/periodic_orbits.json close with 40 digits, and attract.

Each record says how its orbit was `found` in double precision; Newton's method in the arithmetic of
exact.py then closed it. What follows it again needs neither.
"""

import dataclasses
import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from mpmath import mp

from beltrepro import ChainParameters, ChainState, simulate
from beltrepro.chaos.periodic_orbits import close_orbit
from exact import ONE, Deviations, ExactChain, fixed, real

TESTS = Path(__file__).parents[1]
RECORDS = json.loads((TESTS / "data" / "periodic_orbits.json").read_text())
SHORT = 4  # slips in a period that is followed in a second
MIDDLE = 70  # and with deviations in minutes
CLOSED = 1e-30


def chain_of(record):
    """The start of an orbit of the file, in exact arithmetic."""
    names = ("belt_velocity", "displacements", "relative_velocities", "directions")
    return ExactChain.of(*(record[name] for name in names))


def once_around(record, *, tangent=False):
    """Follow an orbit for its period: the chain, by how much it misses its start, tangent map.

    In the coordinates of docs/chaos.md; the map (D, D) is None if not asked for.
    """
    chain = chain_of(record)
    begin, free = _numbers(chain), _free(chain)
    if tangent:
        chain.deviations = Deviations([_unit(len(chain.y), *place) for place in free])
    chain.advance(until=fixed(record["period_time"]))
    end = _numbers(chain)
    apart = [real(end[what][i] - begin[what][i]) for what, i in free]
    if not tangent:
        return chain, apart, None
    columns = chain.deviations.columns()
    rows = [[real(column[what][i]) for column in columns] for what, i in free]
    return chain, apart, mp.matrix(rows)


def _numbers(chain):
    return chain.y, chain.v


def _free(chain):
    """The coordinates, as (0 for a displacement or 1 for a velocity, block)."""
    blocks = range(1, len(chain.y))
    return [(0, i) for i in blocks] + [(1, i) for i in blocks if chain.direction[i]]


def _unit(count, what, block):
    deviation = [0] * count, [0] * count
    deviation[what][block] = ONE
    return deviation


def multipliers(matrix, rates):
    """Eigenvalues of a tangent map of a period but the trivial one, largest modulus first.

    Modulo the flow, which is mapped to itself: the coordinate in which it is fastest is dropped,
    after as much of the flow is subtracted from each column as makes it zero there.
    """
    fastest = max(range(len(rates)), key=lambda i: abs(rates[i]))
    kept = [i for i in range(len(rates)) if i != fastest]
    if not kept:
        return []
    rest = [
        [matrix[i, j] - rates[i] * matrix[fastest, j] / rates[fastest] for j in kept] for i in kept
    ]
    across = mp.matrix(rest)
    return sorted(mp.eig(across, right=False), key=lambda mu: -abs(mu))


def multipliers_of(record):
    """Those of the file, without the trivial and the erased ones."""
    return [complex(*map(float, parts)) for parts in record["multipliers"]]


def name(record):
    chain = f"N{record['n_blocks']}-u{record['belt_velocity']:g}"
    return f"{chain}-{record['period_events']}slips"


def parametrize(chosen):
    return pytest.mark.parametrize("record", [r for r in RECORDS if chosen(r)], ids=name)


def state_of(record):
    """The start in double precision."""
    chain = ChainParameters(record["n_blocks"], record["belt_velocity"])
    numbers = {
        name: np.array([float(text) for text in record[name]])
        for name in ("displacements", "relative_velocities", "directions")
    }
    return dataclasses.replace(ChainState.at_rest(chain), **numbers)


@cache
def in_double(index):
    return close_orbit(state_of(RECORDS[index]), float(RECORDS[index]["period_time"]))


def check_closed(record):
    """One period in exact arithmetic, by the events of the run in double precision."""
    chain, apart, _ = once_around(record)
    assert max(abs(value) for value in apart) < CLOSED
    assert chain.direction[1:] == record["directions"]
    start, duration = state_of(record), float(record["period_time"])
    how = {"initial_state": start, "sample_interval": None}
    events = simulate(start.parameters, duration=duration, **how).events
    assert [event[1:] for event in chain.events] == list(
        zip(events["block"].tolist(), events["kind"].tolist(), strict=True)
    )
    instants = np.array([float(real(time)) for time, *_ in chain.events])
    assert np.abs(instants - events["time"]).max() < 1e-8


def check_multipliers(record):
    """From exact deviations; those of the file to 12 digits."""
    with mp.workdps(50):
        _, _, matrix = once_around(record, tangent=True)
        start = chain_of(record)
        flow = start.flow()
        rates = mp.matrix([real(flow[what][i]) for what, i in _free(start)])
        assert max(abs(value) for value in matrix * rates - rates) < CLOSED * max(map(abs, rates))
        calculated = multipliers(matrix, list(rates))
        size = max(map(abs, matrix))
    double = in_double(RECORDS.index(record)).monodromy
    exact = np.array(matrix.tolist(), dtype=float)
    assert np.abs(double - exact).max() < 1e-9 * float(size)  # the deviations of `event`
    # of a conjugate pair, which has one modulus, either may come first
    upper, expected = (
        [complex(mu.real, abs(mu.imag)) for mu in each]
        for each in (calculated, multipliers_of(record))
    )
    assert upper == pytest.approx(expected, rel=1e-12, abs=1e-15)
    assert all(abs(mu) < 1 for mu in calculated)


@pytest.mark.parametrize("index", range(len(RECORDS)), ids=lambda index: name(RECORDS[index]))
def test_each_closes_in_double_precision(index):
    record, orbit = RECORDS[index], in_double(index)
    assert orbit.residual < 1e-11
    assert orbit.period_events == record["period_events"]
    assert len(orbit.run(sample_interval=None).events) == record["n_events"]
    assert orbit.period_time == pytest.approx(float(record["period_time"]), rel=1e-11)
    assert orbit.erased == record["erased"]
    largest = max(map(abs, multipliers_of(record)), default=0)
    assert abs(orbit.largest_multiplier) == pytest.approx(largest, rel=1e-5, abs=1e-9)


@parametrize(lambda record: record["period_events"] <= SHORT)
def test_a_short_one_closes_with_forty_digits(record):
    check_closed(record)
    check_multipliers(record)


@pytest.mark.slow
@parametrize(lambda record: record["period_events"] > SHORT)
def test_each_closes_with_forty_digits(record):
    check_closed(record)


@pytest.mark.slow
@parametrize(lambda record: SHORT < record["period_events"] <= MIDDLE)
def test_each_attracts_by_deviations_with_forty_digits(record):
    check_multipliers(record)

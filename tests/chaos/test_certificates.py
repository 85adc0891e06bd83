"""The orbits of tests/data/periodic_orbits.json close with 40 digits, and attract."""

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from mpmath import mp

import certificates
from beltrepro import ChainParameters, ChainState, close_orbit, simulate
from beltrepro.engine.integrator import Sampling
from beltrepro.engine.tangent import TangentIntegrator
from exact import ONE, Deviations, ExactChain, fixed, real

RECORDS = certificates.records_of_file()
SHORT = 4  # slips in a period that is followed in a second
MIDDLE = 70  # and with deviations in minutes
CLOSED = 1e-30


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
    chain, apart, _ = certificates.once_around(record)
    assert max(abs(value) for value in apart) < CLOSED
    assert chain.direction[1:] == record["directions"]
    start = state_of(record)
    events = simulate(
        start.parameters,
        duration=float(record["period_time"]),
        method="event",
        initial_state=start,
        sample_interval=None,
    ).events
    assert [event[1:] for event in chain.events] == list(
        zip(events["block"].tolist(), events["kind"].tolist(), strict=True)
    )
    instants = np.array([float(real(time)) for time, *_ in chain.events])
    assert np.abs(instants - events["time"]).max() < 1e-8


def check_multipliers(record):
    """From exact deviations; those of the file to 12 digits."""
    with mp.workdps(certificates.DIGITS):
        _, _, matrix = certificates.once_around(record, tangent=True)
        rates = mp.matrix(certificates.flow(certificates.chain_of(record)))
        assert max(abs(value) for value in matrix * rates - rates) < CLOSED * max(map(abs, rates))
        found = certificates.multipliers(matrix, list(rates))
    # of a conjugate pair, which has one modulus, either may come first
    upper = [complex(mu.real, abs(mu.imag)) for mu in found]
    expected = [complex(mu.real, abs(mu.imag)) for mu in multipliers_of(record)]
    assert upper == pytest.approx(expected, rel=1e-12, abs=1e-15)
    assert all(abs(mu) < 1 for mu in found)


def multipliers_of(record):
    """Those of the file, without the trivial and the erased ones."""
    return [complex(*map(float, parts)) for parts in record["multipliers"]]


def test_the_page_shows_them():
    page = Path(__file__).parents[2] / "docs" / "chaos.md"
    assert certificates.table() in page.read_text()


def test_there_are_twenty_of_them_of_many_kinds():
    slips = [record["period_events"] for record in RECORDS]
    assert len(RECORDS) >= 20 and len(set(zip(slips, map(name, RECORDS), strict=True))) >= 20
    assert {record["n_blocks"] for record in RECORDS} >= {2, 3, 4, 5, 6, 7}
    assert min(slips) <= 3 and max(slips) >= 200
    assert all(float(record["residual"]) < CLOSED for record in RECORDS)
    assert all(certificates.largest_modulus(record) < 1 for record in RECORDS)


@pytest.mark.parametrize("index", range(len(RECORDS)), ids=lambda index: name(RECORDS[index]))
def test_each_closes_in_double_precision(index):
    record, orbit = RECORDS[index], in_double(index)
    assert orbit.residual < 1e-11
    assert orbit.period_events == record["period_events"]
    assert len(orbit.run(sample_interval=None).events) == record["n_events"]
    assert orbit.period_time == pytest.approx(float(record["period_time"]), rel=1e-11)
    assert orbit.erased == record["erased"]
    assert abs(orbit.largest_multiplier) == pytest.approx(
        certificates.largest_modulus(record), rel=1e-5, abs=1e-9
    )


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


# --- the deviations of `event` and those of 40 digits ---


@pytest.mark.parametrize(
    ("n_blocks", "belt_velocity", "until", "least"),
    [
        (2, 6.0, 100.0, 20),
        pytest.param(5, 20.0, 60.0, 50, marks=pytest.mark.slow),
        pytest.param(10, 30.0, 45.0, 50, marks=pytest.mark.slow),
    ],
)
def test_deviations_of_event_are_those_of_forty_digits(n_blocks, belt_velocity, until, least):
    """One random deviation of places and velocities, and the one along the motion."""
    chain = ChainParameters(n_blocks, belt_velocity)
    random = np.random.default_rng(2)
    state = ChainState.at_rest(chain, chain.rest_positions + random.standard_normal(n_blocks))
    ways = np.column_stack([random.standard_normal(n_blocks), np.full(n_blocks, belt_velocity)])
    exact = ExactChain.of(belt_velocity, state.displacements.tolist())
    still = [0] * (n_blocks + 1)
    exact.deviations = Deviations(
        [([0, *(fixed(w) for w in way)], still) for way in ways.T.tolist()]
    )
    exact.advance(until=fixed(until))
    columns = exact.deviations.columns()
    double = TangentIntegrator(
        [state], n_vectors=2, time_step=0.001, sampling=Sampling(1, 1.0), sampled_blocks=1
    )
    double.set_deviations(np.concatenate([ways, np.zeros_like(ways)])[None])
    events = sum(int(chunk.event_count[0]) for chunk in double.advance(until))
    assert len(exact.events) == events >= least
    expected = np.array(
        [[float(real(units)) for units in (*dy[1:], *dv[1:])] for dy, dv in columns]
    )
    found = double.deviations()[0].T
    assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()
    along = max(abs(dy - v) for dy, v in zip(columns[1][0], exact.v, strict=True))
    assert along < ONE * CLOSED

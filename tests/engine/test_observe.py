"""Observers on chunks made by hand: edges, ties, several chunks, reversals."""

import dataclasses
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

import naive
from beltrepro import ChainParameters
from beltrepro.engine.law import law_constants
from beltrepro.engine.state import ChainState
from beltrepro.model.spring import potential_energy
from beltrepro.observe.crossings import ReturnLog, SectionVelocities
from beltrepro.observe.length import LengthHistory, LengthMoments, Reach
from beltrepro.observe.slips import EventLog, MostStuck, SlipActivity, slips_and_avalanches
from beltrepro.observe.sum_rule import ForwardSlip

# --- length ---------------------------------------------------------------------------------------


def test_moments_are_those_of_the_samples_from_the_start_on():
    """Uneven chunks, one of them before the start, one cut by it; only the last block counts."""
    rng = np.random.default_rng(0)
    time = 0.5 * np.arange(20)
    displacement = rng.normal(3.0, 2.0, (20, 2, 3)) + np.array([0.0, 50.0, -7.0])
    # the first that counts, and one before
    displacement[5, 0, 0], displacement[4, 0, 1] = -90.0, 90.0
    moments, history = LengthMoments(3, start=2.5), LengthHistory(3, 2.5, 10.0)
    reach = Reach(3, 2.5)
    for part in (slice(0, 4), slice(4, 7), slice(7, 8), slice(8, 20)):
        for observer in (moments, history, reach):
            observer.observe(SimpleNamespace(time=time[part], displacement=displacement[part]))
    length = 250.0 + displacement[time >= 2.5, -1]
    measured, mean = moments.result(250.0), length.mean(axis=0)
    np.testing.assert_allclose(measured["mean_length"], mean, rtol=1e-14)
    np.testing.assert_allclose(measured["disorder_parameter"], length.std(axis=0) / mean)
    np.testing.assert_array_equal(measured["minimum_length"], length.min(axis=0))
    np.testing.assert_array_equal(measured["maximum_length"], length.max(axis=0))
    first = displacement[time >= 2.5, 0]
    assert reach.low.tolist() == first.min(axis=0).tolist()
    assert reach.high.tolist() == first.max(axis=0).tolist()
    edges = history.edges
    assert (edges[0], edges[-1]) == (2.5, 10.0) and history.count.tolist()[:2] == [2, 3]
    np.testing.assert_allclose(np.diff(edges)[1:-1] / np.diff(edges)[:-2], 1.15)
    for bin_number, (low, high) in enumerate(pairwise(edges)):
        binned = displacement[(low <= time) & (time < high), -1]
        assert history.count[bin_number] == len(binned) > 0
        np.testing.assert_allclose(history.mean[bin_number], binned.mean(axis=0))
        np.testing.assert_allclose(history.squares[bin_number], (binned**2).mean(axis=0))
        np.testing.assert_array_equal(history.low[bin_number], binned.min(axis=0))
        np.testing.assert_array_equal(history.high[bin_number], binned.max(axis=0))


# --- slips ----------------------------------------------------------------------------------------


def chunk_of(end, *chains):
    """Chunk with the events (time, block from 0, slips) of each chain."""
    events = np.zeros((len(chains), 8, 6))
    for lane, one in enumerate(chains):
        for row, (time, block, slips) in enumerate(one):
            events[lane, row, :3] = time, block, slips
    return SimpleNamespace(end=end, events=events, event_count=np.array([len(c) for c in chains]))


REST = ChainState.at_rest(ChainParameters(2, 5.0))


def activity(*chunks, start=10.0, laminar_time=4.0):
    activity_of_run = SlipActivity([REST] * len(chunks[0].event_count), start, laminar_time)
    for chunk in chunks:
        activity_of_run.observe(chunk)
    return activity_of_run


@pytest.mark.parametrize(
    ("events", "phases"),
    [
        ([], []),
        ([(5, 1, 1), (9, 1, 0)], []),  # over before the start
        ([(1, 1, 1), (10, 1, 0)], []),  # over at the start
        ([(5, 1, 1), (14.5, 1, 0)], [4.5]),  # counts from the start
        ([(11, 1, 1), (15, 1, 0)], []),  # not longer than the laminar time
        ([(11, 0, 1), (16, 0, 0)], []),  # another block
        ([(11, 1, 1), (16, 1, 0), (24, 1, 1)], [5.0, 6.0]),  # the last one goes on
        ([(11, 1, 1), (16, 1, 0), (27, 1, 1)], [5.0]),
        ([(3, 1, 1)], [20.0]),
    ],
)
def test_laminar_phases_are_long_slips_of_the_last_block(events, phases):
    result = activity(chunk_of(30.0, events)).laminar()
    assert result["laminar_count"].tolist() == [len(phases)]
    assert result["laminar_fraction"].tolist() == [sum(phases) / 20]
    mean = np.mean(phases) if phases else np.nan
    np.testing.assert_equal(result["laminar_mean"], [mean])
    assert result["laminar_longest"].tolist() == [max(phases, default=0)]


# --- avalanches -----------------------------------------------------------------------------------

CHAIN = ChainParameters(3, 2.0)


def stuck(positions):
    """State of the chain at t = 0 with all blocks stuck at these positions."""
    return ChainState.at_rest(CHAIN, positions)


def random_events(seed, count=400, reversals=0.3):
    """Alternating slips and sticks of three blocks with a share of reversals, as a run has them.

    Stuck blocks move with the belt; slips go anywhere near and dissipate anything.
    """
    rng = np.random.default_rng(seed)
    initial = CHAIN.rest_positions + rng.normal(0, 1, 3)
    place, since, loss = initial.copy(), np.zeros(3), np.zeros(3)
    slipping, time, rows = np.zeros(3, bool), 0.0, []
    while len(rows) < count:
        time += rng.exponential(1.0)
        # mostly one block at a time, so that all stick between avalanches
        candidates = np.flatnonzero(slipping) if rng.random() < 0.6 else np.arange(3)
        block = rng.choice(candidates if candidates.size else np.arange(3))
        if slipping[block]:
            place[block] = CHAIN.rest_positions[block] + rng.normal(0, 10)
            loss[block] += rng.exponential(5.0)
            reverses = rng.random() < reversals
        else:
            place[block] += CHAIN.belt_velocity * (time - since[block])
            reverses = False
        since[block] = time
        slipping[block] = not slipping[block]
        rows.append((time, block, float(slipping[block]), 0.0, place[block], loss[block]))
        if reverses:
            other = block if rng.random() < 0.8 else rng.choice(3)
            if not slipping[other]:
                place[other] += CHAIN.belt_velocity * (time - since[other])
                since[other], slipping[other] = time, True
                rows.append((time, other, 1.0, 0.0, place[other], loss[other]))
    return np.array(rows), initial


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("start", [0.0, 60.0])
def test_slips_and_avalanches_with_reversals_are_those_of_the_plain_twin(seed, start):
    events, initial = random_events(seed)
    catalogued = slips_and_avalanches(events, 7, stuck(initial), law_constants(CHAIN), start)

    def energy(positions):
        return float(potential_energy(positions, CHAIN))

    expected = naive.slips_and_avalanches(events, initial, CHAIN.belt_velocity, energy, start)
    assert (np.diff(events[:, 0]) == 0).sum() > 20
    for records, rows in zip(catalogued, expected, strict=True):
        assert len(records) == len(rows) > 10
        assert np.all(records["point"] == 7)
        for name, column in zip(records.dtype.names[1:], zip(*rows, strict=True), strict=True):
            np.testing.assert_allclose(records[name], column, rtol=1e-9, atol=1e-9, err_msg=name)


def test_a_block_that_reverses_does_not_count_as_stuck():
    stuck_blocks = MostStuck(np.array([1, 1, 0]))
    reversal = [(1.0, 0, 0), (1.0, 0, 1)]
    for events in (reversal, [], [(2.0, 1, 1), (3.0, 2, 0)]):
        stuck_blocks.observe(chunk_of(0.0, events, [*events, (4.0, 1, 0)], events))
    assert stuck_blocks.most.tolist() == [1, 4, 0]


# --- any observer, however a run is cut -----------------------------------------------------------


def cut_run(events, crossings, ends):
    """Chunks of two chains, of which the first has half of the events, that end at these instants.

    Their buffers are used again.
    """
    start = 0.0
    for end in ends:
        rows, crossed = (
            table[(start < table[:, 0]) & (table[:, 0] <= end)] for table in (events, crossings)
        )
        tables = np.stack([rows, rows]), np.stack([np.full_like(crossed, np.nan), crossed])
        yield SimpleNamespace(
            end=end,
            events=tables[0],
            event_count=np.array([np.count_nonzero(rows[:, 0] < HALF), len(rows)]),
            crossings=tables[1],
            crossing_count=np.array([0, len(crossed)]),
        )
        for table in tables:
            table[...] = -1.0
        start = end


HALF = 70.0


@pytest.mark.parametrize("seed", range(3))
def test_observers_are_plain_twins_wherever_a_run_is_cut(seed):
    events, initial = random_events(seed, count=200)
    random = np.random.default_rng(seed)
    events[:, 3] = random.choice([-1.0, 1.0], len(events))  # forces: forward slips, and backward
    events[:, 4] -= CHAIN.rest_positions[events[:, 1].astype(int)]
    time, block, slips = events[:, 0], events[:, 1].astype(int), events[:, 2] > 0
    whole, late = time[-1] + 1.0, time >= 60.0
    crossings = random.uniform(0, whole, (30, 7))
    crossings = crossings[np.argsort(crossings[:, 0])]
    # blocks count in proportion to their friction: 1/2, 1 and 3/2 of the mean
    differ = dataclasses.replace(CHAIN, friction_ratio=(0.2, 0.4, 0.6))
    states = [stuck(initial), ChainState.at_rest(differ, initial)]

    # plain twins
    place, way = [None] * 3, 0.0
    for t, b, slipping, force, x, _ in events:
        if slipping and force > 0:
            place[int(b)] = x - 2.0 * t
        elif not slipping and place[int(b)] is not None:
            way += (1 + b) / 2 * (x - 2.0 * t - place[int(b)])
            place[int(b)] = None
    before = [np.count_nonzero(slips & (time < t)) for t in crossings[:, 0]]
    turns = time[block == 2]  # slip, stick, slip, ...
    going_on = turns[-1] if len(turns) % 2 else np.nan
    crossed = crossings[crossings[:, 0] >= 60.0]
    velocities = np.append(crossed[:, -1] + 20.0, [np.nan] * 30)

    for ends in ([whole], [0.3 * whole, 0.35 * whole, whole], np.linspace(1.0, whole, 50)):
        log, returns = EventLog(2, CHAIN.rest_positions), ReturnLog(2)
        forward, activity = ForwardSlip(states), SlipActivity(states, 60.0, 1.0)
        most = MostStuck(np.array([3, 3]))
        u, edges = np.array([10.0, 20.0]), np.array([-1e9, 0.0, 15.0])
        sections = [SectionVelocities(u, room, edges, 60.0) for room in (4, 30)]
        for chunk in cut_run(events, crossings, ends):
            for observer in (log, returns, forward, activity, most, *sections):
                observer.observe(chunk)
        np.testing.assert_array_equal(returns.slips(1), [time[slips], block[slips]])
        assert returns.slips(0)[0].tolist() == time[slips & (time < HALF)].tolist()
        assert most.events.tolist() == [np.count_nonzero(time < HALF), len(time)]
        np.testing.assert_array_equal(returns.returns(1)[1], crossings[:, 1:])
        np.testing.assert_array_equal(returns.returns(1)[2], before)
        np.testing.assert_array_equal(returns.last_event, [time[time < HALF][-1], time[-1]])
        assert forward._way[1] == pytest.approx(way, abs=1e-9)
        for counted, kind in ((activity.slip_count, slips), (activity.stick_count, ~slips)):
            np.testing.assert_array_equal(counted[1], np.bincount(block[kind & late], minlength=3))
        assert activity.last_stick_time[1] == turns[1::2][-1]
        np.testing.assert_array_equal(activity.slipping_since[1], going_on)
        for section, room in zip(sections, (4, 30), strict=True):
            assert section.count.tolist() == [0, len(crossed)] and len(crossed) > 4
            np.testing.assert_array_equal(section.values[1], velocities[:room].astype("f4"))
            counts, _ = np.histogram(velocities[: len(crossed)], edges)
            assert section.histogram.tolist() == [[0, 0], counts.tolist()]
        logged = log.events(1)
        np.testing.assert_array_equal(logged[:, 0], time)
        np.testing.assert_array_equal(logged[:, 4], events[:, 4] + 50.0 * (block + 1))

"""Claims on noise-induced intermittency: made-up runs with a known answer."""

import numpy as np
import pytest

from beltrepro.base.store import Dataset
from beltrepro.replication.studies.noise import measure
from beltrepro.replication.verdicts.criteria import IN_PART, NO, NOT_TESTABLE, OPEN, YES
from beltrepro.replication.verdicts.evidence import Cut
from made_up import LEDGER, both, grades, measured, replicates, table

CRITICAL = {0.0: 16.5, 0.5: 16.7, 1.0: 17.0, 2.2: 18.0, 5.0: 20.5}
STEP = 0.1  # between samples of a series
SCHEME = "n5_replicates_check"  # where replicated has its runs without noise from


def noisy_only(u, noise):
    """Intermittent about u = 17.5, with noise."""
    return float(noise > 0 and 16 <= u <= 19)


def runs(laminar=noisy_only, **options):
    made = replicates(CRITICAL, laminar=laminar, **options)
    return {"n5_replicates": made, SCHEME: made}


# --- Fig. 16, independent runs --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("laminar", "at_edge", "in_middle", "verdicts"),
    [
        (noisy_only, 8, 8, (YES, YES)),
        (lambda u, noise: 0.0, 0, 0, (OPEN, IN_PART)),  # none of eight may yet be one of twenty
        (noisy_only, 3, 8, (YES, YES)),  # no exception at the edge, and most in the middle
        (noisy_only, 8, 0, (YES, IN_PART)),
        (lambda u, noise: 0.6 if noise else 0.15, 8, 8, (OPEN, OPEN)),
    ],
)
def test_alternation_with_noise_and_without(laminar, at_edge, in_middle, verdicts):
    made = runs(laminar)
    arrays = made["n5_replicates"].arrays
    for u, alternating in ((17.5, at_edge), (19, in_middle)):
        here = np.flatnonzero((arrays["belt_velocity"] == u) & (arrays["noise"] == 2.2))
        arrays["laminar_count"][here] = np.where(np.arange(8) < alternating, 2, 1)
    assert both("intermittency", **made) == verdicts


@pytest.mark.parametrize(("last_stick", "share"), [(5e5, 0), (7e5, 1), (np.nan, 0)])
def test_an_escape_for_good_is_no_intermittency(last_stick, share):
    """Before the last half of 2e5 to 1e6, or without any stick."""
    made = runs(lambda u, noise: 1.0)
    arrays = made[SCHEME].arrays
    arrays["last_stick_time"][arrays["noise"] == 0] = last_stick
    estimate = measured("intermittency", **made).judged["intermittent without noise"]
    assert estimate.value == share


def test_only_velocities_near_the_transition_are_asked_without_noise():
    assert both("intermittency", **runs(lambda u, s: float(s > 0 or not 15 <= u <= 20)))[0] == YES


# --- spectra --------------------------------------------------------------------------------------


def series(lengths, *, chaotic="noise", laminar="lines", between=900.0):
    """Series of laminar phases of these lengths and of chaos between; what x_5 does in each."""
    rng = np.random.default_rng(8)
    edges, time = [], 0.0
    for length in lengths:
        edges.append((time + between, time + between + length))
        time = edges[-1][1]
    duration = time + between
    instants = STEP * np.arange(int(duration / STEP))
    base = 0.05 * np.arange(1, 9)[:, None] * instants  # of 0.05 / time unit, 0.65 Hz
    lines = np.cos(2 * np.pi * base).sum(axis=0)
    noise = rng.standard_normal(instants.size)
    forms = {"lines": lines + 0.05 * noise, "noise": 60 * noise}
    inside = np.zeros(instants.size, dtype=bool)
    for begin, end in edges:
        inside |= (instants >= begin) & (instants < end)
    position = 610 + np.where(inside, forms[laminar], forms[chaotic])
    rows = []
    for begin, end in edges:  # the last block sticks every 20 between the phases
        for start in np.arange(begin - between, begin - 10, 20.0):
            rows += [(start, 5, "slip"), (start + 15, 5, "stick")]
        rows += [(begin, 5, "slip"), (end, 5, "stick")]
    events = np.array(rows, dtype=[("time", "f8"), ("block", "i8"), ("kind", "U5")])
    positions = np.tile(position[:, None], 5)
    arrays = {"time": instants, "events": events, "positions": positions}
    arrays["velocities"] = np.zeros_like(positions)
    attributes = {"transient": 0.0, "duration": duration, "n_blocks": 5, "belt_velocity": 19.0}
    return Dataset(arrays, attributes)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("change", "expected", "verdict"),
    [
        ({}, (True, False), YES),
        ({"laminar": "noise"}, (False, False), NO),
        ({"chaotic": "lines"}, (True, True), YES),  # the chaotic ones are not asked
    ],
)
def test_spectra_of_laminar_and_chaotic_stretches(change, expected, verdict):
    made = {name: series([600.0] * 5, **change) for name in ("u17", "u19")}
    numbers = measured("laminar-spectra", **made).numbers
    shares = (numbers[f"peaks at equal distances, {kind}"] for kind in ("laminar", "chaotic"))
    assert tuple(share.low > 0.5 for share in shares) == expected
    assert both("laminar-spectra", **made) == (NOT_TESTABLE, verdict)


# --- Fig. 18 --------------------------------------------------------------------------------------

LEVELS = (0.0, 1, 2, 3, 4, 5, 6, 7, 8)


def region(widths, share=0.5):
    """Map at whole u in which points of u > 15 are intermittent over a width given by noise."""
    points = [(u, s) for s in LEVELS for u in np.arange(1.0, 51)]
    inside = np.array([15 < u <= 15 + widths[s] for u, s in points])
    return table(
        points,
        np.ones(len(points)),
        laminar_fraction=np.where(inside, share, 0.0),
        laminar_count=np.where(inside, 2, 0),
    )


def data_of_region(widths, *, laminar=noisy_only, share=0.5):
    made = region(dict(zip(LEVELS, widths, strict=True)), share)
    fast = replicates(CRITICAL, noises=[0.0], velocities=[38, 44, 50], laminar=laminar)
    runs = replicates(CRITICAL, laminar=laminar)
    return {"n5_map": made, "n5_replicates": runs, "n5_replicates_beyond": fast}


@pytest.mark.parametrize(
    ("widths", "expected"),
    [
        ([0, 2, 2, 2, 2, 19, 20, 21, 22], [YES, YES]),
        ([0, 3, 6, 9, 12, 15, 18, 21, 24], [YES, YES]),  # in proportion
        ([0, 19, 19, 19, 19, 9, 9, 9, 9], [YES, NO]),
    ],
)
def test_the_region_of_intermittency(widths, expected):
    verdict = grades("intermittency-region", **data_of_region(widths))
    assert [verdict[name] for name in LEDGER["intermittency-region"].robust.allowed] == expected


def test_all_intermittent_points_count_and_the_share_is_that_of_the_reading():
    widths = dict(zip(LEVELS, [0, 2, 2, 2, 2, 9, 10, 11, 12], strict=True))
    made = region(widths)
    apart = (made.arrays["belt_velocity"] == 40) & (made.arrays["noise"] == 1)
    made.arrays["laminar_fraction"][apart], made.arrays["laminar_count"][apart] = 0.5, 2
    mask = made.arrays["laminar_count"] >= 2
    row = measure._width(Cut(made.arrays, 0.0, 1.0), mask, 0.0, 4.0)
    assert row.value == 2.25  # mean of 3, 2, 2, 2 points, 1 apart
    assert row.runs == 200  # four levels of 50 velocities
    for share, inside in ((0.03, [0, 1, 0]), (0.07, [1, 1, 0]), (0.2, [1, 1, 1])):
        data = data_of_region(widths.values(), share=share)
        numbers = [
            measured("intermittency-region", reading, **data).also["width, sigma up to 2"].value
            for reading in LEDGER["intermittency-region"].parameters["laminar_share"]
        ]
        assert [number > 0 for number in numbers] == inside

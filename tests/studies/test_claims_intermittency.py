"""Claims on noise-induced intermittency: made-up runs with a known answer."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.noise.measure import share_of_time
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, UNDECIDED
from beltrepro.stats.estimates import mean
from made_up import LEDGER, grades, measured, replicates, table

CRITICAL = {0.0: 16.5, 0.5: 16.7, 1.0: 17.0, 2.2: 18.0, 5.0: 20.5}
STEP = 0.1  # between samples of a series


def noisy_only(u, noise):
    """Intermittent about u = 17.5, with noise."""
    return float(noise > 0 and 16 <= u <= 19)


def components(name, reading=None, /, **datasets):
    """Verdicts in the order of the criterion."""
    verdict = grades(name, reading, **datasets)
    return [verdict[each] for each in LEDGER[name].criterion["allowed"]]


# --- Fig. 16, independent runs --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("laminar", "expected"),
    [
        (noisy_only, [HOLDS, HOLDS, HOLDS]),
        (lambda u, noise: 0.0, [FAILS, FAILS, HOLDS]),
        (lambda u, noise: 1.0, [HOLDS, HOLDS, FAILS]),
        (lambda u, noise: 0.6 if noise else 0.1, [UNDECIDED, UNDECIDED, UNDECIDED]),
    ],
)
def test_alternation_with_noise_and_without(laminar, expected):
    made = replicates(CRITICAL, laminar=laminar)
    if UNDECIDED in expected:
        here = (made.arrays["belt_velocity"] == 17.5) & (made.arrays["noise"] == 2.2)
        made.arrays["laminar_count"][here] = [9, 9, 9, 9, 9, 0, 0, 1]
        made.arrays["laminar_fraction"][here] = [0.2, 0.1, 0, 0, 0, 0, 0, 0.1]
    assert components("intermittency", n5_replicates=made) == expected


def test_one_laminar_phase_is_no_alternation():
    made = replicates(CRITICAL, laminar=noisy_only)
    made.arrays["laminar_count"][:] = 1
    assert components("intermittency", n5_replicates=made) == [HOLDS, FAILS, HOLDS]


def test_an_escape_for_good_is_no_intermittency():
    made = replicates(CRITICAL, laminar=lambda u, noise: 1.0)
    quiet = made.arrays["noise"] == 0
    made.arrays["last_stick_time"][quiet] = 5e5  # before the last half of 2e5 to 1e6
    assert components("intermittency", n5_replicates=made) == [HOLDS, HOLDS, HOLDS]
    made.arrays["last_stick_time"][quiet] = 7e5
    assert components("intermittency", n5_replicates=made) == [HOLDS, HOLDS, FAILS]
    made.arrays["last_stick_time"][quiet] = np.nan  # never sticks
    assert components("intermittency", n5_replicates=made) == [HOLDS, HOLDS, HOLDS]


def test_the_note_says_where_runs_are_intermittent():
    made = replicates(CRITICAL, laminar=lambda u, noise: float(u == 19) if noise == 2.2 else 1.0)
    note = measured("intermittency", n5_replicates=made).note
    assert note == "most runs are intermittent at u = 19: 100% of them"
    without = replicates(CRITICAL)
    assert "no run at sigma = 2.2" in measured("intermittency", n5_replicates=without).note


def test_only_velocities_near_the_transition_are_asked_without_noise():
    made = replicates(CRITICAL, laminar=lambda u, s: float(s > 0 or not 15 <= u <= 20))
    assert components("intermittency", n5_replicates=made) == [HOLDS, HOLDS, HOLDS]
    few = replicates(CRITICAL, velocities=(15.0, 16, 20))
    with pytest.raises(NotEnoughDataError, match=r"no runs at u = 17\.5"):
        measured("intermittency", n5_replicates=few)


# --- Fig. 16, one long run ------------------------------------------------------------------------


def telegraph(rng, length, laminar=400.0, chaotic=800.0):
    """Begin and end of laminar phases of exponential lengths, cut at the ends of a run."""
    time, inside, phases = 0.0, rng.random() < laminar / (laminar + chaotic), []
    while time < length:
        duration = rng.exponential(laminar if inside else chaotic)
        if inside:
            phases.append((time, min(time + duration, length)))
        time, inside = time + duration, not inside
    return np.array(phases).reshape(-1, 2)


def test_the_share_of_a_telegraph_signal_from_one_run_and_from_several():
    rng = np.random.default_rng(1)
    true, trials = 1 / 3, 400
    for length in (15_000.0, 60_000.0):  # some 12 and 50 cycles
        made = [telegraph(rng, length) for _ in range(trials)]
        own = [share_of_time(phases) for phases in made if len(phases) > 5]
        assert 0.90 <= np.mean([each.low <= true <= each.high for each in own]) <= 0.98
    several = [
        mean([np.diff(telegraph(rng, 8000.0)).sum() / 8000 for _ in range(8)])
        for _ in range(trials)
    ]
    assert 0.92 <= np.mean([each.low <= true <= each.high for each in several]) <= 0.98


def test_the_share_of_known_cycles():
    begin = np.arange(12) * 1000.0
    phases = np.column_stack([begin, begin + 250])
    exact = share_of_time(phases)
    assert (exact.value, exact.low, exact.high) == pytest.approx((0.25, 0.25, 0.25))
    assert exact.runs == 11
    inside = np.array([100.0, 500, 200, 300, 900, 400])
    begin = np.cumsum(4 * inside) - 4 * inside  # three times as long between as inside
    varied = share_of_time(np.column_stack([begin, begin + inside]))
    assert (varied.value, varied.low, varied.high) == pytest.approx((0.25, 0.25, 0.25))
    with pytest.raises(NotEnoughDataError, match="4 whole cycles, 5 are needed"):
        share_of_time(phases[:5])


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
    arrays = {"time": instants, "events": events, "positions": np.tile(position[:, None], 5)}
    attributes = {"transient": 0.0, "duration": duration, "n_blocks": 5}
    return Dataset(arrays, attributes)


def test_readings_of_one_long_run():
    made = {"n5_replicates": replicates(CRITICAL, laminar=noisy_only)}
    made["u17"] = series([300.0, 900.0] * 6)
    whole = measured("intermittency", "one long run", **made)
    assert "12 laminar phases" in whole.note
    assert whole.judged["laminar share"].value == pytest.approx(600 / 1500, abs=0.03)
    longer = measured("intermittency", "one long run, phases longer than 784", **made)
    assert "6 laminar phases" in longer.note
    assert longer.judged["laminar share"].value == pytest.approx(900 / 3000, abs=0.01)
    quiet = measured("intermittency", "one long run, small amplitudes", **made)
    assert quiet.judged["laminar share"].value == pytest.approx(600 / 1500, abs=0.06)
    for reading in ("one long run", "one long run, small amplitudes"):
        assert components("intermittency", reading, **made) == [HOLDS, HOLDS, HOLDS]
    made["n5_replicates"] = replicates(CRITICAL, laminar=lambda u, noise: 1.0)
    assert components("intermittency", "one long run", **made)[2] == FAILS
    made["n5_replicates"].arrays["laminar_longest"][:] = 783.0
    reading = "one long run, phases longer than 784"
    assert components("intermittency", reading, **made)[2] == HOLDS


# --- spectra --------------------------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({}, [HOLDS, HOLDS, HOLDS]),
        ({"laminar": "noise"}, [FAILS, HOLDS, UNDECIDED]),
        ({"chaotic": "lines"}, [HOLDS, FAILS, UNDECIDED]),
        ({"laminar": "noise", "chaotic": "lines"}, [FAILS, FAILS, FAILS]),
    ],
)
def test_spectra_of_laminar_and_chaotic_stretches(change, expected):
    made = series([600.0] * 9, **change)
    assert components("laminar-spectra", "u = 17.5 alone", u17=made) == expected
    assert components("laminar-spectra", "u = 19.1, as filmed", belt_035=made) == expected


def test_spectra_are_of_stretches_that_are_long_enough():
    made = series([600.0, 500.0] * 4)  # 40 s are 523
    peaks, few = "peaks at equal distances, laminar", series([600.0] + [500.0] * 4)
    assert measured("laminar-spectra", "u = 17.5 alone", u17=made).judged[peaks].runs == 4
    assert measured("laminar-spectra", u17=few, u19=made).judged[peaks].runs == 5
    with pytest.raises(NotEnoughDataError, match="1 phases of 40 s or more, 2 are needed"):
        measured("laminar-spectra", "u = 17.5 alone", u17=few)


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


def width_components(widths, *, laminar=noisy_only, reading=None, share=0.5):
    made = replicates(CRITICAL, laminar=laminar)
    given = dict(zip(LEVELS, widths, strict=True))
    return components(
        "intermittency-region", reading, n5_map=region(given, share), n5_replicates=made
    )


@pytest.mark.parametrize(
    ("widths", "expected"),
    [
        ([0, 2, 2, 2, 2, 9, 10, 11, 12], [HOLDS, HOLDS, HOLDS, HOLDS]),
        ([0, 3, 6, 9, 12, 15, 18, 21, 24], [HOLDS, HOLDS, HOLDS, UNDECIDED]),  # in proportion
        ([0, 9, 9, 9, 9, 9, 9, 9, 9], [HOLDS, HOLDS, FAILS, UNDECIDED]),
        ([0, 2, 2, 12, 12, 12, 12, 12, 12], [HOLDS, HOLDS, UNDECIDED, FAILS]),
        ([0, 0, 0, 0, 0, 9, 9, 9, 9], [HOLDS, FAILS, UNDECIDED, HOLDS]),
        ([0, 0, 2, 0, 2, 3, 1, 3, 1], [HOLDS, UNDECIDED, UNDECIDED, UNDECIDED]),
    ],
)
def test_the_region_of_intermittency(widths, expected):
    assert width_components(widths) == expected


def test_the_region_without_noise():
    widths = [0, 2, 2, 2, 2, 9, 10, 11, 12]
    assert width_components(widths, laminar=lambda u, noise: 1.0)[0] == FAILS
    assert width_components(widths, laminar=lambda u, noise: 0.05)[0] == UNDECIDED


def test_all_intermittent_points_count_and_the_share_is_that_of_the_reading():
    widths = dict(zip(LEVELS, [0, 2, 2, 2, 2, 9, 10, 11, 12], strict=True))
    made = region(widths)
    apart = (made.arrays["belt_velocity"] == 40) & (made.arrays["noise"] == 1)
    made.arrays["laminar_fraction"][apart], made.arrays["laminar_count"][apart] = 0.5, 2
    both = {"n5_map": made, "n5_replicates": replicates(CRITICAL)}
    width = measured("intermittency-region", **both).judged["width, sigma up to 4"]
    assert width.value == 2.25  # mean of 3, 2, 2, 2 points, 1 apart
    assert width.runs == 200  # four levels of 50 velocities
    for share, holding in (
        (0.03, [0, 1, 0]),
        (0.07, [1, 1, 0]),
        (0.2, [1, 1, 1]),
        (0.97, [0, 1, 0]),
    ):
        names = ("5 % to 95 %", "1 % to 99 %", "10 % to 90 %")
        seen = [
            width_components(widths.values(), reading=f"laminar share {name}", share=share)[1]
            for name in names
        ]
        assert [each == HOLDS for each in seen] == holding

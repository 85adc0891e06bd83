"""Each claim function on a few made-up numbers: values, errors, counts, both sides of checks."""

import math

import numpy as np
import pytest
from scipy import stats

from alternating import experiments
from beltrepro.analysis.errors import NotEnoughDataError
from beltrepro.model import units
from made_up import REGISTRY, Stub, cut, data, measured, passed, transition


def events(rows):
    """Events (time, block, kind) and, where given, position and force."""
    table = np.zeros(len(rows), [("time", "f8"), ("block", "i8"), ("kind", "U5"),
                                 ("position", "f8"), ("force", "f8")])  # fmt: skip
    for index, row in enumerate(rows):
        for name, value in zip(table.dtype.names, row, strict=False):
            table[name][index] = value
    return table


# --- with noise -----------------------------------------------------------------------------------

WINDOW = np.arange(2.0, 17)  # 3 to 15 are looked at


def filling(*shares, size=200):
    """Section velocities (P, size) that fill so many of 100 bins of -100 to 0 evenly."""
    return np.array([-100 + np.arange(size) % share + 0.5 for share in shares])


def window_rows(noise, filled, **other):
    """Rows at sigma = 1, in which the usual point fills 80 bins, and at another noise."""
    usual = filling(*[80] * WINDOW.size)
    usual[:, 0], usual[:, 1] = -100.0, 0.0
    rows = {(5, 1.0): cut(WINDOW, velocities=usual)}
    velocities = filling(99, *filled, 1)  # 2 and 16 are outside
    velocities[:, 0], velocities[:, 1] = -100.0, 0.0
    return rows | {(5, noise): cut(WINDOW, velocities=velocities, **other)}


def test_windows_against_noise():
    scan = data({"noise": np.array([0.0, 0.5, 1.0, 2.0, 0.5])})
    counts = {0.0: 7, 0.5: 3, 2.0: 0}
    rows = {}
    for noise, count in counts.items():
        rows |= window_rows(noise, [20] * count + [80] * (13 - count))
    found = measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})
    assert found.value == {
        "windows at 0": 7 / 13, "windows at 0.5": 3 / 13, "windows at 1": 0, "windows at 2": 0
    }  # fmt: skip
    assert passed(found) == [1, 1, 1] and found.sample_size == 13 * 4
    rows |= window_rows(2.0, [20] + [80] * 12)
    found = measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})
    assert passed(found) == [1, 0, 1]
    rows |= window_rows(0.0, [80] * 13) | window_rows(0.5, [20] + [80] * 12)
    found = measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})
    assert passed(found) == [0, 0, 0]
    few = data({"noise": np.array([0.0, 0.5, 1.0])})
    with pytest.raises(NotEnoughDataError, match="3 noise levels, 4 are needed"):
        measured("windows-vanish", rows=rows, datasets={"n5_rows": few})


@pytest.mark.parametrize(("bins", "share"), [(38, 1.0), (45, 0.0)])
def test_a_window_fills_less_than_half_of_the_usual_bins(bins, share):
    """Nine tenths of 80 bins are usual, and so 36 of 38 or 41 of 45 are less than half or more."""
    scan = data({"noise": np.array([0.0, 3.0, 1.0, 2.0])})
    rows = {}
    for noise in (0.0, 2.0, 3.0):
        rows |= window_rows(noise, [bins] * 13)
    found = measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})
    assert found.value["windows at 0"] == share


def test_windows_need_points_with_crossings():
    rows = window_rows(0.0, [80] * 13)
    rows[5, 0.0].points["section_velocity"][6:, 5:] = np.nan  # 5 of them are left
    scan = data({"noise": np.arange(4.0)})
    with pytest.raises(NotEnoughDataError, match="5 points with enough crossings, 6 are needed"):
        measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})
    rows[5, 1.0].points["section_velocity"][:] = np.nan
    with pytest.raises(NotEnoughDataError):
        measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})


@pytest.mark.parametrize(
    ("shift", "filled", "scatter", "checks"),
    [
        (1.99, 80, 0.01, [1, 1, 1]),
        (-1.99, 80, 0.01, [1, 1, 1]),
        (2.0, 80, 0.01, [0, 1, 1]),
        (0.0, 20, 0.01, [1, 0, 1]),
        (0.0, 80, 0.05, [1, 1, 0]),
    ],
)
def test_the_transition_at_sigma_1(shift, filled, scatter, checks):
    zigzag = np.where(np.arange(WINDOW.size) % 2, 1.0, -1.0)
    outside = np.where((WINDOW < 3) | (WINDOW > 15), 9.0, 0.0)
    rows = window_rows(1.0, [80] * 12 + [filled], disorder=0.1 + scatter * zigzag + outside)
    fall = transition(15, 18, 16.0, error=0.5, n=30)
    rows[5, 0.0] = cut(WINDOW, disorder=0.1 + 0.05 * zigzag - outside, fall=fall)
    noisy = transition(16, 19, 16.0 + shift, error=0.7, n=12)
    rows[5, 1.0].__dict__["transition"] = noisy
    found = measured("sigma1-transition", rows=rows)
    assert passed(found) == checks
    assert found.value["u_c at 0"] == 16 and found.value["u_c at 1"] == 16 + shift
    assert found.uncertainty == {"u_c at 0": 0.5, "u_c at 1": 0.7} and found.sample_size == 42
    # a zigzag of amplitude a about 0.1 has second differences of 4 a; 3 of 13 points are low
    for name, size in (("roughness at 0", 0.05), ("roughness at 1", scatter)):
        values = 0.1 + size * zigzag[1:-1]
        assert found.value[name] == pytest.approx(4 * size / np.median(values))
    assert found.value["windows at 1"] == (1 / 13 if filled < 40 else 0)


@pytest.mark.parametrize(
    ("critical", "error", "checks"),
    [
        ([16, 17, 18, 21], 1.0, [1, 1]),
        ([16, 17, 18, 18.82], 1.0, [1, 0]),
        ([16, 17, 18, 18.84], 1.0, [1, 1]),
        ([20, 16, 24, 21], 1.0, [0, 1]),  # rank correlation 0.4
        ([16, 18, 24, 21], 1.0, [1, 1]),
    ],
)
def test_critical_velocities_against_noise(critical, error, checks):
    levels = [0.0, 1.0, 2.0, 5.0]
    falls = [transition(u - 1, u + 1, error=error, n=7) for u in critical]
    rows = {("n5_rows", s): cut(fall=fall) for s, fall in zip(levels, falls, strict=True)}
    rows["n5_rows", 9.0] = cut(fall=transition(1, 99, found=False, n=7))
    stub = {"rows": rows, "datasets": {"n5_rows": data({"noise": np.array([*levels, 9.0, 0.0])})}}
    found = measured("uc-of-sigma", "fine rows", **stub)
    assert [found.value[f"u_c at {s:g}"] for s in levels] == critical
    assert found.uncertainty["u_c at 2"] == error and found.sample_size == 35
    assert passed(found) == checks
    del rows["n5_rows", 5.0], rows["n5_rows", 2.0]
    few = data({"noise": np.array([0.0, 1.0, 9.0])})
    with pytest.raises(NotEnoughDataError, match="r falls at 2 of 3 noise levels, 3 are needed"):
        measured("uc-of-sigma", "fine rows", rows=rows, datasets={"n5_rows": few})
    with pytest.raises(NotEnoughDataError, match="2 noise levels in scans/n5_map"):
        two = {"n5_map": data({"noise": np.array([0.0, 1.0])})}
        measured("uc-of-sigma", "map", rows=rows, datasets=two)


def noisy_motion(exponents, *, runs=8, n_blocks=5, u=7.0):
    """Runs with exponents of one standard error of 1e-4 about the given means by noise."""
    scatter = np.tile([-1.0, 1.0], runs)[:runs]
    scatter *= 1e-4 / stats.sem(scatter)
    noise = np.repeat(list(exponents), runs)
    arrays = {
        "n_blocks": np.full(noise.size, n_blocks),
        "belt_velocity": np.full(noise.size, u),
        "noise": noise,
        "largest_exponent": np.repeat(list(exponents.values()), runs)
        + np.tile(scatter, len(exponents)),
    }
    return arrays


@pytest.mark.parametrize(
    ("exponents", "met"),
    [
        ({0.5: 0.0, 0.8: 3.1e-4, 1: 3.1e-4, 2.2: 2.9e-4, 2.3: 0.0}, 1),
        ({0.5: 9e-4, 0.8: 3.1e-4, 1: 2.9e-4, 1.5: 9e-4, 2.2: -9e-4, 2.3: 9e-4}, 0),  # half
        ({0.79: 9e-4, 0.8: 0.0, 2.2: 0.0, 2.21: 9e-4}, 0),
    ],
)
def test_the_rise_at_u7(exponents, met):
    rise = transition(0.6, 1.1, 0.8, error=0.1, high=0.12, low=0.06, n=21)
    other = [noisy_motion({1.0: -1.0}, u=16.0), noisy_motion({1.0: 1.0}, n_blocks=6)]
    parts = [noisy_motion(exponents), *other]
    made = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    given = {"columns": {(5, 7.0): cut(rise=rise)}, "datasets": {"noisy_motion": data(made)}}
    found = measured("sigma-c-u7", **given)
    assert (found.value, found.uncertainty, found.sample_size) == (0.8, 0.1, 21)
    assert "from 0.06 to 0.12" in found.note and "between 0.6 and 1.1" in found.note
    assert passed(found) == [met]
    assert f"{exponents[2.2]:.2g} +- 0.0001 at 2.2" in found.note and "at 0.5" not in found.note


def test_the_rise_at_u7_needs_exponents_beyond_it():
    def at(noise, rise, runs=8):
        made = noisy_motion(dict.fromkeys(noise, 1.0), runs=runs)
        columns = {(5, 7.0): cut(rise=rise)}
        return measured("sigma-c-u7", columns=columns, datasets={"noisy_motion": data(made)})

    rise = transition(0.6, 1.1, 0.8)
    with pytest.raises(NotEnoughDataError, match=r"no exponent between sigma = 0.8 and 2.2"):
        at([0.5, 5.0], rise)
    with pytest.raises(NotEnoughDataError, match="7 runs at a noise level, 8 are needed"):
        at([1.0], rise, runs=7)
    flat = at([1.0], transition(math.nan, math.nan, math.nan, found=False))
    assert math.isnan(flat.value) and passed(flat) == [0]


@pytest.mark.parametrize(
    ("critical", "widths", "lost", "checks"),
    [
        ([2, 3, 4, 5], [1, 2, 3, 4], (), [1, 1, 1]),
        ([2, 3, 4, 5], [3, 2, 3, 4], (), [1, 1, 0]),
        ([3, 4, 2, 5], [1, 2, 3, 4], (), [1, 0, 1]),  # rank correlation 0.4
        ([2, 3, 4, 5], [1, 2, 3, 4], (3,), [0, 1, 1]),
    ],
)
def test_rises_against_u(critical, widths, lost, checks):
    u = [20.0, 22, 25, 30]
    columns = {(5, 19.0): None}
    for k, place in enumerate(u):
        half = widths[k] / 2
        rise = transition(critical[k] - half, critical[k] + half, n=8, found=k not in lost)
        columns[5, place] = cut(rise=rise)
    scan = data({"belt_velocity": np.array([*u, 19.0, 20.0])})
    found = measured("r-of-sigma", columns=columns, datasets={"n5_columns": scan})
    assert found.value == {f"sigma_c at u = {u[k]:g}": critical[k] for k in range(4)}
    assert found.uncertainty["sigma_c at u = 22"] == 0.5 and found.sample_size == 32
    assert passed(found) == checks
    few = data({"belt_velocity": np.array(u[:3])})
    with pytest.raises(NotEnoughDataError, match="3 columns with u >= 20, 4 are needed"):
        measured("r-of-sigma", columns=columns, datasets={"n5_columns": few})
    for place in u[:2]:
        columns[5, place] = cut(rise=transition(1, 2, found=False))
    with pytest.raises(NotEnoughDataError, match="too few to compare"):
        measured("r-of-sigma", columns=columns, datasets={"n5_columns": scan})


@pytest.mark.parametrize(
    ("phases", "share", "counts", "checks"),
    [
        ([[0, 300], [500, 950]], [0.0] * 6, (2, 0), [1, 1, 1]),
        ([[0, 500]], [0.0] * 6, (1, 0), [0, 1, 1]),
        ([[0, 20], [500, 529]], [0.0] * 6, (2, 0), [1, 0, 1]),
        ([[0, 450], [460, 970]], [0.0] * 6, (2, 0), [1, 0, 1]),
        ([[0, 300], [500, 950]], [0.5, 0, 0.5, 0, 0, 0.5], (2, 1), [1, 1, 0]),
    ],
)
def test_intermittency_of_the_series_and_none_without_noise(phases, share, counts, checks):
    u = [14.9, 15, 17, 18, 20, 20.1]
    row = cut(u, laminar_fraction=share, laminar_count=np.full(6, 9))
    given = {"phases": {"u17": (np.array(phases, dtype=float), 1000.0)}, "rows": {(5, 0.0): row}}
    found = measured("intermittency", **given)
    assert found.value == {
        "laminar share": sum(b - a for a, b in phases) / 1000,
        "laminar phases": counts[0],
        "intermittent points at sigma = 0": counts[1],
    }
    assert passed(found) == checks and found.sample_size == counts[0]
    assert "4 points without noise" in found.note
    given["rows"] = {(5, 0.0): cut(u[:4], laminar_fraction=share[:4], laminar_count=[9] * 4)}
    with pytest.raises(NotEnoughDataError, match="3 points in 15 <= u <= 20"):
        measured("intermittency", **given)


def test_the_critical_velocity_in_metres_per_second():
    row = cut(fall=transition(17, 21, 19.5, error=0.4, n=50))
    found = measured("uc-sigma22", rows={(5, 2.2): row})
    metre = 1.4e-3 / math.sqrt(0.1158 / 19.8)
    assert found.value == {"u_c": 19.5, "u_c_m_s": pytest.approx(19.5 * metre)}
    assert found.uncertainty == {"u_c": 0.4, "u_c_m_s": pytest.approx(0.4 * metre)}
    assert found.sample_size == 50 and "17 to 21" in found.note


@pytest.mark.parametrize(("r", "met"), [(0.13, 1), (0.53, 0), (0.51, 1), (0.0051, 0), (0.0053, 1)])
def test_r_at_the_speeds_of_the_experiment(r, met):
    """Medians within 1 of the speeds; the experiment found 0.052 at the second."""
    speeds = [units.from_si(speed, "velocity") for speed in (0.22, 0.28)]
    u = [speeds[0] - 1.01, speeds[0] - 0.99, speeds[0], speeds[0] + 0.99, speeds[1]]
    row = cut(u, disorder=[9.0, 0.1, 0.13, 0.11, r])
    rows = {(5, s): row for s in (0.0, 1.0, 2.0)}
    given = {"rows": rows, "datasets": {"n5_rows": data({"noise": np.array([0.0, 1, 2])})}}
    found = measured("r-experiment", "sigma = 2", **given)
    assert list(REGISTRY["r-experiment"](Stub("r-experiment", **given))) == [
        "sigma = 1", "sigma = 0", "sigma = 2", "films, sigma = 1"
    ]  # fmt: skip
    assert found.value == {"r_022": 0.11, "r_028": r}
    assert found.uncertainty["r_022"] == pytest.approx(np.std([0.1, 0.13, 0.11]) / math.sqrt(3))
    assert found.sample_size == 4
    assert passed(found) == [met]


def test_the_natural_distribution():
    u = np.concatenate([WINDOW, np.arange(25.0, 40)])
    low, high = WINDOW.size, 15

    def row(bins_low, bins_high, fall=None):
        velocities = filling(*[bins_low] * low, *[bins_high] * high)
        velocities[low] = -99.5  # u = 25 itself is not looked at
        velocities[0, :2] = -100, 0
        return cut(u, velocities=velocities, fall=fall)

    def checks(**change):
        rows = {
            (5, 0.0): row(80, 10),
            (5, 1.0): row(80, 80, transition(15, 18)),
            (5, 5.0): row(80, 80, transition(15, 20)),
            (5, 10.0): row(80, 80),
        } | {(5, float(name[1:])): value for name, value in change.items()}
        return measured("natural-distribution", rows=rows)

    found = checks()
    assert passed(found) == [1, 1, 1, 1] and found.sample_size == 4 * u.size
    assert found.value["width at 1"] == 3 and found.value["width at 5"] == 5
    assert found.value["spread ratio at 10"] == 1
    assert found.value["spread ratio at 0"] == pytest.approx(9 / 72, abs=0.02)
    assert passed(checks(s5=row(80, 80, transition(15, 18)))) == [1, 1, 0, 1]
    assert passed(checks(s5=row(80, 80, transition(1, 2, found=False)))) == [1, 1, 1, 1]
    assert passed(checks(s1=row(80, 80, transition(15, 18, found=False)))) == [1, 0, 0, 1]
    assert passed(checks(s10=row(80, 30))) == [1, 1, 1, 0]
    assert passed(checks(s0=row(80, 45))) == [1, 1, 1, 0]
    assert passed(checks(s0=row(80, 36), s10=row(80, 44))) == [1, 1, 1, 1]


def map_table(**change):
    """Twelve u at three noise levels: chaotic up to 15, quiet from 25 on, some intermittent."""
    u = np.tile([2.0, 5, 8, 11, 15, 18, 20, 22, 25, 30, 40, 50], 3)
    noise = np.repeat([0.0, 1.0, 3.0], 12)
    disorder = np.where(u <= 20, 0.13, 0.02)
    points = {
        "n_blocks": np.full(36, 5),
        "noise": noise,
        "disorder": disorder,
        "laminar_fraction": np.where((u == 22) & (noise > 0), 0.5, 0.0),
        "laminar_count": np.full(36, 9),
    }
    return cut(u, **points | change), u, noise, disorder


@pytest.mark.parametrize(
    ("factor", "checks"), [(1.10, [1, 1, 1, 1]), (0.91, [1, 1, 1, 1]), (1.11, [0, 1, 1, 1])]
)
def test_the_map_agrees_with_the_rows(factor, checks):
    table, u, _, disorder = map_table()
    near = np.arange(36) % 3 < 2
    rows = cut(
        u[near] + 1e-9, noise=table.noise[near], n_blocks=np.full(24, 5),
        disorder=disorder[near] * factor,
    )  # fmt: skip
    found = measured("r-map", tables={"n5_map": table, "n5_rows": rows})
    assert passed(found) == checks and found.sample_size == 36
    assert found.value == {
        "median difference from rows": pytest.approx(abs(math.log(factor))),
        "r > 0.1 at u <= 15, least share": 1.0,
        "r < 0.05 at u >= 25, sigma <= 2": 1.0,
        "intermittent share": pytest.approx(2 / 36),
    }


@pytest.mark.parametrize(
    ("low", "high", "checks"),
    [(2, 3, [1, 1, 1]), (3, 3, [1, 0, 1]), (2, 4, [1, 1, 0])],
)
def test_the_plateaus_of_the_map(low, high, checks):
    """Of 5 points at u <= 15 of each noise so many are quiet; of 8 at u >= 25 so many are not."""
    table, u, noise, disorder = map_table(laminar_fraction=np.zeros(36))
    disorder[(noise == 1)][:] = 0.1
    quiet = np.flatnonzero((u <= 15) & (noise == 1))[:low]
    disorder[quiet] = 0.1
    loud = np.flatnonzero((u >= 25) & (noise <= 2))[:high]
    disorder[loud] = 0.05
    disorder[(u >= 25) & (noise > 2)] = 1.0
    table.points["disorder_parameter"] = disorder
    found = measured("r-map", tables={"n5_map": table, "n5_rows": table})
    assert passed(found) == [*checks, 0]
    assert found.value["r > 0.1 at u <= 15, least share"] == (5 - low) / 5
    assert found.value["r < 0.05 at u >= 25, sigma <= 2"] == (8 - high) / 8
    few = cut(u[:9], noise=noise[:9], n_blocks=np.full(9, 5), disorder=disorder[:9])
    with pytest.raises(NotEnoughDataError, match="9 points shared with the rows"):
        measured("r-map", tables={"n5_map": table, "n5_rows": few})


def region(widths):
    """Map with u = 1 to 40 in which so many points from u = 10 on are intermittent."""
    u = np.tile(np.arange(1.0, 41), len(widths))
    noise = np.repeat(list(widths), 40).astype(float)
    wide = np.repeat(list(widths.values()), 40)
    return cut(
        u, noise=noise, laminar_fraction=np.where((u >= 10) & (u < 10 + wide), 0.5, 0.0),
        laminar_count=np.full(u.size, 2),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("change", "checks"),
    [
        ({}, [1, 1, 1]),
        ({0: 1}, [0, 1, 1]),
        ({4: 4, 8: 7}, [1, 1, 0]),  # means 3 and 5.67
        ({4: 3, 8: 6}, [1, 1, 1]),  # means 2.67 and 5.33
        ({1: 0, 2: 0, 4: 0}, [1, 0, 0]),
        ({1: 3, 4: 9, 9: 99}, [1, 1, 0]),
    ],
)
def test_the_region_of_intermittency_widens(change, checks):
    widths = {0: 0, 1: 2, 2: 3, 4: 1, 5: 5, 6: 5, 8: 5, 9: 0} | change
    found = measured(
        "intermittency-region", "laminar share 5 % to 95 %", tables={"n5_map": region(widths)}
    )
    weak, strong = ([widths[s] for s in levels] for levels in ((1, 2, 4), (5, 6, 8)))
    assert found.value == {
        "width at 0": widths[0],
        "mean width, 0 to 4": pytest.approx(np.mean(weak)),
        "mean width, 4 to 8": pytest.approx(np.mean(strong)),
    }
    assert passed(found) == checks and found.sample_size == 320
    del widths[1]
    with pytest.raises(NotEnoughDataError, match="three noise levels on each side of 4"):
        measured(
            "intermittency-region", "laminar share 5 % to 95 %", tables={"n5_map": region(widths)}
        )


def test_the_share_of_a_reading_is_that_of_its_name():
    table = region({0: 0, 1: 2, 2: 3, 4: 1, 5: 5, 6: 5, 8: 5})
    for share, reading in (
        (0.03, "laminar share 1 % to 99 %"),
        (0.97, "laminar share 1 % to 99 %"),
        (0.07, "laminar share 5 % to 95 %"),
        (0.93, "laminar share 5 % to 95 %"),
        (0.12, "laminar share 10 % to 90 %"),
    ):
        inside = table.points["laminar_fraction"] > 0
        table.points["laminar_fraction"][inside] = share
        order = ["laminar share 10 % to 90 %", "laminar share 5 % to 95 %"]
        order.append("laminar share 1 % to 99 %")
        seen = [
            measured("intermittency-region", name, tables={"n5_map": table}).value[
                "mean width, 4 to 8"
            ]
            > 0
            for name in order
        ]
        assert seen == [k >= order.index(reading) for k in range(3)]


@pytest.mark.parametrize(
    ("best", "interval", "posterior", "met"),
    [
        ([1.0, 1.4], (1, 1.4), 1.0, [1, 1, 1, 1]),
        ([1.0, 4.0], (1, 4), 0.5, [1, 1, 1, 0]),
        ([0.7, 4.0, 1.4], (0.7, 4), 1 / 3, [1, 1, 0, 0]),
        ([0.5], (0.5, 0.5), 0.0, [0, 0, 0, 0]),
    ],
)
def test_the_noise_of_the_experiment(best, interval, posterior, met, monkeypatch):
    monkeypatch.setattr("beltrepro.analysis.trials.BANDWIDTH", {})
    reading = "r within 10%"
    found = measured("sigma-experiment", reading, datasets=experiments(best, runs=30))
    assert found.value["sigma, 90 %"] == interval and passed(found) == met
    assert found.value["posterior of 1 to 2"] == pytest.approx(posterior)
    share = len({1.0, 1.4, 2.0} & set(best)) / 3
    assert f"{share:.2g} of the trials agree at 0.22 m/s" in found.note
    assert "before the trials 1 to 2 had 0.43" in found.note
    for other in ("r within 5%", "r within 20%"):
        assert passed(measured("sigma-experiment", other, datasets=experiments(best, runs=30)))


def test_the_noise_of_the_experiment_needs_trials_and_agreement(monkeypatch):
    monkeypatch.setattr("beltrepro.analysis.trials.BANDWIDTH", {})
    with pytest.raises(NotEnoughDataError, match="78 trials, 80 are needed"):
        measured("sigma-experiment", "r within 10%", datasets=experiments([1.0], runs=26))
    few = experiments([1.0], runs=30) | {"trials_free": experiments([1.0], runs=19)["trials_free"]}
    with pytest.raises(NotEnoughDataError, match="19 trials agree with a recording, 20 are needed"):
        measured("sigma-experiment", "r within 10%", datasets=few)
    with pytest.raises(NotEnoughDataError, match="0 and 0 of 210 trials agree"):
        measured("sigma-experiment", "r within 10%", datasets=experiments([], runs=30))


# --- system size ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("edges", "met"),
    [([(15, 18), (23, 32), (27, 40)], 1), ([(15, 18), (23, 26), (27, 40)], 0)],
)
def test_the_width_of_the_transition_against_n(edges, met):
    rows = {
        (n, 1.0): cut(fall=transition(*edge, error=0.1 * n, n=n))
        for n, edge in zip((5, 7, 10), edges, strict=True)
    }
    found = measured("transition-width", rows=rows)
    assert found.value == {str(n): edge for n, edge in zip((5, 7, 10), edges, strict=True)}
    assert found.uncertainty["7"] == pytest.approx((0.7, 0.7)) and found.sample_size == 22
    assert passed(found) == [met] and found.note == ""
    rows[7, 1.0] = cut(fall=transition(1, 2, found=False))
    assert "not found" in measured("transition-width", rows=rows).note


@pytest.mark.parametrize(
    ("lengths", "checks"),
    [
        ([[250, 300], [300, 350], [9000], []], [1, 0]),
        ([[250, 300], [300, 350], [400], [500]], [1, 1]),
        ([[250, 300], [300], [400], [500]], [0, 1]),
        ([[250, 249], [2000, 7600], [9000], [9500]], [0, 1]),  # 4.99 % and 96 %
        ([[250, 250], [2000, 7500], [9000], [9500]], [1, 1]),
    ],
)
def test_laminar_phases_of_ten_blocks(lengths, checks):
    names, u = ("n10_u28", "n10_u31", "n10_u34", "n10_u38"), [28.0, 31, 34, 38]
    phases = {}
    for name, own in zip(names, lengths, strict=True):
        edges = [(20_000.0 * k, 20_000.0 * k + length) for k, length in enumerate(own)]
        phases[name] = (np.array(edges).reshape(-1, 2), 10_000.0)
    series = {name: data(belt_velocity=place) for name, place in zip(names, u, strict=True)}
    found = measured("n10-intermittency", phases=phases, datasets=series)
    for place, own in zip(u, lengths, strict=True):
        assert found.value[f"u = {place:g}, laminar share"] == sum(own) / 10_000
        mean = sum(own) / len(own) if own else 0
        assert found.value[f"u = {place:g}, mean phase"] == mean
    assert passed(found) == checks and found.sample_size == sum(map(len, lengths))


@pytest.mark.parametrize(
    ("contrast", "checks"),
    [
        ([4, 3, 2, 1.5], [1, 1]),
        ([3, 4, 2, 1.5], [1, 1]),  # rank correlation -0.8
        ([3, 2, 5, 1.5], [0, 1]),
        ([1.5, 4, 3, 2], [0, 0]),
        ([4, 3, 2, math.nan], [1, 1]),
    ],
)
def test_rises_against_n(contrast, checks):
    sizes, edges = (5, 6, 7, 10), (18.0, 25.0, 32.0, 40.0)
    scan = {"n_blocks": np.repeat(sizes, 2), "belt_velocity": np.repeat(edges, 2)}
    scan["belt_velocity"][::2] -= 3
    columns = {
        (n, u): cut(rise=transition(1, 2, high=ratio, low=1.0, n=n))
        for n, u, ratio in zip(sizes, edges, contrast, strict=True)
    }
    found = measured("r-of-sigma-size", columns=columns, datasets={"size_columns": data(scan)})
    assert list(found.value.values()) == [1.0 if math.isnan(each) else each for each in contrast]
    assert passed(found) == checks and found.sample_size == 28
    few = {name: values[:4] for name, values in scan.items()}
    with pytest.raises(NotEnoughDataError, match="2 numbers of blocks, 3 are needed"):
        measured("r-of-sigma-size", columns=columns, datasets={"size_columns": data(few)})


@pytest.mark.parametrize(
    ("effects", "checks"),
    [
        ((0.4, 0.3, 0.2, 0.1), [1, 1]),
        ((0.3, 0.4, 0.2, 0.1), [1, 1]),
        ((0.3, 0.1, 0.4, 0.2), [0, 1]),
        ((0.2, 0.1, 0.4, 0.3), [0, 0]),
    ],
)
def test_the_effect_of_noise_on_r(effects, checks):
    """At shared u only, alternately more and less than without noise."""
    u, rows = np.arange(1.0, 11), {}
    sign = np.where(np.arange(10) % 2, 1, -1)
    for n, effect in zip((5, 6, 7, 10), effects, strict=True):
        rows[n, 0.0] = cut([*u, 60.0], disorder=np.full(11, 0.1))
        own = effect * (1 + 0.1 * sign)
        rows[n, 1.0] = cut([0.5, *u + 1e-9], disorder=[9, *(0.1 * np.exp(sign * own))])
    found = measured("noise-less-relevant", "r, sigma = 1", rows=rows)
    assert list(found.value.values()) == pytest.approx(effects)
    # the sample of +-0.1 of it about its mean
    error = [0.1 * effect * math.sqrt(10 / 9) / math.sqrt(10) for effect in effects]
    assert list(found.uncertainty.values()) == pytest.approx(error)
    assert passed(found) == checks and found.sample_size == 40
    rows[6, 1.0] = cut(u[:7], disorder=u[:7])
    with pytest.raises(NotEnoughDataError, match="7 shared belt velocities at N = 6"):
        measured("noise-less-relevant", "r, sigma = 1", rows=rows)


def test_the_effect_of_noise_on_section_velocities():
    u, rows = np.arange(1.0, 11), {}
    velocities = np.full((10, 60), np.nan)
    velocities[:, :40] = np.arange(40.0)
    for n, shift in zip((5, 6, 7, 10), (20, 10, 5, 1), strict=True):
        rows[n, 0.0] = cut(u, velocities=velocities)
        rows[n, 1.0] = cut(u, velocities=velocities + shift)
        rows[n, 1.0].points["section_velocity"][0, 29:] = np.nan  # too few to compare
    name = "section velocities, sigma = 1"
    found = measured("noise-less-relevant", name, rows=rows)
    assert list(found.value.values()) == pytest.approx([20 / 40, 10 / 40, 5 / 40, 1 / 40])
    assert found.sample_size == 36 and passed(found) == [1, 1]
    readings = REGISTRY["noise-less-relevant"](Stub("noise-less-relevant", rows=rows))
    assert list(readings) == ["r, sigma = 1", "r, sigma = 5", name]
    rows |= {(n, 5.0): cut(u, disorder=np.full(10, math.e)) for n in (5, 6, 7, 10)}
    assert list(readings["r, sigma = 5"]().value.values()) == pytest.approx([1.0] * 4)
    for n in (5, 6, 7, 10):
        rows[n, 1.0].points["section_velocity"][:3, 29:] = np.nan
    with pytest.raises(NotEnoughDataError, match="too few points to compare at N = 5"):
        readings[name]()


@pytest.mark.parametrize(
    ("ratio", "checks"),
    [
        (np.full(30, 0.029), [1, 1]),
        (np.full(30, -0.031), [0, 1]),
        (np.tile([0.15, -0.07], 15), [1, 1]),  # mean 0.04 within 3 errors of 0.0201
        (np.tile([0.09, -0.01], 15), [0, 1]),  # mean 0.04, error 0.0093
        (np.array([0.183, -0.183, 0.183, -0.183] + [0.0] * 26), [1, 0]),
        (np.array([0.183, -0.183, 0.183] + [0.0] * 27), [1, 1]),
        (np.array([0.182, -0.182, 0.182, -0.182] + [0.0] * 26), [1, 1]),  # ln 1.2 = 0.1823
    ],
)
def test_both_methods_agree(ratio, checks):
    u = np.arange(1.0, 31)

    def scan(method, disorder, noise=1.0, places=u):
        arrays = {"n_blocks": np.full(places.size, 5), "belt_velocity": places}
        arrays |= {"noise": np.full(places.size, noise), "disorder_parameter": disorder}
        return data(arrays, method=method)

    datasets = {
        "n5_rows": scan("verlet", np.full(30, 0.08)),
        "n5_rows_check": scan("verlet", np.full(30, 0.12)),  # means of replicates are compared
        "n5_map": scan("event", 0.1 * np.exp(ratio)),
        "size_rows": scan("event", np.full(30, 9.0), noise=0.0),
        "size_rows_check": scan("verlet", np.full(30, 1.0), noise=0.0),
    }
    found = measured("method-independence", datasets=datasets)
    error = np.std(ratio, ddof=1) / math.sqrt(30)
    assert found.value["mean ln(r_event / r_verlet)"] == pytest.approx(ratio.mean())
    assert found.value["share beyond 20 %"] == np.mean(np.abs(ratio) > math.log(1.2))
    assert found.uncertainty["mean ln(r_event / r_verlet)"] == pytest.approx(error, abs=1e-15)
    assert found.sample_size == 30 and passed(found) == checks
    datasets["n5_map"] = scan("event", np.ones(23), places=u[:23])
    with pytest.raises(NotEnoughDataError, match="23 points with noise"):
        measured("method-independence", datasets=datasets)


# --- evidence -------------------------------------------------------------------------------------


def test_a_cut_reads_its_points():
    made = cut([1.0, 5, 9], noise=[0, 1, 2], disorder=[0.1, 0.2, 0.3], velocities=[[1], [2], [3]])
    assert made.between(1, 5).tolist() == [True, True, False]
    assert made.between(1 + 1e-12, 9 - 1e-12).tolist() == [True, True, True]
    assert made.noise.tolist() == [0, 1, 2] and made.disorder.tolist() == [0.1, 0.2, 0.3]
    assert made.velocities.tolist() == [[1], [2], [3]]

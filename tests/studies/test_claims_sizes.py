"""Claims on other numbers of blocks, by made-up runs with a known answer."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.studies.sizes import measure
from beltrepro.replication.verdicts.criteria import IN_PART, NO, OPEN, YES
from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.stats import estimates
from made_up import CLEAR, both, grades, joined, measured, motion_map, scan

SIZES = (5, 6, 7, 10)
PRINTED = {5: (15, 18), 6: (18, 24), 7: (23, 32), 10: (27, 40)}


@pytest.fixture(autouse=True)
def fewer_resamples(monkeypatch):
    monkeypatch.setattr(estimates, "RESAMPLES", 40)
    monkeypatch.setattr(measure, "RESAMPLES", 30)
    monkeypatch.setattr(estimates, "bootstrap", partial(estimates.bootstrap, resamples=80))


# --- width of the transition ----------------------------------------------------------------------


WHOLE = np.arange(6.0, 60)


def falling_runs(edges=(), *, noise=1.0, low=0.02, replicates=8, u=WHOLE):
    """Runs whose r has lost 10 % of its fall at the lower edge and 90 % at the upper one."""
    rng = np.random.default_rng(1)
    made = PRINTED | dict(edges)
    shares = [0.9 - 0.8 * (u - first) / (last - first) for first, last in made.values()]
    mean = np.repeat(low + (0.13 - low) * np.clip(np.concatenate(shares), 0, 1), replicates)
    disorder = mean * (1 + 0.02 * rng.standard_normal(mean.size))
    sizes = np.repeat(list(made), u.size)
    return scan(sizes, np.tile(u, len(made)), disorder, noise=noise, replicates=replicates)


def rows_and_runs(edges=(), **options):
    """One run at each u of a fine grid, and independent runs."""
    row = falling_runs(edges, u=np.arange(6.05, 50, 0.1), replicates=1, **options)
    runs = falling_runs(edges, **options)
    return {"n5_density": row, "size_density": row} | by_size(runs)


def by_size(runs):
    return dict.fromkeys(("n5_replicates", "size_replicates"), runs)


@pytest.mark.parametrize(
    ("edges", "verdict"),
    [
        ({10: (20, 48)}, YES),
        ({5: (9, 24), 7: (25, 29)}, IN_PART),  # narrower
        ({7: (20, 35), 10: (33, 34)}, IN_PART),  # ten blocks narrower than seven
    ],
)
def test_regions_where_they_are_printed_and_wider_with_each_size(edges, verdict):
    assert both("transition-width", **rows_and_runs(edges)) == (verdict, verdict)


@pytest.mark.parametrize(
    ("edges", "verdict"),
    [
        ({}, YES),
        ({5: (8, 26), 10: (30, 34)}, NO),
        ({5: (14, 20), 6: (18, 24)}, OPEN),
    ],
)
def test_the_sharpest_transition(edges, verdict):
    assert grades("sharpest-at-n5", "replicated", **rows_and_runs(edges))[""] == verdict
    quiet = rows_and_runs(edges, noise=0.0)
    assert grades("sharpest-at-n5", "robust", **quiet)[""] == verdict


# --- intermittency of ten blocks ------------------------------------------------------------------

PLACES = np.arange(20.0, 45)


def ten_blocks(share, count=9, last=1e6):
    """Runs of ten blocks, eight at each u: laminar share, number of phases, last stick."""
    numbers = {"laminar_fraction": share, "laminar_count": count, "last_stick_time": last}
    runs = {name: np.broadcast_to(np.asarray(v, float), 200).copy() for name, v in numbers.items()}
    made = scan(10, PLACES, 0.1, replicates=8, **runs)
    return {"size_replicates": made, "size_rows": made}


RISE = np.repeat(np.clip((PLACES - 25) / 18, 0.06, 0.94), 8)


@pytest.mark.parametrize(
    ("runs", "verdicts"),
    [
        ({"share": RISE}, (YES, YES)),
        ({"share": RISE, "last": 919_999.0}, (YES, IN_PART)),  # before the last tenth of the time
        ({"share": RISE, "last": np.nan}, (YES, IN_PART)),  # no stick at all
        ({"share": RISE, "count": 1}, (IN_PART, IN_PART)),  # one phase is no alternation
        ({"share": 0.0 * RISE}, (NO, IN_PART)),
    ],
)
def test_ten_blocks_alternate(runs, verdicts):
    assert both("n10-intermittency", **ten_blocks(**runs)) == verdicts


# --- motions --------------------------------------------------------------------------------------

U = np.arange(1.0, 41)
FLAT = 0.1 * (1 + 0.02 * np.sin(7 * U))


def small(letters="p" * 150, *, factor=1.0, duration=CLEAR):
    """Motions of two to four blocks, and rows of which that of four blocks falls by a factor."""
    fall = np.where(U < 20.5, FLAT, FLAT / factor)
    rows = scan(np.repeat([2, 3, 4], 40), np.tile(U, 3), np.concatenate([FLAT, FLAT, fall]))
    runs = {n: letters[50 * k : 50 * (k + 1)] for k, n in enumerate((2, 3, 4))}
    u = np.linspace(1, 40, 50)
    disorder = np.concatenate([np.interp(u, U, row) for row in (FLAT, FLAT, fall)])
    motions = motion_map(runs, u=u, duration=duration, disorder=disorder)
    return {"motion_map": motions, "size_rows": rows}


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, YES),
        ({"letters": "c" * 4 + "p" * 146}, YES),  # fewer than one in twenty
        ({"letters": "c" * 30 + "p" * 120}, IN_PART),
        ({"letters": "p" * 140 + "t" * 10}, OPEN),
        ({"factor": 6.5}, IN_PART),
    ],
)
def test_small_chains_are_regular_and_have_no_transition(changes, verdict):
    assert both("small-n-regular", **small(**changes)) == (verdict, verdict)


def chaos_from(letters, **options):
    """Motions at 60 velocities below every transition, and periodic ones beyond."""
    u = np.concatenate([np.linspace(1, 12, 60), np.linspace(50, 60, 10)])
    runs = {n: motion + "p" * 10 for n, motion in zip(SIZES, letters, strict=True)}
    motions = motion_map(runs, u=u, **options)
    return {"motion_map": motions} | by_size(falling_runs(noise=0.0))


DOMINANT = ("c" * 45 + "p" * 15, "c" * 52 + "p" * 8, "c" * 56 + "p" * 4, "c" * 60)


@pytest.mark.parametrize(
    ("letters", "verdict"),
    [
        (DOMINANT, YES),
        (DOMINANT[::-1], IN_PART),  # more windows with more blocks
        (("p" * 60, *DOMINANT[1:]), IN_PART),
        (("p" * 20 + "c" * 40,) * 4, OPEN),
    ],
)
def test_chaos_dominates_from_five_blocks_on(letters, verdict):
    assert grades("chaos-from-n5", "robust", **chaos_from(letters))[""] == verdict


def test_chaos_by_the_look_of_the_diagram_is_of_the_scheme_below_the_transition():
    u = np.round(np.arange(0.05, 20.01, 0.05), 2)
    few = (np.arange(u.size) % 10 < 5) | (u > 16)  # half of five blocks are periodic
    band = np.full((u.size, 100), 30)
    five = np.where(few[:, None] & (np.arange(100) >= 20), 0, band)
    made = {
        "n5_density": scan(5, u, 0.1, section_histogram=five),
        "size_density": scan(
            np.repeat(SIZES[1:], u.size),
            np.tile(u, 3),
            0.1,
            section_histogram=np.tile(band, (3, 1)),
        ),
    } | by_size(falling_runs(noise=0.0))
    numbers = measured("chaos-from-n5", **made)
    assert numbers.judged["chaotic, N = 5"].value == pytest.approx(0.5, abs=0.03)
    assert numbers.judged["chaotic, N = 10"].value == 1.0
    assert numbers.also["periodic, N = 5"].value == pytest.approx(0.5, abs=0.03)
    assert grades("chaos-from-n5", **made)["periodic share over N"] == YES


ALL = (2, 3, 4, *SIZES)
VARIED, DULL = "c" * 20 + "p" * 20 + "q" * 10 + "e" * 10, "c" * 55 + "p" * 5


def varied(*richest, returns=500):
    u = np.linspace(1, 50, 60)
    return motion_map({n: VARIED if n in richest else DULL for n in ALL}, u=u, returns=returns)


@pytest.mark.parametrize(
    ("richest", "verdict"),
    [((5,), YES), ((7,), NO), ((5, 7), OPEN)],
)
def test_the_richest_dynamics(richest, verdict):
    assert both("complexity-at-n5", motion_map=varied(*richest))[0] == verdict


def test_more_runs_of_one_number_of_blocks_make_its_dynamics_no_richer():
    once = varied(4, 5, returns=np.arange(420))
    more = motion_map({4: VARIED[::-1]}, u=np.linspace(1, 50, 60), returns=np.arange(1000, 1060))
    more.arrays["replicate"] += 1
    expected = measured("complexity-at-n5", motion_map=once).judged
    for twice in (joined(once, more), joined(more, once)):
        assert measured("complexity-at-n5", motion_map=twice).judged == expected


def test_the_entropy_is_that_of_the_shares():
    made = measured("complexity-at-n5", motion_map=varied(5)).also
    for n_blocks, counts in ((5, [20, 20, 10, 10]), (10, [55, 5])):
        share = np.array(counts) / 60
        assert made[f"bits, N = {n_blocks}"].value == pytest.approx(-np.sum(share * np.log2(share)))
    alike = motion_map(dict.fromkeys(ALL, "p" * 60), u=np.linspace(1, 50, 60))
    with pytest.raises(NotEnoughDataError, match="all runs of all N are alike"):
        measured("complexity-at-n5", motion_map=alike)


# --- noise ----------------------------------------------------------------------------------------

LEVELS = np.arange(0.0, 10.5, 1)


def columns(ratios, *, scatter=0.02, replicates=8):
    """r(sigma) of each N that rises by a ratio about sigma = 4, and a flat one at a smaller u."""
    rng = np.random.default_rng(1)
    share = np.clip(0.5 + (LEVELS - 4) / 2, 0, 1)
    rises = [0.02 * (1 + (factor - 1) * share) for ratio in ratios for factor in (ratio, 1.0)]
    disorder = np.repeat(np.concatenate(rises), replicates)
    disorder = disorder * (1 + scatter * rng.standard_normal(disorder.size))
    sizes = np.repeat(SIZES, 2 * LEVELS.size)
    places = np.array([(18.0 + n, 12.0) for n in SIZES]).ravel().repeat(LEVELS.size)
    return scan(sizes, places, disorder, noise=np.tile(LEVELS, 8), replicates=replicates)


@pytest.mark.parametrize(
    ("ratios", "options", "verdict"),
    [
        ((6.0, 9.0, 3.0, 2.0), {}, YES),
        ((2.0, 3.0, 4.0, 6.0), {}, NO),
        ((6.0, 4.0, 3.0, 2.0), {"replicates": 1}, OPEN),  # single runs tell nothing
    ],
)
def test_rises_against_n(ratios, options, verdict):
    """Of six blocks the rise is reported only."""
    made = columns(ratios, **options)
    assert grades("r-of-sigma-size", size_columns=made)[""] == verdict


@pytest.mark.parametrize(
    ("low", "verdict"), [((0.02, 0.03, 0.04, 0.06), YES), ((0.06, 0.04, 0.03, 0.02), NO)]
)
def test_rises_beyond_the_fall_of_each_n(low, verdict):
    """Without noise r is low at 1.1 times u_c, and with strong noise it is as high as ever."""
    quiet = falling_runs(noise=0.0)
    sizes, u = quiet.arrays["n_blocks"], quiet.arrays["belt_velocity"]
    for n, r in zip(SIZES, low, strict=True):
        quiet.arrays["disorder_parameter"][(sizes == n) & (u >= sum(PRINTED[n]) / 2)] = r
    noisy = falling_runs(noise=5.0, low=0.129, u=np.arange(6, 50, 0.1), replicates=1)
    runs = by_size(quiet) | {"n5_density": noisy, "size_density": noisy}
    assert grades("r-of-sigma-size", "robust", **runs)[""] == verdict
    rise = measured("r-of-sigma-size", "beyond each fall", **runs).also["N = 6"]
    assert rise.value == pytest.approx(np.log(0.129 / low[1]), abs=0.1)


def test_the_rise_is_measured_at_the_highest_velocity_of_each_n():
    made = measured("r-of-sigma-size", size_columns=columns((6.0, 4.0, 3.0, 2.0)))
    assert made.also["N = 5"].value == pytest.approx(np.log(6), abs=0.05)
    slope = np.polyfit((5, 7, 10), np.log([6, 3, 2]), 1)[0]
    assert made.judged["slope over N"].value == pytest.approx(slope, abs=0.02)


def noisy_and_quiet(effects, *, scatter=0.05, count=8, seed=1, beyond=0.0):
    """Runs in which noise changes ln r by these effects, up and down in turn; and at u = 40."""
    rng = np.random.default_rng(seed)
    u = np.append(np.arange(8.0, 37, 2), 40.0)
    turn = np.where(np.arange(u.size) % 2, 1.0, -1.0)
    sizes, noises, r, v = [], [], [], []
    for n_blocks, effect in zip(SIZES, effects, strict=True):
        for noise in (0.0, 1.0):
            change = np.repeat(np.append(effect * turn[:-1], beyond) * noise, count)
            r.append(0.1 * np.exp(change + scatter * rng.standard_normal(change.size)))
            v.append(rng.normal(3 * change[:, None], 1.0, (change.size, 20)))
            sizes += [n_blocks] * u.size
            noises += [noise] * u.size
    made = {"noise": np.array(noises), "section_velocity": np.concatenate(v)}
    disorder = np.concatenate(r)
    return scan(np.array(sizes), np.tile(u, 8), disorder, replicates=count, **made)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("effects", "verdict"),
    [((0.5, 0.4, 0.3, 0.1), YES), ((0.1, 0.3, 0.4, 0.5), NO), ((0.3,) * 4, OPEN)],
)
def test_the_effect_of_noise_against_n(effects, verdict):
    made = noisy_and_quiet(effects, beyond=2.0)  # u = 40 is not asked
    assert both("noise-less-relevant", **by_size(made)) == (verdict, verdict)


def test_the_scatter_of_the_runs_is_no_effect_of_noise():
    """Without an effect the interval holds zero in 95 of 100, however much the runs scatter."""
    effects = []
    for seed in range(25):
        made = noisy_and_quiet((0,) * 4, scatter=0.5, seed=seed)
        cuts = made.arrays["n_blocks"], made.arrays["noise"]
        for n_blocks in SIZES:
            rows = [_row(made, (cuts[0] == n_blocks) & (cuts[1] == s)) for s in (0.0, 1.0)]
            effects.append(measure.effect_on_r(8, 36, *rows))
    held = sum(effect.low <= 0 <= effect.high for effect in effects)
    assert abs(np.mean([effect.value for effect in effects])) < 0.012  # 0.06 with the scatter in it
    assert held >= 88  # of 100: 95 expected, three standard errors less


def test_the_effect_of_noise_is_its_mean_square_less_the_scatter_of_means():
    u, counts, rng = np.array([8.0, 10.0, 14.0, 16.0]), (8, 9, 12, 8), np.random.default_rng(4)
    both_logs = [
        [rng.normal(change, 0.3, count) for change, count in zip(changes, counts, strict=True)]
        for changes in ((0.0, 0.0, 0.0, 0.0), (0.5, -0.4, 0.8, 0.1))
    ]
    rows = []
    for logs in both_logs:
        r = np.exp(np.concatenate(logs))
        made = {"belt_velocity": np.repeat(u, counts), "disorder_parameter": r}
        rows.append(Cut(made, 2e5, 1e6))
    squares, variances = [], []
    for quiet, noisy in zip(*both_logs, strict=True):
        error = sum(np.sum((x - x.mean()) ** 2) / (len(x) - 1) / len(x) for x in (quiet, noisy))
        squares.append((noisy.mean() - quiet.mean()) ** 2 - error)
        variances.append(4 * max(squares[-1], 0) * error + 2 * error**2)
    weights = np.array([1.0, 3.0, 3.0, 1.0]) / 8  # of the trapezoidal rule
    found = measure.effect_on_r(8, 16, *rows)
    assert found.value == pytest.approx(weights @ squares) and found.runs == 8
    reach = 1.959964 * np.sqrt(weights**2 @ variances)
    assert (found.low, found.high) == pytest.approx((found.value - reach, found.value + reach))


def _row(made, chosen):
    return Cut({name: values[chosen] for name, values in made.arrays.items()}, 2e5, 1e6)


def test_distributions_at_the_section_are_compared_and_averaged_over_u(monkeypatch):
    monkeypatch.setattr(measure, "RESAMPLES", 3)
    u, rng = np.array([1.0, 2.0, 4.0, 5.0, 9.0, 20.0]), np.random.default_rng(8)

    def row(shift, counts):
        samples = {p: shift * p + rng.normal(size=n) for p, n in zip(u, counts, strict=True)}
        place = np.repeat(u, counts)
        velocities = np.concatenate([samples[p] for p in u])
        velocities[place == 5.0] = np.where(rng.random(sum(place == 5.0)) < 0.9, np.nan, 1.0)
        return SimpleNamespace(
            belt_velocity=place, velocities=velocities, samples=samples,
            between=lambda low, high: (place >= low) & (place <= high),
        )  # fmt: skip

    quiet, noisy = row(0.0, [40, 50, 35, 60, 45, 80]), row(0.2, [45, 40, 55, 70, 36, 90])
    counted = [1.0, 2.0, 4.0, 9.0]  # at 5 there are few crossings, 20 is beyond the range
    far = []
    for place in counted:
        one, other = quiet.samples[place], noisy.samples[place]
        ends = np.concatenate([one, other])
        far.append(max(abs(np.mean(one <= end) - np.mean(other <= end)) for end in ends))
    value = measure.effect_on_section(1.0, 9.0, quiet, noisy).value
    assert value == pytest.approx(np.trapezoid(far, counted) / 8)

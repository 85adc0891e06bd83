"""Claims on how noise changes the transition: made-up runs with a known answer."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.verdicts.criteria import IN_PART, NO, OPEN, YES
from beltrepro.stats import estimates
from made_up import LEDGER, both, falling, grades, joined, measured, replicates, table

RISING = {0.0: 16.5, 0.5: 16.7, 1.0: 17.0, 2.2: 19.0, 5.0: 20.5}  # u_c by sigma
WINDOWS = {0.0: 0.25}
SCHEME = "n5_replicates_check"  # where replicated has its runs without noise from


@pytest.fixture(autouse=True)
def fewer_resamples(monkeypatch):
    """Enough for intervals whose ends are not asked for to a few percent."""
    monkeypatch.setattr(estimates, "RESAMPLES", 60)


def runs(critical=RISING, windows=WINDOWS, **changes):
    """Runs of both integrators, which agree but for what changes say."""
    made = replicates(critical, windows=windows, **changes)
    return {"n5_replicates": made, SCHEME: made, "n5_density": made}


# --- Figs. 13 and 14 ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "name", "verdict"),
    [
        ({}, "", YES),
        ({"critical": RISING | {1.0: 22.0}}, "u_c(1) - u_c(0)", NO),
        ({"critical": RISING | {1.0: 18.5}}, "u_c(1) - u_c(0)", IN_PART),
        ({"windows": {0.0: 0.5, 1.0: 0.5}}, "windows at 1", NO),
        ({"windows": {}, "scatter": {0.0: 0.003, 1.0: 0.01}}, "scatter of r, 1 over 0", NO),
    ],
)
def test_weak_noise_leaves_the_transition_and_removes_windows(changes, name, verdict):
    assert grades("sigma1-transition", **runs(**changes))[name] == verdict


def test_replicated_has_the_runs_without_noise_from_the_scheme():
    made = runs() | {SCHEME: replicates({0.0: 13.5}, noises=[0.0], width=1.0)}
    name = "u_c(1) - u_c(0)"
    shifts = [measured("sigma1-transition", of, **made).judged[name].value
              for of in ("the paper's scheme", "exact dynamics")]  # fmt: skip
    assert shifts == pytest.approx([3.5, 0.5], abs=0.5)


@pytest.mark.parametrize(
    ("critical", "verdicts"),
    [
        (RISING, (YES, YES)),
        ({0.0: 19.0, 0.5: 18.0, 1.0: 16.5, 2.2: 15.0, 5.0: 13.0}, (NO, NO)),
        (RISING | {1.0: 14.0}, (YES, IN_PART)),  # a dip that the ends do not show
        (dict.fromkeys(RISING, 17.0), (NO, IN_PART)),
    ],
)
def test_u_c_of_sigma(critical, verdicts):
    assert both("uc-of-sigma", **runs(critical)) == verdicts


@pytest.mark.parametrize(
    ("u_c", "verdict"), [(18.8, YES), (15.0, NO), (17.9, IN_PART), (99.0, OPEN)]
)
def test_the_critical_velocity_at_sigma_22(u_c, verdict):
    made = runs(RISING | {2.2: u_c}, width=1.0)
    assert both("uc-sigma22", **made) == (verdict, verdict)
    if u_c < 90:
        in_si = measured("uc-sigma22", **made).also["u_c_m_s"].value
        assert in_si == pytest.approx(0.0183065 * u_c, rel=0.02)


@pytest.mark.parametrize(
    ("share", "expected"),
    [
        ({0.0: 0.5}, [YES, YES, YES]),
        ({0.0: 0.0}, [OPEN, YES, YES]),  # one run of fifty may still be in a window
        ({0.0: 0.125, 2.2: 0.5}, [YES, YES, NO]),
    ],
)
def test_windows_are_counted_at_each_noise(share, expected):
    made = runs(windows=share)
    verdict = grades("windows-vanish", **made)
    assert [verdict[f"at sigma = {level}"] for level in ("0", "1", "2.2")] == expected
    estimate = measured("windows-vanish", **made).judged["at sigma = 0"]
    # eight runs at each of eight velocities up to 15
    assert (estimate.value, estimate.runs) == (share[0.0], 64)


@pytest.mark.parametrize(("spread", "share"), [(0.45, 0.5), (0.55, 0.0)])
def test_a_window_fills_less_than_half_of_the_usual_bins(spread, share):
    made = replicates(RISING)
    half = (made.arrays["noise"] == 0) & (made.arrays["replicate"] <= 4)
    velocity = np.linspace(-60, 0, 100) * np.ones((half.size, 1))
    made.arrays["section_velocity"] = np.where(half[:, None], spread * velocity, velocity)
    exact = measured("windows-vanish", "exact dynamics", n5_replicates=made)
    assert exact.judged["at sigma = 0"].value == share
    bins = np.linspace(-60, 0, 101)
    counts = [np.histogram(run, bins)[0] for run in made.arrays.pop("section_velocity")]
    made.arrays["section_histogram"] = np.array(counts).astype(np.uint32)
    assert measured("windows-vanish", n5_density=made).judged["at sigma = 0"].value == share


# --- along sigma ----------------------------------------------------------------------------------


def rising(noise, centre, width, *, low=0.06, high=0.13):
    return low + (high - low) * np.clip((noise - centre + width / 2) / width, 0, 1)


def u7(centre):
    noise = np.repeat(np.arange(0, 2.01, 0.1), 8)
    rng = np.random.default_rng(2)
    disorder = rising(noise, centre, 0.2) + 0.002 * rng.standard_normal(noise.size)
    return table(np.column_stack([np.full(noise.size, 7.0), noise]), disorder)


def noisy_motion(exponents, *, scatter=1e-4):
    """Largest exponents at u = 7, by noise: mean over eight runs."""
    noise = np.repeat(list(exponents), 8)
    about = scatter * np.tile([-1.0, 1.0], noise.size // 2)
    arrays = {
        "n_blocks": np.full(noise.size, 5),
        "belt_velocity": np.full(noise.size, 7.0),
        "noise": noise,
        "largest_exponent": np.repeat(list(exponents.values()), 8) + about,
    }
    return Dataset(arrays, {"transient": 1e5, "duration": 2e5})


EXPONENTS = {0.25: -0.001, 0.75: 0.0, 1.0: 0.001, 1.5: 0.002, 2.2: 0.003, 5.0: -0.001}


def of_u7(centre=0.75, exponents=(), rest=0.001, **options):
    made = noisy_motion(EXPONENTS | dict(exponents), **options)
    after_rest = noisy_motion({1.0: rest, 2.2: 0.001}, **options)
    return {"n5_u7": u7(centre), "noisy_motion": made, "noisy_motion_rest": after_rest}


@pytest.mark.parametrize(
    ("changes", "verdicts"),
    [
        ({}, (YES, YES)),
        ({"centre": 1.3}, (NO, IN_PART)),
        ({"exponents": {1.5: -0.001}}, (YES, IN_PART)),
        ({"exponents": {0.25: 0.001}}, (YES, IN_PART)),
        ({"rest": -0.001}, (YES, IN_PART)),  # no chaos by the other clock of the noise
        # not asked about, between the periodic and the chaotic noises and beyond them
        ({"exponents": {0.75: -0.001, 5.0: -0.001}}, (YES, YES)),
    ],
)
def test_noise_induced_chaos_at_u_7(changes, verdicts):
    assert both("sigma-c-u7", **of_u7(**changes)) == verdicts


def columns(centre, width, *, high=0.13):
    """Columns at six u; centre and width are functions of u."""
    rng = np.random.default_rng(4)
    points, disorder = [], []
    for u in (18.0, 20.0, 22.0, 25.0, 30.0, 35.0, 40.0):
        noise = np.repeat(np.arange(0, 10.01, 0.5), 8)
        points += [(u, one) for one in noise]
        chosen = rising(noise, centre(u), width(u), high=high)
        disorder += list(chosen + 0.001 * rng.standard_normal(noise.size))
    return {"n5_columns": table(points, disorder)}


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, [YES, YES, YES]),
        ({"centre": lambda u: 8 - 0.1 * u}, [YES, NO, YES]),
        ({"width": lambda u: 5 - 0.1 * u}, [YES, YES, NO]),
        ({"centre": lambda u: 4.0, "width": lambda u: 2.0}, [YES, NO, OPEN]),
    ],
)
def test_the_rise_of_r_against_u(changes, expected):
    made = columns(**{"centre": lambda u: 0.2 * u - 2, "width": lambda u: 0.1 * u} | changes)
    verdict = grades("r-of-sigma", **made)
    assert [verdict[name] for name in LEDGER["r-of-sigma"].robust.allowed] == expected


# --- Figs. 17 and 18 ------------------------------------------------------------------------------


def rows(spread):
    """Single runs at sigma = 0 and 10; spread of v_N above u = 25, by noise."""
    points = [(u, s) for s in spread for u in np.arange(1.0, 51)]
    rng = np.random.default_rng(6)
    reach = np.array([spread[s] if u > 25 else 60.0 for u, s in points])
    reach *= rng.uniform(0.8, 1.2, len(points))
    velocity = -reach[:, None] * rng.random((len(points), 100))
    return table(points, np.ones(len(points)), section_velocity=velocity)


@pytest.mark.parametrize(
    ("changes", "strong", "verdict"),
    [
        ({}, 50.0, YES),
        ({"width": {1.0: 9.0, 5.0: 1.0}}, 50.0, IN_PART),
        ({"width": {1.0: 9.0, 5.0: 1.0}, "windows": {1.0: 0.5}}, 5.0, NO),
    ],
)
def test_the_natural_distribution(changes, strong, verdict):
    width = {0.0: 1.0, 0.5: 1.0, 1.0: 1.0, 2.2: 2.0, 5.0: 9.0} | changes.get("width", {})
    made = runs(windows=changes.get("windows", {}), width=width)
    made["n5_density"].arrays["method"] = np.full(len(made["n5_density"].arrays["noise"]), "event")
    made["n5_density"] = joined(rows({10.0: strong}), made["n5_density"])
    assert both("natural-distribution", **made) == (verdict,) * 2


def map_of(factor=1.0, *, quiet=0, loud=0):
    """Map at whole u; of the points at low u and sigma = 1 so many are quiet, of high u loud."""
    points = np.array([(u, s) for s in (0.0, 1.0, 5.0) for u in np.arange(1.0, 51)])
    u, noise = points.T
    disorder = falling(u, np.select([noise == 0, noise == 1], [16.5, 17.0], 20.5), 3.0) * factor
    disorder[np.flatnonzero((u <= 15) & (noise == 1))[:quiet]] = 0.05
    disorder[np.flatnonzero((u >= 25) & (noise <= 2))[:loud]] = 0.13
    return table(points, disorder)


@pytest.mark.parametrize(
    ("change", "verdicts"),
    [
        ({}, (YES, YES)),
        ({"factor": 1.2}, (IN_PART, IN_PART)),
        ({"quiet": 14}, (IN_PART, IN_PART)),
        ({"loud": 14}, (IN_PART, IN_PART)),  # most, but not nearly all
    ],
)
def test_the_map(change, verdicts):
    made = {"n5_map": map_of(**change), "n5_replicates": replicates(RISING)}
    assert both("r-map", **made) == verdicts


def test_the_map_is_not_compared_across_integrators():
    made = replicates(RISING)
    made.arrays["disorder_parameter"][made.arrays["noise"] == 0] *= 9
    assert grades("r-map", n5_map=map_of(), n5_replicates=made)[""] == YES
    with pytest.raises(NotEnoughDataError, match="0 points shared, not 10"):
        measured("r-map", n5_map=map_of(), n5_replicates=replicates(RISING, noises=(0.0,)))


# --- what sigma means -----------------------------------------------------------------------------


def noise_steps(r_of, *, scatter=0.002, method="verlet"):
    points = [(s, dt) for s in (0.5, 1.0, 2.0) for dt in (0.00025, 0.001, 0.004) for _ in range(8)]
    noise, step = np.array(points).T
    rng = np.random.default_rng(7)
    disorder = r_of(noise, step) * np.exp(scatter * rng.standard_normal(noise.size))
    return {
        "noise_steps": table(
            np.column_stack([np.full(72, 18.0), noise]), disorder, time_step=step, method=method
        )
    }


@pytest.mark.parametrize(
    ("r_of", "scatter", "verdict"),
    [
        (lambda noise, step: 0.002 + 1.5 * noise * np.sqrt(step), 0.002, YES),
        (lambda noise, step: 0.02 + 0.05 * noise, 0.002, NO),
        (lambda noise, step: 0.002 + 20 * noise * step, 0.002, YES),
        (lambda noise, step: 0.05 * (step / 0.001) ** 0.3, 1.0, OPEN),
    ],
)
def test_the_noise_depends_on_the_time_step(r_of, scatter, verdict):
    assert both("noise-time-step", **noise_steps(r_of, scatter=scatter)) == (verdict, verdict)


def test_a_step_that_exact_motion_does_not_know_is_not_judged():
    with pytest.raises(NotEnoughDataError, match="not by the paper's scheme"):
        measured("noise-time-step", **noise_steps(lambda noise, step: noise, method="event"))

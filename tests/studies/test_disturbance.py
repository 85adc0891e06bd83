"""Orbits and what loses them; laws of lifetimes; the published tables and the command for them."""

import numpy as np
import pandas as pd
import pytest

from beltrepro import ChainParameters, periodic_orbit
from beltrepro.chaos import orbit_loss
from beltrepro.replication.studies.disturbance import measure, runs
from beltrepro.replication.verdicts.criteria import IN_PART, NO, YES
from beltrepro.stats import survival
from made_up import few_resamples, grades, measured  # noqa: F401


@pytest.fixture(scope="module")
def track():
    orbit = periodic_orbit(ChainParameters(2, 5.0), duration=4000, transient=2000)
    return orbit_loss.Track.of(orbit)


def test_an_undisturbed_run_stays_and_one_moved_far_has_left(track):
    start = track.starts[0]
    away = start.moved(start.parameters.rest_positions + start.displacements - [25.0, 0.0])
    cases = orbit_loss.Setup(
        [state.parameters for state in (track.starts[0], away)],
        initial_state=[track.starts[0], away],
    ).cases
    left = track.left(cases, [0.0, 0.0], 500.0)
    assert np.isinf(left[0]) and left[1] < 100


def test_kicks_far_below_the_margin_keep_an_orbit(track):
    margin = orbit_loss.margin(track, begin=0.05, periods=5, slips=8)
    kick = orbit_loss.loss(track, orbit_loss.KICK, duration=500.0, replicates=2)
    assert 0 < kick.low <= kick.size <= kick.high
    assert kick.low < margin


@pytest.mark.parametrize(("shape", "law"), [(1.0, "exponential"), (3.0, "weibull")])
def test_the_law_of_made_up_lifetimes_is_found(shape, law):
    time = np.random.default_rng(1).weibull(shape, 2000) * 50
    excess = survival.compare_laws(time, np.ones(2000, bool))
    assert excess[law] <= 2.5 and excess["inverse_gaussian"] > 50


def test_published_orbits_lose_at_a_share_of_their_margin():
    table = measure.orbits_lost({})
    lines = measure.loss_lines({"orbits_lost": table}).set_index("disturbance")
    assert lines.loc["kick", "power_low"] < 1.01 and lines.loc["kick", "power_high"] > 0.99
    assert (lines["spread"] < lines["spread_by_slips"]).all()


def test_the_command_makes_rows_once(tmp_path, monkeypatch):
    monkeypatch.setattr(runs, "FEW", (2, 2000.0))
    made = [runs.make("irregular_lifetimes", tmp_path, {4: (20,)}) for _ in range(2)]
    assert len(made[0]) == len(made[1]) == 2
    assert set(made[0]) == set(measure._published("irregular_lifetimes"))


# --- what is judged -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("powers", "verdict"),
    [((1, 1, 1), YES), ((1, 0.5, 1), IN_PART), ((0.6, 0.5, 1.5), NO), ((1.15, 0.9, 1), YES)],
)
def test_sizes_that_go_as_powers_of_the_margin(monkeypatch, powers, verdict):
    orbits = measure.orbits_lost({}).head(30).copy()
    orbits["margin"] = np.geomspace(1e-4, 1, 30)
    scatter = 1.1 ** np.resize([-1.0, 1.0, 0.0], 30)
    for name, power in zip(("kick", "step", "noise"), powers, strict=True):
        orbits[name] = 0.3 * orbits["margin"] ** power * scatter
    orbits["noise_as_kick"] = 0.5
    monkeypatch.setattr(measure, "orbits_lost", lambda data: orbits)
    assert grades("orbit-loss")[""] == verdict
    numbers = measured("orbit-loss").numbers
    assert [numbers[f"power, {name}"].value for name in ("kicks", "steps", "noise")] == (
        pytest.approx(powers, abs=0.05)
    )
    if powers == (1, 1, 1):
        shares = [numbers[f"share, {name}"].value for name in ("kicks", "steps", "noise")]
        assert shares == pytest.approx([0.3, 0.3, 0.15], rel=0.01)


@pytest.mark.parametrize(("rates", "verdict"), [((1, 2), YES), ((1, -2), IN_PART), ((-1, -1), NO)])
def test_lifetimes_that_grow_or_not(monkeypatch, rates, verdict):
    points = [(n, u, 100 * np.exp(c * n)) for u, c in zip((30.0, 40.0), rates, strict=True)
              for n in (4, 5, 6, 7)]  # fmt: skip
    n_blocks, velocity, lifetime = np.array(points).T
    table = {"n_blocks": n_blocks, "belt_velocity": velocity, "ended": 9, "lifetime": lifetime}
    table |= {"lifetime_low": lifetime / 1.2, "lifetime_high": lifetime * 1.2}
    monkeypatch.setattr(measure, "lifetime_growth", lambda data: pd.DataFrame(table))
    assert grades("lifetime-growth")[""] == verdict
    assert measured("lifetime-growth").numbers["rate, u = 40"].value == pytest.approx(rates[1])

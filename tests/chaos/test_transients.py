"""How long irregular motion lasts: against runs of `simulate` that are judged after the fact."""

import dataclasses

import numpy as np
import pytest
from scipy import stats

from advancing import sliding
from beltrepro import ChainParameters, ChainState, classify, simulate, slipping_state, time_to_orbit
from beltrepro.base.errors import InputError
from beltrepro.chaos.irregular import SCATTERS, WIDEST, _Run, disturbance, scatters
from beltrepro.chaos.naming import ends_in_slip
from beltrepro.chaos.vectors import INTERVAL
from beltrepro.simulation.setup import Case

FIVE = ChainParameters(5, 16.0)


def several(chain, count, **settings):
    return time_to_orbit(
        [chain] * count, replicate=range(1, count + 1), initial_spread=10.0, **settings
    )


@pytest.fixture(scope="module")
def five():
    return several(FIVE, 4, duration=60_000)


def test_lifetime_is_that_of_the_order_of_slips(five):
    slowest = int(np.argmin(five["lifetime"]))
    run = simulate(FIVE, duration=20_000, replicate=slowest + 1, initial_spread=10.0)
    slips = run.events[run.events["kind"] == "slip"]
    period = five["period_events"][slowest]
    broken = max(
        number
        for number in range(len(slips) - period)
        if slips["block"][number] != slips["block"][number + period]
    )
    assert five["lifetime"][slowest] == pytest.approx(slips["time"][broken + 1], abs=1e-9)


def test_the_settled_tail_changes_no_irregular_exponent(five):
    """A run that is given up where the irregular motion ends has the same exponent."""
    assert np.sum(five["irregular_time"] > 0) >= 2
    for row in np.flatnonzero(five["irregular_time"] > 0):
        end = INTERVAL * int(five["lifetime"][row] / INTERVAL)
        cut = time_to_orbit(FIVE, duration=end, replicate=row + 1, initial_spread=10.0)
        assert cut["irregular_time"][0] == five["irregular_time"][row] == end - 500.0
        for name in ("irregular_exponent", "irregular_error"):
            assert cut[name][0] == pytest.approx(five[name][row], rel=1e-6)


def test_in_a_slow_chain_irregular_motion_is_followed_for_longer():
    """Blocks of mass 16 take four times as long."""
    for chain, unit in ((ChainParameters(7, 10.0), 1), (ChainParameters(7, 2.5, mass=16.0), 4)):
        short, long = (time_to_orbit(chain, duration=unit * time) for time in (1480.0, 1600.0))
        assert short["irregular_time"] == 0 and np.isnan(short["irregular_exponent"])
        assert long["irregular_time"] == unit * 1100 and np.isfinite(long["irregular_exponent"])


def test_slow_motion_settles_as_its_like_in_other_units_and_in_company():
    """The same orbit of heavy blocks, and a block that sticks for longer than most runs last."""
    light, heavy = ChainParameters(3, 10.0), ChainParameters(3, 10.0 / 32, mass=32.0**2)
    one = time_to_orbit(light, duration=3000.0)
    other = time_to_orbit(heavy, duration=32 * 3000.0)
    done, heavier = [], ChainParameters(3, 10.0 / 64, mass=64.0**2)
    several = [heavy, light, heavier]
    together = time_to_orbit(several, duration=3000.0, progress=done.append)
    assert one["state"][0] == other["state"][0] == "periodic"
    for name in ("lifetime", "period_time"):
        assert other[name] == pytest.approx(32 * one[name], rel=1e-6)
    assert other["mean_length"] == pytest.approx(one["mean_length"], rel=1e-4)
    assert np.array_equal(together["return_state"][1], one["return_state"][0])
    assert done == sorted(done) and done[-1] == 1.0
    rare = ChainParameters(1, 4e-4)
    orbit = time_to_orbit(rare, duration=2.4e6)
    motion = classify(rare, duration=2.4e6, transient=1.2e6)
    assert (orbit["state"][0], orbit["period_events"][0]) == ("periodic", 1)
    assert orbit["period_time"][0] == pytest.approx(motion.period_time)


def test_a_run_that_is_given_up_counts_as_irregular(five):
    first = int(np.argmax(five["lifetime"]))
    orbits = time_to_orbit(FIVE, duration=5000, replicate=first + 1, initial_spread=10.0)
    assert five["lifetime"][first] > 5000
    assert not orbits["settled"][0]
    assert (orbits["state"][0], orbits["lifetime"][0]) == ("irregular", 5000)
    assert np.isnan(orbits["period_time"][0])


def test_a_little_more_time_is_no_window_of_its_own():
    chain = ChainParameters(5, 10.0, 1.0)
    whole, more = (time_to_orbit(chain, duration=time) for time in (2000.0, 2000.3))
    assert more["disorder_parameter"] == pytest.approx(whole["disorder_parameter"], rel=0.01)


def test_a_run_does_not_depend_on_its_company(five):
    alone = time_to_orbit(FIVE, duration=60_000, replicate=3, initial_spread=10.0)
    for name in ("lifetime", "period_time", "irregular_exponent", "return_state"):
        assert np.array_equal(alone[name][0], five[name][2], equal_nan=True)


def test_one_block_and_continuous_slip_are_settled_from_their_start():
    chain = ChainParameters(3, 40.0)
    state = dataclasses.replace(sliding(chain, 3 * np.array([1.0, -2.0, 2.0])), time=700.0)
    slips = time_to_orbit(chain, duration=5000, initial_state=state)
    assert (slips["state"][0], slips["lifetime"][0]) == ("equilibrium slip", 0.0)
    one = time_to_orbit(ChainParameters(1, 5.0), duration=5000)
    assert one["settled"][0] and one["period_events"][0] == 1
    assert one["lifetime"][0] < one["period_time"][0]
    assert np.isnan(one["irregular_exponent"][0])


# Swings that bring a block to the belt after long: of a chain of much energy, of one whose friction
# falls fast enough with velocity for large swings alone to grow.
FAST = ChainParameters(5, 100.0, rest_length=500.0)
LINEAR = {"rest_length": 500.0, "linear_limit": np.inf}
GROWING = ChainParameters(1, 50.0, weakening_velocity=1000.0, viscosity=0.02917, **LINEAR)
SWINGS = [
    (FAST, slipping_state(FAST, 7500.0, replicate=3)),
    (GROWING, ChainState.in_motion(GROWING, [500 + 32.13 / 1.05 + 0.02917 * 50], [49.0])),
]


@pytest.mark.parametrize(("chain", "state"), SWINGS)
def test_slip_of_all_blocks_that_will_end_is_not_settled(chain, state):
    run = simulate(chain, duration=4000, initial_state=state, sample_interval=None)
    first = run.events["time"][0]
    assert 1000 < first < 2000
    ended = time_to_orbit(chain, duration=6000, initial_state=state)
    assert ended["state"][0] != "equilibrium slip"
    assert ended["lifetime"][0] > first
    assert classify(chain, duration=1000, transient=100, initial_state=state).state == "transient"


def test_modes_tell_whether_friction_that_falls_for_some_blocks_ends_a_swing():
    law = {"friction_ratio": (0, 0.45), "weakening_velocity": 100.0} | LINEAR
    for viscosity, state in ((0.12, "equilibrium slip"), (0.05, "periodic")):
        chain = ChainParameters(2, 50.0, viscosity=viscosity, **law)
        start = ChainState.in_motion(chain, [550.0, 1080.0], [3.0, -2.0])
        assert time_to_orbit(chain, duration=8000, initial_state=start)["state"][0] == state


def test_a_balance_that_is_not_stable_is_no_end():
    chain = ChainParameters(2, 50.0, weakening_velocity=100.0, **LINEAR)
    start = {"initial_state": ChainState.at_balance(chain)}
    assert time_to_orbit(chain, duration=3000, **start)["state"][0] == "irregular"
    assert not ends_in_slip(start["initial_state"], 1e-3, 0.0, 500.0, returned=True)
    assert classify(chain, duration=3000, transient=500, **start).state == "transient"


@pytest.mark.parametrize(("viscosity", "calm"), [(0.0, False), (0.002, False), (0.1, True)])
def test_noise_ends_slip_that_viscosity_does_not_calm(viscosity, calm):
    """The mean energy that noise brings grows, or is of u^2 / 2 = 12.5 the same, or a 50th."""
    chain = ChainParameters(1, 5.0, noise=5.0, viscosity=viscosity, **LINEAR)
    start = ChainState.in_motion(chain, [500 + 0.45 * 71.4 + viscosity * 5], [0.0])
    how = {"time_step": 0.01, "replicate": range(20), "initial_state": start}
    runs = simulate(chain, duration=50_000, sample_interval=None, **how)
    assert sum(run.events.size > 0 for run in runs) == (0 if calm else 20)
    slips = np.array([np.any(run.events["time"] < 600) for run in runs])
    assert np.any(~slips)
    settled = time_to_orbit(chain, duration=600, **how)
    motions = classify([chain] * 20, duration=600, transient=100, **how)
    name = "equilibrium slip" if calm else "irregular"
    assert set(settled["state"][~slips]) == {name}
    assert set(motions["state"][~slips]) == {name if calm else "transient"}
    assert not np.any(settled["state"][slips] == "equilibrium slip")


def test_an_orbit_begins_after_a_slip_that_lasted():
    slips = np.array([1.0, 60.0, 70.0, 80.0]), np.zeros(4, dtype=int)
    run = _Run(Case(SWINGS[0][1], "event", 0.001, None), 0.0, slipped=False, slips=[slips])
    assert run._repeats_since(1, 10.0) == 60


DISTURBED = [{"method": "verlet", "time_step": step} for step in (1e-3, 4e-3)]


@pytest.mark.parametrize("how", DISTURBED)
def test_a_disturbed_orbit_is_recognised(five, how):
    """No run that begins on an attracting orbit is missed."""
    states = [
        ChainState.in_motion(
            FIVE, FIVE.rest_positions + values[:5], values[5:] + FIVE.belt_velocity
        )
        for values in five["return_state"]
    ]
    disturbed = time_to_orbit([FIVE] * 4, duration=3000, initial_state=states, **how)
    assert disturbed["settled"].all()
    assert disturbed["period_events"].tolist() == five["period_events"].tolist()
    assert np.all(disturbed["lifetime"] <= 1000)


def test_orbits_under_weak_noise_are_recognised():
    noisy = several(ChainParameters(5, 7.0, noise=1e-3), 4, duration=30_000)
    assert (noisy["state"] == "periodic").all()


def test_an_orbit_begins_with_its_first_slip_where_noise_ends_continuous_slip():
    chain = ChainParameters(2, 15.0, noise=0.2)
    state = slipping_state(chain, 1.1 * 15.0**2 / 2, replicate=2)
    orbit = time_to_orbit(chain, duration=2000, initial_state=state)
    events = simulate(chain, duration=2000, initial_state=state, sample_interval=None).events
    assert orbit["state"][0] == "periodic"
    assert orbit["lifetime"][0] == events["time"][events["kind"] == "slip"][0] > 900


def test_when_a_run_begins_changes_no_lifetime():
    state = simulate(ChainParameters(5, 7.0), duration=100.0).final_state
    early, late = (
        time_to_orbit(state.parameters, duration=20_000, initial_state=begun)
        for begun in (state, dataclasses.replace(state, time=0.0))
    )
    assert early["state"][0] == late["state"][0] == "periodic" and early["lifetime"][0] > 100
    for name in ("lifetime", "period_time", "irregular_time"):
        np.testing.assert_allclose(late[name], early[name], rtol=1e-6)


@pytest.mark.thorough
@pytest.mark.parametrize("how", DISTURBED)
@pytest.mark.parametrize("n_blocks", [7, 10])
def test_irregular_motion_is_not_taken_for_a_disturbed_orbit(n_blocks, how):
    """None of 16 runs with 8 looks each: fewer than one of 42 looks errs (95 %)."""
    orbits = several(ChainParameters(n_blocks, 10.0), 16, duration=15_000, **how)
    assert (orbits["state"] == "irregular").all()


def test_irregular_motion_on_stiff_springs_is_not_taken_for_a_disturbed_orbit():
    """Springs 100 times as stiff, lengths a hundredth: the motion at u = 10 in other units."""
    lengths = {"rest_length": 0.5, "linear_limit": 0.2, "stiffness": 100.0}
    rates = {"compression_rate": 20.0, "extension_rate": 1.0}
    chain = ChainParameters(5, 1.0, noise=1e-3, **lengths, **rates)
    starts = {"replicate": range(1, 5), "initial_spread": 0.01, "time_step": 1e-4}
    assert (time_to_orbit(chain, duration=500, **starts)["state"] == "irregular").all()


@pytest.mark.parametrize("closed", [0.0, 1.0])
def test_the_share_that_counts_as_closed_is_between_zero_and_one(closed):
    with pytest.raises(InputError, match=f"closed = {closed:g}: must be greater than 0 and less"):
        time_to_orbit(FIVE, duration=10.0, closed=closed)


# --- the disturbance of a run ---

STATE, NOISY = (ChainState.at_rest(ChainParameters(5, 6.0, noise)) for noise in (0.0, 0.3))
EXACT = Case(STATE, "event", 0.001, None)


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({}, 0.0),
        ({"time_step": 0.1}, 0.0),
        ({"method": "verlet"}, 6.0 * 0.001 / 3**0.5),
        ({"method": "verlet", "time_step": 0.004}, 6.0 * 0.004 / 3**0.5),
        ({"state": NOISY}, 0.3),
        ({"state": NOISY, "method": "verlet"}, np.hypot(0.3, 0.006 / 3**0.5)),
    ],
)
def test_disturbance_of_a_run(changed, expected):
    point = dataclasses.replace(EXACT, **changed)
    assert disturbance(point) == pytest.approx(expected)
    widest = WIDEST * 71.4
    limits = [one * expected for one in SCATTERS if one * expected < widest]
    assert scatters(point) == pytest.approx([*limits, widest] if expected else [])


def first_sticks(chain, **how):
    """How much further on the belt than in exact motion one block first sticks, 320 starts."""

    def places(runs):
        begin = np.array([run.positions[0, 0] for run in runs])
        time, place = np.transpose([run.events[["time", "position"]][1].tolist() for run in runs])
        return place - begin - chain.belt_velocity * time

    starts = {"duration": 40, "initial_spread": 1.0, "sample_interval": 10.0}
    exact = places(simulate(ChainParameters(1, chain.belt_velocity), replicate=[1], **starts))
    return places(simulate(chain, replicate=range(1, 321), **starts, **how)) - exact


@pytest.mark.filterwarnings("ignore")
def test_slips_of_the_scheme_begin_late_by_a_time_within_half_a_step():
    """It lets a block stick 2 u t less far on the belt."""
    late = first_sticks(ChainParameters(1, 3.0), method="verlet")
    # 2 t / dt is uniform, beside a dt^2 / 2 = 2e-5 at the stick, one part in 150
    assert stats.kstest(late / 0.003, stats.uniform(-1.0, 2.0).cdf).pvalue > 1e-3


@pytest.mark.filterwarnings("ignore")
def test_a_threshold_larger_by_f_lets_one_spring_stretch_f_further():
    # in so short a step noise does nothing to a block that slips
    moved = first_sticks(ChainParameters(1, 3.0, noise=0.01), time_step=1e-9)
    assert stats.kstest(moved / 0.02, "norm").pvalue > 1e-3

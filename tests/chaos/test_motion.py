"""Names of motions: maps and flows whose motion is known, and chains followed by `simulate`."""

import re
import warnings

import numpy as np
import pytest

from advancing import sliding
from beltrepro import (
    ChainParameters,
    Grid,
    basins,
    classify,
    lyapunov_spectrum,
    periodic_orbit,
    simulate,
    time_to_orbit,
)
from beltrepro.stats.motion import (
    CHAOTIC,
    EQUILIBRIUM,
    NOISE_DRIVEN,
    PERIODIC,
    QUASI_PERIODIC,
    STABLE_CHAOS,
    TRANSIENT,
    name_motion,
)

# --- maps and flows with known answers ---


COMMON = {"slides": False, "closed": False, "standard_error": [1e-5, 1e-5], "time": 1e6}


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"exponents": [0.01, 0.0]}, CHAOTIC),
        ({"exponents": [0.0, -0.01]}, TRANSIENT),
        ({"exponents": [0.0, 0.0]}, QUASI_PERIODIC),
        ({"exponents": [0.0, 0.0], "time": 1000.0, "returns": 50}, TRANSIENT),  # too short to tell
        ({"exponents": [0.002, 0.0], "time": 1000.0, "returns": 50}, TRANSIENT),
        ({"exponents": [0.01, 0.0], "standard_error": [0.004, 0.004]}, TRANSIENT),
        ({"exponents": [0.01, 0.0], "closed": True}, PERIODIC),
        ({"exponents": [0.01, 0.0], "slides": True}, EQUILIBRIUM),
        ({"exponents": [0.01, 0.0], "noisy": True}, CHAOTIC),
        ({"exponents": [-0.01, -0.02], "noisy": True}, NOISE_DRIVEN),
        ({"exponents": [0.0, -0.02], "noisy": True}, NOISE_DRIVEN),
        ({"exponents": [0.0, -0.02], "noisy": True, "time": 1000.0, "returns": 50}, TRANSIENT),
        ({"exponents": [0.0, -0.01], "nontrivial": (-0.01, 1e-5)}, STABLE_CHAOS),
        ({"exponents": [0.0, -0.01], "nontrivial": (-0.01, 4e-3)}, TRANSIENT),
        ({"exponents": [0.0, -0.01], "nontrivial": (-0.01, 1e-5), "returns": 19}, TRANSIENT),
        # shrinks by e^18 in half of the time: an orbit that is approached does not count as one yet
        ({"exponents": [0.0, -0.01], "nontrivial": (-0.01, 1e-5), "time": 3600.0}, TRANSIENT),
        ({"exponents": [0.01, 0.0], "nontrivial": (0.01, 1e-5)}, CHAOTIC),
        ({"exponents": [0.0, -0.02], "nontrivial": (-0.02, 1e-5), "noisy": True}, NOISE_DRIVEN),
        ({"exponents": [0.0, -0.01], "nontrivial": (-0.01, 1e-5), "closed": True}, PERIODIC),
    ],
)
def test_criteria(changes, expected):
    assert name_motion(**(COMMON | {"returns": 10**5} | changes)) == expected


# --- chains ---


def test_five_blocks_end_on_one_of_two_periods():
    start = {"duration": 60000.0, "replicate": range(8), "initial_spread": 1.0}
    motions = classify([ChainParameters(5, 16.0)] * 8, transient=50000.0, **start)
    periods = set(zip(motions["period_time"].round(3), motions["period_events"], strict=True))
    assert set(motions["state"]) == {PERIODIC}
    assert (41.047, 18) in periods <= {(41.047, 18), (105.962, 57)}
    assert np.all(np.abs(motions["largest_exponent"]) < 3 * motions["standard_error"])


@pytest.mark.thorough
def test_irregular_motion_that_contracts_is_stable_chaos():
    """Replicate 2 was still irregular after 1.2e7; replicate 1 settles before the time observed."""
    start = {"transient": 10_000.0, "replicate": [1, 2], "initial_spread": 10.0}
    motions = classify([ChainParameters(5, 10.75)] * 2, duration=600_000.0, **start)
    assert motions["state"].tolist() == [PERIODIC, STABLE_CHAOS]
    assert motions["period_events"].tolist() == [2332, 0]
    assert motions["erased"].tolist() == [5, 5]
    assert motions["nontrivial_exponent"][1] == pytest.approx(-0.0005, abs=2e-4)
    assert np.all(np.abs(motions["largest_exponent"]) < 3 * motions["standard_error"])
    # in a tenth of the time the exponent cannot be told from zero
    short = classify([ChainParameters(5, 10.75)] * 2, duration=60_000.0, **start)
    assert short["state"].tolist() == [PERIODIC, TRANSIENT]


@pytest.mark.parametrize("chain", [ChainParameters(4, 12.0), ChainParameters(7, 10.0)])
def test_what_is_measured_beside_is_what_simulate_measures(chain):
    start = {"duration": 3000.0, "transient": 1000.0, "replicate": 1, "initial_spread": 1.0}
    motions = classify(chain, **start)
    run = simulate(chain, method="event", **start)
    # the sample at the end of the transient counts in one of them; of an orbit, whole periods do
    near = 2e-3 if motions.state == PERIODIC else 2e-4
    assert motions.disorder_parameter == pytest.approx(run.disorder_parameter, rel=near)
    assert motions.mean_length == pytest.approx(run.mean_length, rel=1e-5 if near < 1e-3 else near)


def test_r_of_periodic_motion_is_that_of_its_orbit():
    """The run settles after the transient: irregular motion comes before the orbit."""
    chain, transient = ChainParameters(5, 18.0), 3000.0
    motion = classify(chain, duration=5000.0, transient=transient)
    orbit = periodic_orbit(chain, duration=5000.0, transient=transient)
    assert motion.state == PERIODIC
    assert motion.disorder_parameter == pytest.approx(orbit.disorder_parameter, rel=1e-6)
    assert motion.mean_length == pytest.approx(orbit.mean_length, rel=1e-9)
    both = simulate(chain, duration=5000.0, transient=transient)
    assert both.disorder_parameter > 2 * orbit.disorder_parameter


@pytest.mark.parametrize("transient", [0.0, 0.05, 100.0])
def test_returns_are_noted_without_a_mean_length_too(transient):
    """In a transient shorter than the time between two samples no length is measured."""
    motions = classify([ChainParameters(1, 3.0)], duration=transient + 400.0, transient=transient)
    assert motions["state"].tolist() == [PERIODIC]
    assert motions["period_returns"].tolist() == [1]
    assert motions["period_events"].tolist() == [1]


@pytest.mark.parametrize(
    ("chain", "transient", "period"),
    [
        (ChainParameters(3, 1.0), 100.0, 109.405),
        (ChainParameters(2, 3.0), 20.0, 27.341),
        *((ChainParameters(3, 12.0), transient, 29.098) for transient in (1.0, 5.0)),
        (ChainParameters(3, 20.0), 2.0, 75.929),
        (ChainParameters(3, 1.2, mass=100.0), 50.0, 290.981),
    ],
)
def test_a_motion_is_periodic_however_much_of_its_loading_is_left_out(chain, transient, period):
    duration = 6000.0 if chain.mass == 1 else 15_000.0
    motion = classify(chain, duration=duration, transient=transient)
    assert motion.state == PERIODIC and motion.period_time == pytest.approx(period, abs=1e-3)


def test_two_slips_are_no_stable_chaos():
    assert classify(ChainParameters(1, 0.01), duration=20_000, transient=10_000).state == TRANSIENT


def test_the_clock_of_the_noise_is_told_to_the_vectors():
    """By the clock of the rest the largest exponent is that of the motion itself, zero."""
    chain = ChainParameters(5, 7.0, 2.2)
    runs = {"duration": 20000, "transient": 4000, "replicate": range(1, 17)}
    rest, laboratory = (
        classify([chain] * 16, noise_clock=clock, **runs)["largest_exponent"]
        for clock in ("rest", "laboratory")
    )
    apart = laboratory - rest
    assert apart.mean() > 3 * apart.std(ddof=1) / np.sqrt(apart.size)


def test_the_unit_of_time_changes_no_name_and_no_error():
    """Also where a shift of time is taken out."""
    one, other = (
        classify(ChainParameters(5, 17 / time, mass=time**2), duration=3000 * time,
                 transient=1000 * time)
        for time in (1.0, 0.01)
    )  # fmt: skip
    assert one.state == other.state
    for name in ("largest_exponent", "nontrivial_exponent", "standard_error", "nontrivial_error"):
        assert 0.01 * getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-3)


def test_chains_of_several_units_of_time_have_exponents_in_one_table():
    chains = [ChainParameters(2, 10.0), ChainParameters(2, 1000.0, mass=1e-4)]
    spectra = lyapunov_spectrum(chains, duration=300, transient=100, n_exponents=2)
    assert spectra["growth"].shape == (2, 10, 2) and spectra["interval"] == 20


# --- where nothing happens ---


def advised(called, chains, **settings):
    """What comes of a call on chains that wait for a slip, and with the lengths it advises."""
    with pytest.warns(UserWarning, match="blocks slip too rarely") as caught:
        waiting = called(chains, **settings)
    text = str(caught.pop().message)
    advice = {name: float(value) for name, value in re.findall(r"(transient|duration)=(\d+)", text)}
    with warnings.catch_warnings(action="error"):
        return waiting, called(chains, **settings | advice)


@pytest.mark.parametrize("chain", [ChainParameters(1, 0.1), ChainParameters(2, 0.05)])
def test_a_chain_that_loads_has_no_name_and_no_exponent(chain):
    lengths = {"duration": 600.0, "transient": 100.0}
    motion, later = advised(classify, chain, **lengths)
    assert motion.state == TRANSIENT and np.isfinite(later.largest_exponent)
    assert np.isnan([motion.largest_exponent, motion.standard_error, motion.period_time]).all()
    assert np.isnan([motion.nontrivial_exponent, motion.nontrivial_error]).all()
    spectrum, later = advised(lyapunov_spectrum, chain, **lengths)
    assert np.isnan([*spectrum.exponents, *spectrum.standard_error]).all()
    assert np.isnan([spectrum.nontrivial_exponent, spectrum.nontrivial_error]).all()
    assert (spectrum.trivial, spectrum.erased) == (None, 0)
    assert (later.trivial, later.erased) == (0, chain.n_blocks)


def test_a_chain_that_no_run_sees_slip_is_told_so():
    for velocity in (5e-324, 1e-300, 1e-9):
        with pytest.warns(UserWarning, match=r"more rarely than the longest run shows \(1e\+12\)$"):
            classify(ChainParameters(1, velocity), duration=300.0, transient=0.0)


@pytest.mark.filterwarnings("ignore:blocks slip too rarely")
def test_r_of_few_samples_is_not_told():
    with pytest.warns(UserWarning, match="r and <x_N> are NaN"):
        motion = classify(ChainParameters(2, 10.0), duration=40.5, transient=40.0)
    assert np.isnan([motion.disorder_parameter, motion.mean_length]).all()


def test_a_rest_between_slips_is_no_equilibrium():
    chain, how = ChainParameters(5, 0.05), {"sample_interval": None, "transient": 9600.0}
    run = simulate(chain, duration=16000.0, **how)
    gaps = np.diff(run.events["time"])
    begin = float(run.events["time"][np.argmax(gaps * (run.events["time"][:-1] > 9600.0))])
    start = simulate(chain, duration=begin + 1.0, **how).final_state
    motion, later = advised(classify, [chain], duration=400.0, transient=0.0, initial_state=start)
    assert motion["state"] == [TRANSIENT] and np.isnan(motion["largest_exponent"])
    assert np.isfinite(later["largest_exponent"])


def test_what_has_not_moved_has_not_settled():
    grid = Grid(1, [0.1], replicates=4)
    waiting, later = advised(basins, grid, duration=600.0, initial_spread=1.0)
    assert [one.state for one in waiting.attractors] == ["irregular"]
    assert not waiting.runs["settled"].any() and np.all(waiting.runs["lifetime"] == 600.0)
    assert np.isnan(waiting.runs["irregular_exponent"]).all()
    assert [(one.state, one.reached_by) for one in later.attractors] == [(PERIODIC, 4)]


@pytest.mark.parametrize("duration", [5000.0, 8000.0])
def test_a_motion_of_one_slip_in_a_window_is_not_irregular_without_a_word(duration):
    """It is periodic, one slip in 1260.92."""
    waiting, later = advised(time_to_orbit, ChainParameters(1, 0.05), duration=duration)
    assert not waiting["settled"] and later["state"] == PERIODIC
    assert later["period_time"] == pytest.approx(1260.92, abs=0.01)


@pytest.mark.filterwarnings("ignore:blocks slip too rarely")
def test_one_slip_of_all_blocks_is_no_equilibrium():
    """Ten periods of the slowest mode are needed, each of 11.4."""
    chain = ChainParameters(3, 60.0)
    start = {"transient": 0.0, "initial_state": sliding(chain, np.array([0.5, -1.0, 1.5]))}
    for duration, state in (10.0, TRANSIENT), (110.0, TRANSIENT), (120.0, EQUILIBRIUM):
        assert classify(chain, duration=duration, **start).state == state
        settled = time_to_orbit(chain, duration=duration, initial_state=start["initial_state"])
        assert settled["settled"].tolist() == [state == EQUILIBRIUM]


def test_slip_under_friction_that_falls_with_velocity_is_no_equilibrium():
    """Its swing grows by e in 131; a block sticks at 1341."""
    chain = ChainParameters(3, 30.0, weakening_velocity=2000.0, linear_limit=np.inf)
    less = 0.45 * 71.4 * (1 - 1 / (1 + 30.0 / 2000.0))  # friction than of slow slip
    start = sliding(chain, np.array([-3.0 * less, -5.0 * less, -6.0 * less + 1e-3]))
    motion = classify(chain, duration=600.0, transient=100.0, initial_state=start)
    assert motion.state == TRANSIENT
    assert motion.nontrivial_exponent == pytest.approx(1 / 131, rel=0.05)
    with warnings.catch_warnings(action="error"):
        short, long = (time_to_orbit(chain, duration=t, initial_state=start) for t in (1e3, 3e3))
    assert (short["settled"][0], short["lifetime"][0]) == (False, 1000.0)
    assert long["state"][0] == PERIODIC and long["lifetime"][0] > 1341


@pytest.mark.parametrize("duration", [220.0, 650.0])
def test_steady_slip_has_no_period(duration):
    """Viscosity brings the block to rest, where it crosses its mean length by rounding alone."""
    chain = ChainParameters(1, 20.0, viscosity=3.0, linear_limit=1e3)
    motion = classify(chain, duration=duration, transient=150.0)
    assert motion.state == EQUILIBRIUM and motion.disorder_parameter < 1e-12
    assert np.isnan(motion.period_time) and motion.period_events == 0


def test_no_period_is_told_from_few_disturbed_returns():
    """Two blocks return seven times in 3000; four agreed about within a limit."""
    slow = {"method": "verlet", "time_step": 0.004, "replicate": [1, 2], "initial_spread": 5.0}
    runs = time_to_orbit(ChainParameters(2, 0.5), duration=3000.0, **slow)
    assert not runs["settled"].any() and np.all(runs["lifetime"] == 3000.0)

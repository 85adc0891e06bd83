"""Outside the paper's law: a wrong number is never given without a word."""

import dataclasses
import warnings
from functools import partial

import numpy as np
import pytest

import naive
from beltrepro import ChainParameters, ChainState, scan, simulate, time_to_continuous_slip
from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.engine.vector import exp2, kernel
from beltrepro.engine.verlet_integrator import longest_step
from beltrepro.model.friction import START_NOISE, start_noise
from beltrepro.model.spring import external_force

METHODS = ("verlet", "event")


def failure(*arguments, **options):
    """The one line with which a run stops."""
    with pytest.raises(ModelStateError) as error:
        simulate(*arguments, sample_interval=None, **options)
    assert "\n" not in str(error.value)
    return str(error.value)


def time_of(message):
    return float(message.split("at t = ")[1].split()[0])


# --- blocks that meet ---


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("noise", [0.0, 1e-3])
@pytest.mark.parametrize(("n_blocks", "belt_velocity"), [(1, 500.0), (3, 300.0)])
def test_blocks_that_meet_stop_the_run_where_they_do(n_blocks, belt_velocity, noise, method):
    positions, _ = naive.verlet(n_blocks, belt_velocity, 8000)
    gaps = np.diff(np.array(positions), axis=1, prepend=0.0)
    meeting = 0.001 * (1 + np.flatnonzero((gaps <= 0).any(axis=1))[0])
    chain = ChainParameters(n_blocks, belt_velocity, noise)
    for duration in (20.0, 200.0):
        message = failure(chain, duration=duration, method=method)
        # here it is the spring at the wall
        assert message.startswith(f"{chain.describe()}: block 1 reaches the support at")
        assert "time_step" not in message
        assert time_of(message) == pytest.approx(meeting, abs=0.005)


def test_blocks_meet_where_their_own_spring_has_no_length():
    chain = ChainParameters(3, 40.0, rest_length=(80.0, 50.0, 1.0))
    times = []
    for method in METHODS:
        message = failure(chain, duration=60.0, method=method)
        assert "blocks 2 and 3 meet at" in message
        times.append(time_of(message))
    assert times[0] == pytest.approx(times[1], abs=0.005)


def test_a_step_too_long_for_stiff_springs_is_told_as_such():
    stiff = {"compression_rate": 50, "extension_rate": 2, "linear_limit": 1}
    chain = ChainParameters(5, 40.0, **stiff)
    message = failure(chain, duration=100, method="verlet")
    assert "the time step is too long" in message and "time_step = 0.001" in message
    # motion itself presses a short spring together: that its blocks meet is no fault of a fine step
    short = ChainParameters(5, 40.0, **stiff, rest_length=(50, 50, 50, 50, 0.01))
    fine = {"method": "verlet", "time_step": 1e-4}
    assert "blocks 4 and 5 meet at" in failure(short, duration=100, **fine)


@pytest.mark.parametrize("n_blocks", [1, 2])
def test_springs_that_stiffen_too_fast_for_the_step_do_not_blame_the_rest_length(n_blocks):
    chain = ChainParameters(n_blocks, 10.0, extension_rate=1e4)
    message = failure(chain, duration=20, method="verlet")
    assert "the time step is too long" in message and "rest_length" not in message
    assert simulate(chain, duration=20.0).energy_residual == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(
    ("n_blocks", "law", "least"),
    [(1, {"viscosity": 800.0}, "0.0007462"), (1, {"mass": 2e-7}, "8.944e-05"),
     (2, {"stiffness": 2e6}, "8.164e-05"), (3, {"mass": (1, 1, 1e-7)}, "4.472e-05")],
)  # fmt: skip
def test_a_step_at_which_the_scheme_is_unstable_or_coarse_is_refused(n_blocks, law, least):
    """0.6 m / eta, and a fifth over a bound of the largest frequency."""
    chain = ChainParameters(n_blocks, 10.0, rest_length=1000.0, **law)
    with pytest.raises(InputError, match=f"time_step = 0.001: .* needs {least} or less; or"):
        simulate(chain, duration=1.0, method="verlet")
    steps = {"time_step": float(least), "sample_interval": None}
    simulate(chain, duration=10 * float(least), method="verlet", **steps)


def test_stiff_and_light_chains_at_the_longest_step_move_as_the_exact_ones_do():
    for law, time in (({"stiffness": 1e6}, 20.0), ({"mass": 1e-4}, 200.0)):
        chain = ChainParameters(3, 10.0, **law)
        how = {"duration": time, "transient": time / 4, "sample_interval": None}
        scheme, exact = (
            simulate(chain, method=method, time_step=step, **how)
            for method, step in (("verlet", longest_step(chain)), ("event", 0.001))
        )
        assert scheme.disorder_parameter == pytest.approx(exact.disorder_parameter, rel=0.03)
        assert scheme.mean_wall_tension == pytest.approx(exact.mean_wall_tension, rel=0.01)


def test_a_viscous_chain_just_below_that_step_moves_as_the_exact_one_does():
    chain, how = ChainParameters(2, 10.0, rest_length=1000.0, viscosity=550.0), {"duration": 300.0}
    scheme, exact = (simulate(chain, method=method, **how) for method in METHODS)
    assert scheme.positions == pytest.approx(exact.positions, abs=0.01)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_contact_within_a_chunk_is_not_missed(noise, method):
    # without friction between blocks and belt that slip, they meet again and again and part again
    chain = ChainParameters(5, 500.0, noise, friction_ratio=0.0)
    message = failure(chain, duration=200, method=method)
    assert "blocks 4 and 5 meet" in message and "a longer rest_length prevents it" in message
    longer = dataclasses.replace(chain, rest_length=500.0)
    assert simulate(longer, duration=200.0, method=method).final_state.time == 200


# --- numbers that are too large ---


def test_the_exponential_is_good_to_two_units_and_overflows_instead_of_wrapping_round():
    @kernel
    def fill(x, y):
        for i in range(len(x)):
            y[i] = exp2(x[i], 1.0)

    for x in (np.linspace(-30, 30, 100001), np.linspace(1020.0, 1023.9, 101)):
        y = np.empty_like(x)
        fill(x, y)
        assert np.max(np.abs((y - np.exp2(x.astype(np.longdouble))) / np.spacing(y))) < 4
    x = np.concatenate([np.linspace(1024.5, 2100.0, 2001), [1e5, 1e300, np.inf, np.nan, 0.0]])
    y = np.empty_like(x)
    fill(x, y)
    assert not np.isfinite(y[:-1]).any() and np.isnan(y[-2]) and y[-1] == 1.0


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize("start", [3e3, 1e4, 3e4])
def test_a_start_far_out_has_no_finite_result(start, noise, method):
    chain = ChainParameters(1, 5.0, noise)
    assert failure(chain, duration=20, method=method, initial_positions=[start])


def test_a_start_without_a_finite_energy_is_refused():
    chain = ChainParameters(2, 5.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for start in ([50.0, 1e5], [50.0, 1e300]):
            with pytest.raises(InputError, match="beyond all numbers"):
                simulate(chain, duration=20, initial_positions=start, method="verlet")
        with pytest.raises(InputError, match="beyond all numbers"):
            ChainState.in_motion(chain, velocities=[1e200, 0.0])


# --- chains that hardly advance ---


def test_a_storm_names_its_own_chain_and_time():
    sound = ChainParameters(1, 5.0)
    chains = [sound] * 3 + [ChainParameters(1, 6.0)] + [sound] * 17
    positions = [chain.rest_positions for chain in chains]
    positions[3] = np.array([1e4])
    message = failure(chains, duration=250, method="event", initial_positions=positions)
    assert message.startswith("N=1, u=6, sigma=0: more than")
    assert 0 <= time_of(message) < 1e-9


# --- noise ---


def test_the_range_of_event_with_noise_ends_where_it_is_said():
    for ratio in (0.0, 0.45, 0.8, 0.95):
        chain = ChainParameters(1, 5.0, 1.0, friction_ratio=ratio)
        edge = START_NOISE / start_noise(chain)
        below, above = (dataclasses.replace(chain, noise=edge * share) for share in (0.999, 1.001))
        simulate(below, duration=5, method="event")
        simulate(above, duration=5, method="verlet")
        with pytest.raises(InputError, match=rf"^noise = {above.noise:g}: .*'verlet'$") as caught:
            simulate(above, duration=5, method="event")
        limit = float(str(caught.value).rpartition("up to ")[2].partition(";")[0])
        assert limit == pytest.approx(edge, rel=1e-3)
        simulate(dataclasses.replace(chain, noise=limit), duration=5, method="event")
    # of blocks that differ the one that slips with the least force
    share = [start_noise(ChainParameters(2, 5.0, 1.0, friction_ratio=ratio))
             for ratio in ((0.1, 0.8), 0.8)]  # fmt: skip
    assert share[0] == share[1]
    # the strongest noise of the paper
    assert start_noise(ChainParameters(5, 20.0, 10.0)) < START_NOISE


@pytest.mark.slow
@pytest.mark.parametrize("friction_ratio", [0.45, 0.8])
def test_slips_at_the_edge_of_the_range_are_as_frequent_as_in_steps(friction_ratio):
    # about 25 000 slips each; standard error of the ratio 0.3 %
    chain = ChainParameters(1, 5.0, 1.0, friction_ratio=friction_ratio)
    chain = dataclasses.replace(chain, noise=START_NOISE / start_noise(chain))
    counts = []
    for method, seed in (("verlet", 1), ("event", 2)):
        table = scan([chain] * 32, duration=1e4, method=method, seed=seed, replicate=range(32))
        counts.append(table["slip_count"].sum())
    assert counts[1] == pytest.approx(counts[0], rel=0.012)


def test_without_kinetic_friction_thresholds_are_still_drawn():
    chain = ChainParameters(1, 5.0, 5.0, friction_ratio=0.0)
    runs = [simulate(chain, duration=900, method=method) for method in METHODS]
    for run in runs:
        slips = run.events["force"][(run.events["kind"] == "slip") & (run.events["time"] > 0)]
        assert len(slips) >= 5
        assert np.std(slips) > 1.0


def test_friction_of_a_noisy_run_is_the_one_that_moves_the_blocks():
    chain = ChainParameters(3, 15.0, 5.0)
    run = simulate(chain, duration=20, method="event", sample_interval=1e-4, sample_start=10)
    force = external_force(run.positions, chain) + run.friction
    slips = (run.friction[:-1] != 0) & (np.abs(np.diff(run.friction, axis=0)) < 1e-2)
    slips &= (run.velocities[:-1] != 15.0) & (run.velocities[1:] != 15.0)
    gained = np.diff(run.velocities, axis=0)
    expected = 1e-4 * (force[1:] + force[:-1]) / 2
    assert slips.mean() > 0.5
    # the noise of a cell gives 1e-4 sqrt(q / 0.5) = 1e-5; the trapezoid is good to 1e-9
    assert np.abs((gained - expected)[slips]).max() < 2e-7


# --- r ---


@pytest.mark.parametrize("method", METHODS)
def test_r_does_not_depend_on_the_samples_that_are_kept(method):
    run_of = partial(
        simulate, ChainParameters(5, 20.0), duration=700.0, transient=100.0, method=method
    )
    runs = {h: run_of(sample_interval=h) for h in (None, 0.1, 0.2, 0.7, 7.0, 300.0)}
    for interval, run in runs.items():
        assert run.disorder_parameter == pytest.approx(runs[0.1].disorder_parameter, rel=2e-3)
        assert run.mean_length == pytest.approx(runs[0.1].mean_length, rel=1e-4)
        if interval is not None:
            expected = interval * np.arange(int(700 / interval + 1e-6) + 1)
            np.testing.assert_allclose(run.time, expected, rtol=0, atol=1e-9)
    coarse, fine = runs[7.0], runs[0.1]
    for name in ("positions", "velocities", "friction"):
        expected = getattr(fine, name)[::70]
        np.testing.assert_allclose(getattr(coarse, name), expected, rtol=0, atol=1e-6)


# --- leaps ---


@pytest.mark.parametrize("method", METHODS)
def test_too_few_samples_for_r_are_said(method):
    short = {"chains": ChainParameters(2, 5.0), "method": method}
    for lengths in ({"duration": 0.5}, {"duration": 20.0, "transient": 19.5}):
        with pytest.warns(UserWarning, match=r"r and <x_N> are NaN: the 0\.5 of model time"):
            run, table = simulate(**short, **lengths), scan(**short, **lengths)
        assert np.isnan([run.disorder_parameter, run.mean_length]).all()
        assert np.isnan([table["disorder_parameter"], table["maximum_length"]]).all()
    with pytest.warns(UserWarning, match="r and <x_N> are NaN"):
        escape = time_to_continuous_slip(**short, duration=20, settle_time=0.5)
    assert np.isnan([escape["final_disorder"], escape["final_amplitude"]]).all()
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message="r and")
        assert simulate(**short, duration=21.0, transient=20.0).disorder_parameter > 0

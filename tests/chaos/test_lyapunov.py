"""Lyapunov exponents: closed forms, twins followed by `simulate`, and errors on made-up growth."""

import dataclasses
import re
import warnings
from functools import partial

import numpy as np
import pytest
from scipy import stats

from advancing import sliding
from beltrepro import (
    ChainParameters,
    ChainState,
    Grid,
    Setup,
    classify,
    lyapunov_spectrum,
    periodic_orbit,
    time_to_continuous_slip,
)
from beltrepro.base.errors import InputError
from beltrepro.chaos.lyapunov import _mean_of_runs
from beltrepro.chaos.vectors import (
    INTERVAL,
    NO_SAMPLES,
    LaboratoryIntegrator,
    end_errors,
    grow,
    slopes,
    standard_errors,
    times_as_fast,
    with_vectors,
)
from beltrepro.engine.records import EVENT_FORCE, EVENT_TIME

EIGHT = {"replicate": range(8), "initial_spread": 1.0}


def test_one_block_has_a_limit_cycle_that_erases_all_but_the_phase():
    spectrum = lyapunov_spectrum(ChainParameters(1, 3.0), duration=4000, transient=1000, **EIGHT)
    assert spectrum.exponents.shape == spectrum.standard_error.shape == (2,)
    assert abs(spectrum.exponents[0]) < 3 * spectrum.standard_error[0] < 1e-3
    assert (spectrum.exponents[1], spectrum.standard_error[1]) == (-np.inf, 0.0)
    assert (spectrum.trivial, spectrum.erased) == (0, 1)
    assert (spectrum.nontrivial_exponent, spectrum.nontrivial_error) == (-np.inf, 0.0)
    far = dataclasses.replace(spectrum, exponents=np.array([-0.5]))
    assert far.trivial is None


@pytest.mark.parametrize(
    ("n_blocks", "belt_velocity", "noise", "duration", "trivial"),
    [
        (4, 10.0, 0.0, 20_000, 0),
        pytest.param(5, 7.0, 1.0, 24_000, 0, marks=pytest.mark.thorough),
        pytest.param(7, 10.0, 0.0, 24_000, 1, marks=pytest.mark.thorough),
        pytest.param(7, 7.0, 1.0, 24_000, 1, marks=pytest.mark.thorough),
    ],
)
def test_the_largest_exponent_is_trivial_but_for_seven_blocks(
    n_blocks, belt_velocity, noise, duration, trivial
):
    chain = ChainParameters(n_blocks, belt_velocity, noise)
    settings = {"duration": duration, "transient": 4000, "n_exponents": 3, **EIGHT}
    measured = lyapunov_spectrum(chain, **settings)
    exponents, errors = measured.exponents, measured.standard_error
    assert measured.trivial == trivial
    assert abs(exponents[trivial]) < 4 * errors[trivial] < 2e-3
    assert trivial == 0 or exponents[0] > 8 * errors[0]
    assert trivial == 0 or noise or exponents[0] == pytest.approx(0.0045, abs=4 * errors[0])
    assert exponents[trivial + 1] < -5 * errors[trivial + 1]
    limit = 4 * np.hypot(measured.nontrivial_error, errors[1 - trivial])
    assert measured.nontrivial_exponent == pytest.approx(exponents[1 - trivial], abs=limit)


def test_growth_under_noise_is_that_of_a_deviation_left_alone():
    """Five blocks that all rest at times, so that the deviation has a delay of the noise.

    What is made orthonormal must take the delay along: a deviation put back without it grows in
    another way.
    """
    chain, length = ChainParameters(5, 7.0, 1.0), 2000.0
    (member,) = Setup(chain).cases
    put_back, alone = (with_vectors([member.state], member, 2) for _ in range(2))
    growth = grow(put_back, length, [], lambda done: None)[0]
    stuck = 0
    for number in range(1, growth.shape[0] + 1):
        for _ in alone.advance(number * INTERVAL):
            pass
        stuck = max(stuck, np.sum(alone.state()[0].directions == 0))
    assert stuck == 5
    sizes = np.diagonal(np.linalg.qr(alone.deviations()[0]).R)
    assert growth.sum(axis=0) * INTERVAL == pytest.approx(np.log(np.abs(sizes)), abs=1e-6)


@pytest.mark.parametrize("mass", [1.0, 4.0])
def test_noise_of_the_laboratory_acts_on_a_deviation_at_the_end_of_the_rest_alone(mass):
    """N = 1 on the linear branch: dx = c cos wt + dv_0 / w sin wt after a slip has started.

    The second chain starts its slip later by s = -c/u, with the same force F_st and the noise eta
    of that instant. So dv_0 = -(F - k + eta) s / m, and what the noise does later leaves dx alone.
    """
    speed, threshold = 3.0, 15.0
    chain = ChainParameters(1, speed, 1.0, static_friction=threshold, mass=mass)
    accuracy = {"time_step": 0.05, "tolerance": 1e-12, "noise_share": 0.0}
    settings = {"n_vectors": 1, "sampling": NO_SAMPLES, "sampled_blocks": 1, **accuracy}
    chains = LaboratoryIntegrator([ChainState.at_rest(chain)], **settings)
    chains.set_deviations(np.array([[[1.0], [0.0], [0.0]]]))
    start, force = first_slip(chains)
    state = chains.state()[0]
    level, slope = state.scheme.variables["noise_force"][:, 0]
    noise = level - slope * (state.time - start)
    kinetic = chain.friction_ratio * threshold
    first, w = (force + kinetic + noise) / speed / mass, mass**-0.5
    assert abs(noise) > 0.01  # a million times what is compared
    for since in np.arange(0.1, 2.5, 0.2):
        for _ in chains.advance(start + since):
            pass
        turn, swing = np.cos(w * since), np.sin(w * since)
        expected = turn + first / w * swing, first * turn - w * swing
        assert chains.deviations()[0, :, 0] == pytest.approx([*expected, 0.0], abs=1e-8)
    assert chains.state()[0].directions == [-1]


def first_slip(chains):
    """Advance until a block slips; the instant, and the force on it."""
    while True:
        for chunk in chains.advance(chains.time + 0.05):
            if chunk.event_count[0]:
                return chunk.events[0, 0, EVENT_TIME], chunk.events[0, 0, EVENT_FORCE]


def test_all_exponents_of_continuous_slip_are_finite_zero_and_sum_to_nothing():
    """Between events the motion is Hamiltonian, so the volume is kept."""
    chain = ChainParameters(3, 60.0)
    spectrum = lyapunov_spectrum(
        [chain], duration=3000, initial_state=sliding(chain, np.array([0.5, -1.0, 1.5]))
    )
    assert spectrum["most_stuck"] == [0]
    assert np.all(np.isfinite(spectrum["exponents"]))
    assert spectrum["growth"].mean(axis=1).sum() == pytest.approx(0.0, abs=1e-7)
    assert np.abs(spectrum["exponents"]).max() < 5e-3


@pytest.mark.parametrize(
    ("n_blocks", "viscosity"), [(1, 0.5), (1, 3.0), (3, 0.0), (3, 0.5), (3, 5.0)]
)
def test_exponents_of_steady_slip_are_the_eigenvalues_of_linear_motion(n_blocks, viscosity):
    """x'' = -K x - eta x': series of the motion, which is at rest, tell nothing of deviations."""
    chain = ChainParameters(n_blocks, 20.0, viscosity=viscosity, linear_limit=np.inf)
    begin, one = sliding(chain, np.zeros(n_blocks)), np.eye(n_blocks)
    deformation = one - np.eye(n_blocks, k=-1)
    linear = np.block([[0 * one, one], [-deformation.T @ deformation, -viscosity * one]])
    spectrum = lyapunov_spectrum(chain, duration=3000, transient=500, initial_state=begin)
    expected = np.sort(np.linalg.eigvals(linear).real)[::-1]
    assert spectrum.exponents == pytest.approx(expected, abs=1e-4)
    assert (spectrum.trivial is None) == (viscosity > 0)
    assert spectrum.nontrivial_exponent == pytest.approx(expected[0], abs=1e-4)


def test_a_light_chain_has_the_exponents_of_a_slow_one():
    """Of a mass of 1e-4 all times are 1/100: in 20 time units rounding hides the last exponent."""
    slow, light = (
        lyapunov_spectrum(chain, duration=6000 * unit, transient=1000 * unit).exponents * unit
        for chain, unit in (
            (ChainParameters(3, 10.0), 1.0),
            (ChainParameters(3, 1000.0, mass=1e-4), 0.01),
        )
    )
    assert np.isfinite(slow).sum() == 3
    assert light == pytest.approx(slow, abs=4e-3)


def test_noise_shifts_with_the_chain_only_through_a_rest():
    settings = {"duration": 3000, "transient": 500, "n_exponents": 2, "replicate": range(4)}
    spectrum = lyapunov_spectrum(ChainParameters(10, 60.0, 1.0), **settings, initial_spread=1.0)
    assert spectrum.trivial is None
    assert np.all(spectrum.most_stuck < 10)
    assert np.all(np.isfinite(spectrum.exponents))
    assert np.ptp(spectrum.runs[:, 0]) > 0
    limit = 4 * np.hypot(spectrum.nontrivial_error, spectrum.standard_error[0])
    assert spectrum.nontrivial_exponent == pytest.approx(spectrum.exponents[0], abs=limit)
    resting = lyapunov_spectrum(ChainParameters(1, 3.0, 1.0), **settings)
    assert resting.trivial == 0
    assert np.all(resting.most_stuck == 1)
    assert abs(resting.exponents[0]) < 4 * resting.standard_error[0] < 5e-3
    assert np.ptp(resting.runs[:, 0]) > 0  # the noise differs
    assert resting.nontrivial_exponent == -np.inf


def test_by_the_clock_of_the_laboratory_no_exponent_under_noise_is_trivial():
    settings = {"duration": 3000, "transient": 500, "noise_clock": "laboratory"}
    chains = [ChainParameters(1, 3.0, 1.0), ChainParameters(5, 7.0, 1.0)]
    spectra = lyapunov_spectrum(chains, **settings)
    assert spectra["nontrivial_exponent"] == pytest.approx(spectra["exponents"][:, 0], rel=1e-6)


@pytest.mark.parametrize(
    ("n_blocks", "velocity", "lengths"),
    [(2, 5.0, (4000, 1000)), (3, 10.0, (6000, 2000)), (5, 18.0, (8000, 4000))],
)
def test_the_nontrivial_exponent_of_an_orbit_is_that_of_its_multiplier(n_blocks, velocity, lengths):
    """log|mu| / T of the eigenvalues of the monodromy matrix, which no vector is followed for."""
    chain, (duration, transient) = ChainParameters(n_blocks, velocity), lengths
    orbit = periodic_orbit(chain, duration=duration, transient=transient)
    start = {"initial_state": orbit.state}
    spectrum = lyapunov_spectrum(chain, duration=duration, transient=transient, **start)
    motion = classify(chain, duration=duration, transient=transient, **start)
    assert orbit.exponent < -1e-3
    for found in (spectrum, motion):
        assert found.nontrivial_exponent == pytest.approx(orbit.exponent, rel=0.01, abs=1e-4)
    assert (motion.state, motion.erased) == ("periodic", orbit.erased)
    assert spectrum.most_stuck.tolist() == [orbit.erased]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"n_exponents": 0}, "n_exponents = 0: allowed are 1 to 2N = 8"),
        ({"n_exponents": 9}, "n_exponents = 9: allowed are 1 to 2N = 8"),
        ({"method": "verlet"}, "method = 'verlet': only 'event' has a tangent dynamics"),
        ({"initial_spread": 0}, "replicate: some runs would be the same; each needs another one"),
        ({"noise_clock": "wall"}, "noise_clock = 'wall': allowed are rest, laboratory"),
        ({"replicate": [1, 1]}, "replicate: some runs would be the same; each needs another one"),
    ],
)
def test_bad_input_is_one_line(changes, message):
    settings = {"duration": 10, **EIGHT} | changes
    with pytest.raises(InputError) as caught:
        lyapunov_spectrum(ChainParameters(4, 10.0), **settings)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_runs_of_several_motions_are_told(recwarn):
    """By errors they differ where they move along two orbits, and not in chaos."""
    settings = {"replicate": range(8), "initial_spread": 1, "transient": 500, "n_exponents": 1}
    lyapunov_spectrum(ChainParameters(5, 5.0), duration=1500, **settings)
    assert not recwarn
    message = "runs differ by more than their errors: nontrivial exponents from -0.0772 ± 0.00"
    with pytest.warns(UserWarning, match=message):
        lyapunov_spectrum(ChainParameters(3, 12.0), duration=3000, **settings)
    settings.pop("replicate")
    several = lyapunov_spectrum(Grid(3, 12.0, replicates=8), duration=3000, **settings)
    assert (
        several["nontrivial_exponent"].min() < -0.07 < several["nontrivial_exponent"].max() - 0.04
    )


def test_a_run_whose_motion_changes_is_told_and_others_are_not(recwarn):
    """Two blocks under noise settle on an orbit for some time: -0.12 in one half, -0.03 later."""
    settings = {"duration": 2200, "transient": 200, "initial_spread": 1, "n_exponents": 1}
    for replicate in range(3):
        lyapunov_spectrum(ChainParameters(5, 5.0, noise=2), replicate=replicate, **settings)
    assert not recwarn
    with pytest.warns(UserWarning, match="halves of the run differ by more than their errors: non"):
        lyapunov_spectrum(ChainParameters(2, 3.0, noise=1.0), replicate=2, **settings)


@pytest.mark.parametrize("duration", [600, 1500])
@pytest.mark.parametrize(
    "called", [classify, partial(lyapunov_spectrum, n_exponents=1), time_to_continuous_slip]
)
def test_numbers_of_chains_that_still_load_are_told_with_advice_that_helps(called, duration):
    """Twenty blocks at u = 5 take 600 to their balance; r is 0.04 afterwards."""
    late = called is time_to_continuous_slip
    lengths = {"settle_time": duration - 100} if late else {"transient": 100}
    lengths["duration"] = duration
    with pytest.warns(UserWarning, match="loading is measured too") as caught:
        called(ChainParameters(20, 5.0), **lengths)
    advice = re.findall(r"(transient|settle_time|duration)=(\d+)", str(caught[0].message))
    with warnings.catch_warnings(action="error"):
        called(ChainParameters(20, 5.0), **lengths | {name: float(time) for name, time in advice})
        called(ChainParameters(3, 10.0), **lengths)


def test_loading_before_an_orbit_is_no_matter():
    with warnings.catch_warnings(action="error"):
        classify(ChainParameters(3, 10.0), duration=2000, transient=5)


def autoregressive(runs, length, mean, memory, seed):
    random = np.random.default_rng(seed)
    noise = random.standard_normal((runs, length + 100))
    values = np.zeros_like(noise)
    for k in range(1, length + 100):
        values[:, k] = memory * values[:, k - 1] + noise[:, k]
    return mean + values[:, 100:, None]


@pytest.mark.parametrize("memory", [0.0, 0.6, -0.5])
def test_errors_cover_the_exponent_of_correlated_growth(memory):
    """z-scores of 2000 runs with known mean; Student's t of 31 batches leaves 5.4 % beyond 2."""
    growth = autoregressive(2000, 1280, 0.7, memory, seed=4)
    z = (slopes(growth) - 0.7) / standard_errors(growth)
    assert abs(z.mean()) < 4 / np.sqrt(2000)
    assert 0.03 < np.mean(np.abs(z) > 2) < 0.09
    assert 0.9 < z.std() < 1.15


@pytest.mark.parametrize("runs", [3, 8])
def test_the_error_of_a_mean_of_few_runs_covers_its_scatter(runs):
    """z-scores of 1000 studies whose runs differ beyond their own errors: Student's t."""
    random = np.random.default_rng(runs)
    z = []
    for _ in range(1000):
        growth = 0.7 + random.standard_normal((runs, 1, 1)) + np.zeros((runs, 20, 1))
        mean, error = _mean_of_runs(growth, standard_errors(growth))
        z.append((mean[0] - 0.7) / error[0])
    limit = stats.t(runs - 1).ppf(0.975)
    assert 0.03 < np.mean(np.abs(z) > limit) < 0.07
    # a direction that one run erases is erased; a single run keeps its own error
    growth = np.array([[[0.1, -np.inf]], [[0.3, 0.2]], [[0.2, 0.1]]])
    mean, error = _mean_of_runs(growth, np.ones((3, 2)))
    assert mean[1] == -np.inf and error[1] == 0.0 and mean[0] == pytest.approx(0.2)
    assert _mean_of_runs(growth[1:2], np.ones((1, 2)))[1].tolist() == [1.0, 1.0]


def test_the_error_about_a_line_is_that_of_its_slope():
    """Sums that scatter about their line by themselves, of any unit: by 3000 slopes."""
    growth = np.diff(5 * np.random.default_rng(3).normal(size=(3000, 101, 1)), axis=1)
    assert end_errors(growth).mean() == pytest.approx(slopes(growth).std(), rel=0.06)


@pytest.mark.parametrize("duration", [3000, 3700, 5000])
def test_the_error_of_one_slow_block_whose_batches_begin_at_one_phase(duration):
    """Each rest of all blocks erases all but the phase: exponent 0, by the symmetry of time."""
    spectrum = lyapunov_spectrum(ChainParameters(1, 0.1), duration=duration, transient=1000)
    assert 0 < abs(spectrum.exponents[0]) < 2 * spectrum.standard_error[0]
    assert spectrum.standard_error[0] < 1e-3


@pytest.mark.parametrize(
    ("law", "times"),
    [({}, 1), ({"mass": 100.0}, 1), ({"mass": (4.0, 0.25)}, 2), ({"stiffness": (9.0, 1.0)}, 3),
     ({"viscosity": 2.5}, 3), ({"viscosity": 1.5, "mass": 0.5}, 3)],
)  # fmt: skip
def test_vectors_are_made_orthonormal_as_often_as_the_fastest_rate_asks(law, times):
    assert times_as_fast(ChainParameters(2, 10.0, **law)) == times

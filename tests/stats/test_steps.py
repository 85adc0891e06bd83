"""The tolerance of an integrator, and the steps it allows: against an oscillator, a plain loop."""

from itertools import pairwise

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.special import factorial

import exact
from beltrepro import ChainParameters, simulate
from beltrepro.base.errors import InputError
from beltrepro.replication.studies.integrators import steps
from beltrepro.simulation import TOLERANCES


def test_series_of_one_linear_spring_is_that_of_an_oscillator():
    """x'' = friction - x: the force has the derivatives of a sine."""
    chain = ChainParameters(1, 20.0)
    series = steps.force_series(np.array([[55.0]]), np.array([[3.0]]), chain)[:, 0, 0]
    acceleration = 0.45 * 71.4 - 5.0  # slower than the belt, so friction pulls with it
    derivatives = [-5.0, *np.resize([-3.0, -acceleration, 3.0, acceleration], steps.FORCE_ORDER)]
    np.testing.assert_allclose(series * factorial(np.arange(series.size)), derivatives)


def test_series_are_those_of_a_plain_loop():
    chain, stretch = ChainParameters(4, 7.0), np.array([1.0, 24.0, -35.0, 24.0])
    positions = chain.rest_positions + np.cumsum(stretch)
    velocities = np.array([3.0, 7.0, -4.0, 20.0])
    relative = velocities - 7.0
    state = (values.tolist() for values in (np.cumsum(stretch), relative, np.sign(relative)))
    twin = exact.ExactChain.of(7.0, *state)
    _, rows, _ = exact._series(twin)  # of 40 digits
    terms = [row[: steps.FORCE_ORDER + 1] for row in rows[1:]]
    expected = np.array([[float(exact.real(term)) for term in row] for row in terms]).T
    forces = steps.force_series(positions[None], velocities[None], chain)[:, 0]
    np.testing.assert_allclose(forces, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


def test_mean_step_is_the_time_of_slip_over_the_number_of_steps():
    chain = ChainParameters(1, 20.0)
    at, v = np.array([[55.0], [60.0], [70.0]]), np.array([[3.0], [-4.0], [20.0]])  # the last: stuck
    terms = np.abs(steps.force_series(at, v, chain)[-2:, :2, 0])
    before, last = (1e-6 / terms) ** (1 / np.array([[steps.FORCE_ORDER - 1], [steps.FORCE_ORDER]]))
    allowed = np.minimum(before, last)
    assert steps.mean_step(at, v, chain, 1e-6) == pytest.approx(2 / np.sum(1 / allowed))
    assert np.isnan(steps.mean_step(at[2:], v[2:], chain, 1e-6))


def test_order_of_the_steps_is_that_of_the_series():
    """x'' = -x in 50 digits by steps of this rule; for long ones the order is half a unit more."""
    with mp.workdps(50):
        results = [oscillation(mpf(10) ** -exponent, duration=30) for exponent in (24, 28, 32)]
    errors, lengths = np.array(results, dtype=float).T
    slopes = np.diff(np.log(errors)) / np.diff(np.log(lengths))
    np.testing.assert_allclose(slopes, steps.FORCE_ORDER + 1, atol=0.2)


def oscillation(tolerance, duration):
    """Error at the end and mean length of the steps, amplitude 60."""
    position, velocity, time, count = mpf(60), mpf(0), mpf(0), 0
    while time < duration:
        series = [position, velocity]
        for k in range(steps.FORCE_ORDER + 1):
            series.append(-series[k] / ((k + 1) * (k + 2)))
        step = duration - time
        for k in (steps.FORCE_ORDER - 1, steps.FORCE_ORDER):
            if series[k]:
                step = min(step, (tolerance / abs(series[k])) ** (mpf(1) / k))
        position = sum(x * step**k for k, x in enumerate(series))
        velocity = sum(k * x * step ** (k - 1) for k, x in enumerate(series[1:], start=1))
        time, count = time + step, count + 1
    exact = 60 * mp.cos(duration), -60 * mp.sin(duration)
    return mp.hypot(position - exact[0], velocity - exact[1]), duration / count


def test_tolerance_reaches_the_integrator():
    def run(tolerance):
        return simulate(ChainParameters(2, 20.0), duration=30, method="event", tolerance=tolerance)

    chosen, same, tight = run(None), run(TOLERANCES["event"]), run(1e-14)
    assert chosen.tolerance == same.tolerance == TOLERANCES["event"] and tight.tolerance == 1e-14
    np.testing.assert_array_equal(chosen.positions, same.positions)
    printed = [run(tolerance) for tolerance in (1e-1, 1e-3, 1e-5, 1e-7)]
    errors = [np.abs(one.positions - tight.positions).max() for one in printed]
    assert all(coarse > 20 * fine > 0 for coarse, fine in pairwise(errors))
    lengths = [
        steps.mean_step(one.positions, one.velocities, one.parameters, one.tolerance)
        for one in printed
    ]
    exponent = np.diff(np.log(lengths)) / np.log(1e-2)
    assert np.all((exponent > 1 / steps.FORCE_ORDER) & (exponent < 1 / (steps.FORCE_ORDER - 1)))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"method": "verlet", "tolerance": 1e-10}, "method 'verlet' has none, only event"),
        ({"method": "event", "tolerance": 0}, "tolerance = 0: must be at least 1e-16"),
        ({"method": "event", "tolerance": 1.5}, "tolerance = 1.5: must be at least 1e-16"),
        ({"method": "event", "tolerance": float("nan")}, "tolerance = nan: a finite number"),
    ],
)
def test_tolerance_is_refused_in_one_line(settings, words):
    with pytest.raises(InputError) as caught:
        simulate(ChainParameters(2, 20.0), duration=1, **settings)
    assert words in str(caught.value) and "\n" not in str(caught.value)

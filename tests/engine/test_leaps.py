"""The scheme in leaps: the same numbers as step by step."""

import numpy as np
import pytest

from advancing import at_rest, integrator, recorded
from beltrepro import ChainParameters, simulate, slipping_state
from beltrepro.engine import verlet_integrator
from beltrepro.engine.verlet_integrator import VerletIntegrator


def verlet(chains, *, literal=None, spread=0.3, section=0.9, **settings):
    rest, n_blocks = chains[0].rest_positions, chains[0].n_blocks
    deviates = np.random.default_rng(3).standard_normal((len(chains), n_blocks))
    # balanced by kinetic friction the chain is longer than at rest
    level = section * rest[-1] + 0.64 * 71.4 * 0.45 * n_blocks * (n_blocks + 1) / 2
    states = at_rest(chains, rest + spread * deviates)
    settings |= {"literal": literal, "section": (n_blocks, level)}
    return integrator(VerletIntegrator, states, **settings)


def assert_same(chains, duration, atol, **settings):
    """Both ways give the same events at the same steps, and all else within `atol`."""
    steps = recorded(verlet(chains, literal=True, **settings), duration)
    leaps = recorded(verlet(chains, literal=False, **settings), duration)
    for one, other in zip(leaps, steps, strict=True):
        np.testing.assert_array_equal(one[0][:, :3], other[0][:, :3])
        # losses grow to some thousands; the force follows a position where springs are stiff
        np.testing.assert_allclose(one[0][:, 3:], other[0][:, 3:], rtol=1e-9, atol=100 * atol)
        np.testing.assert_allclose(one[1], other[1], rtol=0, atol=100 * atol)
        for column, bound in enumerate((atol, 10 * atol, 1e-14)):
            np.testing.assert_allclose(one[2][:, column], other[2][:, column], rtol=0, atol=bound)
        assert one[3] == pytest.approx(other[3], abs=1e-8)
    return steps


@pytest.mark.parametrize(
    ("n_blocks", "duration", "least_events"),
    [(1, 200, 500), (2, 100, 400), (5, 60, 500), (10, 40, 500)],
)
def test_leaps_are_the_steps(n_blocks, duration, least_events):
    chains = [ChainParameters(n_blocks, float(u)) for u in np.linspace(1, 45, 16)]
    # displacements: the scheme in other words, times what chaos makes of it
    steps = assert_same(chains, duration, 2e-8)
    assert sum(len(chain[0]) for chain in steps) > least_events
    assert n_blocks > 2 or sum(len(chain[1]) for chain in steps) > 20


@pytest.mark.parametrize(
    ("n_blocks", "law", "settings"),
    [
        # so little friction that a block often turns where |F_ex| > F_st
        (3, {"static_friction": 3.05}, {"time_step": 0.0005}),
        (3, {"static_friction": 3.05}, {}),
        # with a short linear branch, springs pass its ends all the time
        (4, {"static_friction": 30.0, "linear_limit": 2.0}, {"stride": 10}),
        # springs stretched by far more than friction holds, every sample taken
        (3, {}, {"spread": 8.0, "stride": 1}),
    ],
)
def test_leaps_are_the_steps_under_other_laws_and_starts(n_blocks, law, settings):
    chains = [ChainParameters(n_blocks, float(u), **law) for u in range(8, 24)]
    steps = assert_same(chains, 5 if "spread" in settings else 30, 2e-8, **settings)
    if law.get("static_friction") == 3.05:
        again = [np.all(rows[1:, :2] == rows[:-1, :2], axis=1).sum() for rows, *_ in steps]
        assert sum(again) > 20  # reversals


def test_what_leaps_neglect_is_of_fourth_order(monkeypatch):
    monkeypatch.setattr(verlet_integrator, "_IMPACT_LIMIT", np.inf)
    # dt^4/240 a'''': far above rounding at these time steps, far below it at the paper's
    chains = [ChainParameters(5, float(u)) for u in np.linspace(20, 45, 16)]
    errors = []
    for time_step in (0.016, 0.008, 0.004):
        stride = round(0.08 / time_step)
        states = [
            recorded(verlet(chains, literal=literal, time_step=time_step, stride=stride), 8.0)
            for literal in (True, False)
        ]
        errors.append([np.abs(a[2][:, 0] - b[2][:, 0]).max() for a, b in zip(*states, strict=True)])
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(np.median(orders, axis=1), 4, atol=0.2)
    assert np.median(errors[-1]) < 1e-7


def test_noise_and_long_steps_go_step_by_step():
    def name(*chains, **settings):
        return verlet(list(chains), **settings).name

    quiet, noisy = ChainParameters(3, 5.0), ChainParameters(3, 5.0, 1.0)
    stiff = ChainParameters(3, 5.0, compression_rate=2.0)
    assert name(quiet) == "leaping verlet"
    assert {name(quiet, noisy), name(quiet, time_step=0.002), name(stiff)} == {"literal verlet"}


def test_blocks_draw_noise_of_their_own_step_by_step():
    chain = ChainParameters(4, 40.0, 5.0)
    run = simulate(
        chain,
        duration=300,
        transient=100,
        method="verlet",
        initial_state=slipping_state(chain, 1e-3),
    )
    correlations = np.corrcoef(run.friction.T)[np.triu_indices(4, 1)]
    assert np.abs(correlations).max() < 0.1  # of 2000 samples


def test_leaps_are_the_steps_where_impacts_compress_springs_further():
    # beyond what friction can hold: slopes to 200, where leaps alone would be off by 6e-7
    chains = [ChainParameters(1, u) for u in (120.0, 100.0, 90.0)]
    steps = assert_same(chains, 20.0, 1.5e-7, stride=10)
    # displacement: how far the spring is compressed
    assert all(samples[:, 0].min() < -40 for _, _, samples, *_ in steps)

"""Claim on the numerical method, by made-up points of both integrators with a known answer."""

import numpy as np
import pytest

from beltrepro.replication.verdicts.criteria import IN_PART, NO, OPEN, YES
from made_up import both, measured, scan

U = np.linspace(5, 45, 30)
NAMES = {1.0: ("pairs_r_verlet", "pairs_r_event"), 0.0: ("n5_replicates_check", "n5_replicates")}


def pair(noise, *, differing=0, factor=1.3, scatter=0.02, replicates=12, seed=1):
    """Points by both methods; at some of them r of `event` is larger by a factor."""
    rng = np.random.default_rng(seed)
    mean = 0.1 * np.where(np.arange(U.size) < differing, factor, 1.0)

    def runs(mean, method):
        noisy = np.repeat(mean, replicates) * np.exp(
            scatter * rng.standard_normal(U.size * replicates)
        )
        return scan(5, np.repeat(U, replicates), noisy, noise=noise, method=method)

    datasets = runs(np.full(U.size, 0.1), "verlet"), runs(mean, "event")
    return dict(zip(NAMES[noise], datasets, strict=True))


@pytest.mark.parametrize(
    ("noisy", "quiet", "verdicts"),
    [
        ({}, {}, (YES, YES)),
        ({"differing": 20}, {}, (NO, IN_PART)),
        ({}, {"differing": 20}, (YES, IN_PART)),
        ({}, {"differing": 3}, (YES, OPEN)),
        ({"differing": 20}, {"differing": 20, "seed": 2}, (NO, NO)),
        ({"differing": 20, "factor": 1.05}, {}, (YES, YES)),  # not to be seen in a figure
        ({"scatter": 1.0}, {"scatter": 1.0}, (YES, YES)),  # chance is no difference
    ],
)
def test_both_methods_agree(noisy, quiet, verdicts):
    assert both("method-independence", **pair(1.0, **noisy), **pair(0.0, **quiet)) == verdicts


def test_the_shift_is_event_over_scheme_and_noise_is_kept_apart():
    made = pair(1.0, differing=30, factor=1.2) | pair(0.0, differing=30, factor=0.5)
    numbers = measured("method-independence", "with and without noise", **made).also
    assert numbers["mean shift, with noise"].value == pytest.approx(np.log(1.2), abs=0.01)
    assert numbers["mean shift, without noise"].value == pytest.approx(np.log(0.5), abs=0.01)


def test_long_runs_at_the_edges_count_beside_the_short_ones_at_the_same_points():
    short, long = pair(1.0), pair(1.0, differing=30, seed=2)
    edge = dict(zip(("n5_edge", "n5_replicates"), long.values(), strict=True))
    u7 = dict(zip(("n5_u7_check", "n5_u7"), pair(1.0, seed=3).values(), strict=True))
    alone = measured("method-independence", **short).judged["points that differ, with noise"]
    both_sets = measured("method-independence", **short, **edge, **u7)
    every = both_sets.judged["points that differ, with noise"]
    assert (alone.runs, alone.value) == (30, 0) and every.runs == 90
    assert every.value == pytest.approx(1 / 3)  # not mixed with the short ones at the same u
    shift = both_sets.also["mean shift, with noise"].value
    assert shift == pytest.approx(np.log(1.3) / 3, abs=0.01)

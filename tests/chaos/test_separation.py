"""Twins that begin close together: against `simulate`, and exponents of the tangent dynamics."""

from dataclasses import replace

import numpy as np
import pytest
from beltrepro.stats.growth import finite_size_exponents

from beltrepro import ChainParameters, lyapunov_spectrum, separation, simulate
from beltrepro.base.errors import InputError
from beltrepro.chaos.parting import _moved
from beltrepro.replication.plan.kinds import KINDS, record
from beltrepro.replication.plan.points import QUANTITIES, Point

SEVEN = ChainParameters(7, 10.0)


@pytest.mark.parametrize("how", [{"method": "event"}, {"method": "verlet", "time_step": 0.001}])
def test_times_are_those_of_two_runs_of_simulate(how):
    partings = separation(
        SEVEN, duration=900, transient=500, distances=[1e-3], levels=[1e-3, 1e-2, 0.05, 1e5], **how
    )
    before = simulate(SEVEN, duration=500, **how)
    first = replace(before.final_state, scheme=None)
    runs = [
        simulate(SEVEN, duration=400, initial_state=state, sample_interval=0.1, **how)
        for state in (first, _moved(first, 1e-3))
    ]
    apart = np.abs(runs[1].positions - runs[0].positions).max(axis=1)
    times = partings["passage_time"][0, 0]
    assert times[0] == 0
    for level, time in zip(partings["levels"][1:3], times[1:3], strict=True):
        later = runs[0].time[1:][apart[1:] > level]
        assert time == pytest.approx(later[0] - 500.0, abs=1e-9)
    assert np.isnan(times[3])


@pytest.mark.thorough
def test_small_distances_grow_with_the_largest_exponent():
    runs = {"replicate": range(1, 33), "initial_spread": 10.0}
    levels = np.geomspace(1e-12, 1e-3, 10)
    partings = separation(
        [SEVEN] * 32, duration=11_000, transient=1000, distances=[1e-12], levels=levels, **runs
    )
    growth = finite_size_exponents(levels, partings["passage_time"][:, 0], 10_000)
    expected = lyapunov_spectrum(
        [SEVEN] * 32, duration=11_000, transient=1000, n_exponents=1, **runs
    )
    largest = expected["exponents"][:, 0]
    small = slice(3, None)  # a twin first turns to the direction in which it grows
    apart = growth.exponent[small] - largest.mean()
    error = np.hypot(growth.standard_error[small], largest.std(ddof=1) / np.sqrt(32))
    assert np.abs(apart / error).max() < 4
    assert np.all(growth.standard_error[small] < 0.5 * growth.exponent[small])


def test_the_scheme_in_steps_holds_small_distances_back():
    """Both twins slip in the same steps, unless a distance lets one of them be a step late."""
    runs = {"replicate": range(1, 9), "initial_spread": 10.0, "distances": [1e-9, 0.1]}
    options = {"duration": 3000, "transient": 1000, **runs}
    exact = separation([SEVEN] * 8, **options)["passage_time"]
    steps = separation([SEVEN] * 8, method="verlet", **options)["passage_time"]
    grown = [np.isfinite(times[:, 0]).sum(axis=1) - 1 for times in (exact, steps)]
    assert grown[0].min() >= 3  # half-decades
    assert grown[1].max() <= 1
    assert np.isfinite(steps[:, 1, -1]).sum() > 4


def test_levels_below_a_distance_have_no_time():
    partings = separation(SEVEN, duration=30, transient=10, distances=[1e-6, 1e-3])
    levels, times = partings["levels"], partings["passage_time"]
    assert times.shape == (1, 2, len(levels))
    assert levels[0] == pytest.approx(1e-6) and levels[-1] == pytest.approx(10.0)
    assert np.isnan(times[0, 1, levels < 0.99e-3]).all()
    assert times[0, :, [0, 6]].diagonal().tolist() == [0.0, 0.0]


def test_a_twin_is_moved_by_the_distance_and_stays_stuck_where_it_was():
    state = simulate(SEVEN, duration=300, method="event").final_state
    twin = _moved(state, 1e-3)
    moved = np.abs(twin.displacements - state.displacements)
    assert moved.max() == pytest.approx(1e-3, rel=1e-9)
    assert moved.min() > 0
    assert np.array_equal(twin.directions, state.directions)
    assert np.array_equal(twin.relative_velocities, state.relative_velocities)


def test_twins_meet_the_same_noise_and_kicks():
    """Chains of one block forget how they began, so under the same noise they meet again."""
    options = {"duration": 2000, "transient": 100, "distances": [1e-6], "levels": [1e-6, 1.0]}
    for noise, kick in ((1.0, 0.0), (0.0, 0.1)):
        partings = separation(ChainParameters(1, 3.0, noise), kick=kick, **options)
        assert np.isnan(partings["passage_time"][0, 0, 1])


def test_kind_records_what_it_says():
    values = {name: one.default for name, one in QUANTITIES.items()}
    point = Point(**values | {"n_blocks": 7, "belt_velocity": 10.0, "method": "event"})
    points = [point, point._replace(n_blocks=5, kick=0.1)]
    settings = {"duration": 30.0, "transient": 10.0, "distances": [1e-6, 1e-3]}
    arrays = record("separation", points, settings)
    kind = KINDS["separation"]
    assert set(arrays) == set(kind.arrays)
    assert all(arrays[one.name].ndim == len(one.dimensions) for one in kind.recorded)
    assert arrays["passage_time"].shape == (2, 2, len(arrays["levels"]))


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"distances": [0.0]}, "distances = 0: must be greater than 0"),
        ({"distances": [300.0]}, "distances = 300: blocks of a twin would be beyond each other"),
        ({"levels": [1.0]}, "levels = "),
        ({"levels": [1.0, 0.5]}, "levels = "),
    ],
)
def test_wrong_values_are_named(wrong, words):
    with pytest.raises(InputError, match=words) as caught:
        separation(SEVEN, **{"duration": 20.0, "transient": 10.0} | wrong)
    assert "\n" not in str(caught.value)

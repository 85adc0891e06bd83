"""Claims on the model and its scheme: forces, series and paths with a known answer."""

import math

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.model import ChainParameters, spring
from beltrepro.replication.studies.laws import measure
from beltrepro.replication.verdicts.criteria import IN_PART, NO, NOT_TESTABLE, OPEN, YES
from made_up import LAW, LEDGER, SETTINGS, both, few_resamples, grades, measured, scan_of_laws  # noqa: F401

# --- what is put in -------------------------------------------------------------------------------


def parts(name, /, **datasets):
    """Verdicts on the numbers of a claim, by name."""
    return {part: grade for part, grade in grades(name, **datasets).items() if part}


def test_units_and_constants_hold_and_are_counted_apart():
    for name in ("units", "friction-constants", "spring-law", "setup"):
        assert both(name) == (YES, YES) and not LEDGER[name].finding
    used = SETTINGS | {"model": LAW | {"friction_ratio": 0.46}}
    graded = grades("friction-constants", settings=used)
    assert graded.pop("") == IN_PART
    assert [name for name, grade in graded.items() if grade == NO] == [
        "the runs used friction_ratio = 0.45"
    ]


@pytest.mark.parametrize(
    ("change", "failing"),
    [
        (lambda x, force: force - 1e-4 * (abs(x) < 20) * x, {"linear inside"}),
        (lambda x, force: force * np.where(x < -20, 1 + 0.001 * x, 1), {"compressed"}),
        (lambda x, force: force + 1e-3 * (x > 20), {"continuous, stretched"}),
        (lambda x, force: force - 0.01 * np.maximum(x - 20, 0), {"continuous slope, stretched"}),
        (lambda x, force: force - 1e-3 * np.maximum(x - 20, 0) ** 2, {"exponential, stretched"}),
    ],
)
def test_another_spring_law_is_noticed(monkeypatch, change, failing):
    chosen = spring.spring_force
    monkeypatch.setattr(spring, "spring_force", lambda x, chain: change(x, chosen(x, chain)))
    graded = parts("spring-law")
    fails = {name for name, grade in graded.items() if grade == NO}
    assert len(graded) == 7 and fails
    assert all(any(word in name for name in fails) for word in failing)


def test_the_springs_of_a_chain_with_another_scheme_are_noticed(monkeypatch):
    chosen = spring.external_force

    def with_(change):
        monkeypatch.setattr(spring, "external_force", lambda x, c: change(x, chosen(x, c)))
        return [grade == YES for grade in parts("setup").values()]

    assert with_(lambda x, force: force + 1.0) == [0, 0, 0]
    rest = ChainParameters(5, 1.0).rest_positions
    # a spring from the last block to a wall; one from the first to the third block
    assert with_(lambda x, force: force - np.eye(5)[4] * (x - rest)[4]) == [1, 0, 0]
    assert with_(lambda x, force: force + 0.1 * np.eye(5)[2] * (x - rest)[0]) == [1, 1, 0]


NOISE = 5.0


def friction_series(
    *, shift=0.0, spread=1.0, imbalance=0.0, rarely=1, memory=0.0, before=71.4, size=8000
):
    """Imbalance of the stuck blocks in one sample of so many."""
    rng = np.random.default_rng(0)
    chain = ChainParameters(2, 1.0, noise=NOISE)
    slipping = np.arange(size) % 200 >= 100
    positions = chain.rest_positions + rng.uniform(-5, 5, (size, 2))
    drawn = rng.standard_normal((size, 2))
    for index in range(1, size):
        drawn[index] = memory * drawn[index - 1] + math.sqrt(1 - memory**2) * drawn[index]
    kinetic = 0.45 * 71.4 * (1 + shift) + 0.45 * NOISE * spread * drawn
    stuck = -spring.external_force(positions, chain)
    stuck[::rarely] += imbalance
    kinds = [("kind", "U5"), ("force", "f8")]
    arrays = {
        "positions": positions,
        "velocities": np.where(slipping[:, None], -20.0, 1.0) * np.ones(2),
        "friction": np.where(slipping[:, None], kinetic, stuck),
        "events": np.array([("slip", -before), ("stick", 0), ("slip", before)], dtype=kinds),
    }
    about = {"n_blocks": 2, "belt_velocity": 1.0, "noise": NOISE}
    return {"friction_event": Dataset(arrays, about)}


@pytest.mark.parametrize(
    ("change", "failing"),
    [
        ({}, None),
        ({"imbalance": 0.75}, 0),
        ({"imbalance": 0.75, "rarely": 30}, 0),
        ({"shift": 0.013}, 1),
        ({"spread": 1.25}, 2),
        ({"memory": 0.2}, 3),
        ({"before": 47.0}, 4),
    ],
)
def test_the_friction_law_is_read_off_the_samples(change, failing):
    made = friction_series(**change)
    right = [grade == YES for grade in parts("friction-law", **made).values()]
    assert right == [number != failing for number in range(5)]
    assert measured("friction-law", **made).judged["slip: mean / (f_s F_st0)"].runs == 20


def test_the_chain_length_is_that_of_the_runs_nearest_in_speed():
    made = scan_of_laws([11, 12, 15, 15.5], lambda u, rng: 0.1, noise=1.0)
    length = {11: 1.0, 12: 600.0, 15: 1.0, 15.5: 650.0}
    made.arrays["mean_length"] = np.array([length[u] for u in made.arrays["belt_velocity"]])
    assert both("chain-length", n5_replicates=made) == (NOT_TESTABLE, NOT_TESTABLE)
    lengths = measured("chain-length", n5_replicates=made).also
    assert [length.value for length in lengths.values()] == pytest.approx([0.84, 0.91])
    assert list(lengths) == ["0.22 m/s", "0.28 m/s"]


# --- collisions -----------------------------------------------------------------------------------


def sampled(smallest, method="verlet", *, size=4000, seed=0):
    """Distances of three blocks of which the smallest there can be is given."""
    rng = np.random.default_rng(seed)
    gaps = smallest + np.column_stack([60 + rng.random(size), 30 * rng.random(size)])
    positions = np.cumsum(np.column_stack([gaps[:, :1], gaps]), axis=1)
    return Dataset({"positions": positions}, {"method": method, "kind": "series"})


def scanned(runs, duration):
    """How long runs were, seven of them without noise, which tell nothing of what is rare."""
    return Dataset(
        {"noise": np.append(np.ones(runs), np.zeros(7))}, {"kind": "scan", "duration": duration}
    )


@pytest.mark.parametrize(("gap", "seen"), [(1, YES), (-1, NO), (1e-6, YES)])
def test_blocks_collide_where_a_gap_is_negative(gap, seen):
    """Of all runs by a method, wherever it is; between any two neighbours."""
    near = {"u20": sampled(gap), "belt_028": sampled(2, "event", seed=1)}
    made = near | {"u1": sampled(60), "n10_u28": sampled(9, seed=3), "u17": sampled(70, "event")}
    assert grades("no-collisions", **made) == {"collision": seen, "": seen}
    measurement = measured("no-collisions", **made)
    smallest = measurement.numbers["smallest gap"].value
    assert smallest == pytest.approx(gap, abs=0.1) and measurement.numbers["runs"].value == 3
    assert measurement.note == "the smallest gap is in u20"
    with pytest.raises(NotEnoughDataError, match="no sampled run by verlet"):
        measured("no-collisions", u17=sampled(70, "event"))


@pytest.mark.parametrize(
    ("gap", "runs", "collision", "rate", "verdict"),
    [(5, 8, YES, OPEN, OPEN), (5, 200, YES, YES, YES), (-5, 200, NO, YES, IN_PART)],
)
def test_the_time_in_which_no_blocks_collided_bounds_how_rare_that_is(
    gap, runs, collision, rate, verdict
):
    """None in 3, and none in 81 runs of the paper's 2,000,000: at most 71 % and 4.5 % have one."""
    scans = {"n5_replicates": scanned(runs, 4e5), "size_replicates": scanned(runs, 4.1e5)}
    near = {"u17": sampled(gap, "event"), "belt_028": sampled(9, "event", seed=1)}
    made = {"u1": sampled(-3)} | near | scans
    answer = grades("no-collisions", "robust", **made)
    assert answer == {"collision": collision, "collisions": rate, "": verdict}
    numbers = measured("no-collisions", "faces, exact dynamics", **made).numbers
    assert numbers["runs"].value == 2 * runs
    lengths = int(runs * 8.1e5 / 2e6)
    assert numbers["lengths"].value == lengths
    # no event in n trials: the exact upper end of 97.5 %
    assert numbers["collisions"].high == pytest.approx(1 - 0.025 ** (1 / lengths))


# --- the order of the scheme ----------------------------------------------------------------------


def paths(order, *, starts=8, scatter=0.2):
    """Paths by both methods: an error of an order in dt after each event, different by start."""
    rng = np.random.default_rng(1)
    time = 0.5 * np.arange(100)
    kinds = [("point", "i4"), ("time", "f8"), ("block", "i4"), ("kind", "U5")]

    def dataset(steps, errors):
        size = starts * len(steps)
        arrays = {"n_blocks": np.full(size, 5), "belt_velocity": np.full(size, 20.0)}
        arrays["replicate"] = np.tile(np.arange(starts), len(steps))
        arrays["time_step"] = np.repeat(steps, starts)
        arrays["time"] = time
        arrays["positions"] = errors[:, None, None] * np.ones((1, time.size, 5))
        rows = [(row, 1.2 * number, 1, "slip") for row in range(size) for number in range(30)]
        arrays["events"] = np.array(rows, dtype=kinds)
        return Dataset(arrays, {})

    steps = np.array([0.004, 0.002, 0.001, 0.0005])
    factor = np.exp(scatter * rng.standard_normal(4 * starts))
    tested = 1e3 * factor * np.repeat(steps, starts) ** order
    return {
        "pairs_paths_verlet": dataset(steps, tested),
        "pairs_paths_event": dataset(np.array([0.001, 0.002]), np.repeat([0.0, 5.0], starts)),
    }


@pytest.mark.parametrize(("order", "verdict"), [(3, YES), (1, NO), (2, NO), (2.5, OPEN)])
def test_the_order_of_runs_and_of_the_formula(order, verdict):
    """The formula has one of dt^4 in a step of dt, however runs converge."""
    made = paths(order)
    assert both("scheme-order", **made) == (YES, verdict)
    estimate = measured("scheme-order", "after 5 slips and sticks", **made).judged["order"]
    assert estimate.value == pytest.approx(order, abs=0.2) and estimate.runs == 8
    in_run = measured("scheme-order", "the formula, in a run").judged["order"]
    assert in_run.value == pytest.approx(2, abs=0.1)


def test_errors_are_those_of_the_sample_after_an_event_and_above_rounding():
    made = paths(1, starts=4, scatter=0.0)
    tested, reference = (made[f"pairs_paths_{name}"].arrays for name in ("verlet", "event"))
    tested["positions"] = tested["positions"] * tested["time"][:, None]
    reference["positions"] = 0 * reference["positions"]
    steps, errors = measure.errors_of_runs(tested, reference, 5, 20.0, 6)
    # events at 0, 1.2, ... 6.0, samples each 0.5
    np.testing.assert_allclose(errors, np.tile(1e3 * steps * 6.5, (4, 1)))
    rounded = [1e-12, *1e-3 * steps[1:]]
    assert measure._order(steps, rounded) == pytest.approx(1)
    assert np.isnan(measure._order(steps[:3], rounded[:3]))

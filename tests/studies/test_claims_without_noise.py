"""Claims on the chain without noise on series and scans whose law is known."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.transition import transients
from made_up import columns, escapes, few_resamples, judged, scan_of_laws  # noqa: F401

RNG = np.random.default_rng


# --- u = 7 ----------------------------------------------------------------------------------------


def ends(periodic, irregular=0, sliding=0, **other):
    """Runs of kind settling at u = 7, and runs at other places that must not count."""
    states = ["periodic"] * periodic + ["irregular"] * irregular + ["periodic"] * sliding
    own = columns(
        n_blocks=5,
        belt_velocity=7.0,
        initial_spread=10.0,
        time_step=0.001,
        state=np.array(states),
        settled=[state == "periodic" for state in states],
        period_events=[12] * periodic + [0] * (irregular + sliding),
    )
    away = {name: np.repeat(values[:1], 5) for name, values in own.items()}
    away |= {"state": np.full(5, "irregular"), "settled": np.full(5, False)}
    away |= {name: np.full(5, value) for name, value in other.items()}
    return Dataset({name: np.r_[own[name], away[name]] for name in own}, {})


@pytest.mark.parametrize(
    ("counts", "verdict"),
    [((16, 0), "holds"), ((1, 0, 15), "fails"), ((1, 15), "undecided"), ((9, 0, 7), "undecided")],
)
def test_the_ends_of_runs_at_u7(counts, verdict):
    for reading, name in (("the paper's scheme", "steps"), ("exact dynamics", "survival_many")):
        made = {name: ends(*counts, belt_velocity=9.0)}
        found = judged("u7-periodic", made, reading)
        assert found[0] == verdict and found[2].runs == 16
    finer = {"steps": ends(16, time_step=5e-4)}
    assert judged("u7-periodic", finer)[2].runs == 16
    with pytest.raises(NotEnoughDataError, match="3 runs with initial_spread = 10, n_blocks = 5"):
        judged("u7-periodic", {"steps": ends(3, belt_velocity=9.0)})


@pytest.mark.parametrize(
    ("cycle", "last_stick", "verdict"),
    [([1.0, 5.0, 9.0], 1.91e5, "holds"), ([1.0, 5.0, 9.0], 1.89e5, "fails"), (None, 2e5, "fails")],
)
def test_the_run_from_the_declared_state_at_u7(cycle, last_stick, verdict):
    column = scan_of_laws([7.0], lambda u, rng: 0.1, replicates=1)
    if cycle:
        column.arrays["section_velocity"] = np.tile(cycle, 10)[None]
    column.arrays["last_stick_time"][:] = last_stick
    assert judged("u7-periodic", {"n5_u7": column}, "run from the declared state")[0] == verdict


# --- u = 20 ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("counts", "verdict"),
    [
        ((60, 40, 0, 0), "holds"),
        ((100, 0, 0, 0), "undecided"),  # a share of 0 to 3.6 %
        ((400, 0, 0, 0), "partly"),
        ((20, 10, 70, 0), "partly"),  # on stick-slip orbits: no continuous slip
        ((20, 10, 0, 70), "undecided"),  # chaotic still
    ],
)
def test_transients_at_u20(counts, verdict):
    found = judged("u20-transient", escapes(*counts))
    assert found[0] == verdict
    assert found[2].runs == sum(counts)
    # of a run on an orbit it is open when it came there
    beyond = found[2].judged["runs with a transient beyond 4000"]
    assert beyond.high > (sum(counts) - counts[0]) / sum(counts) - 1e-9


def test_runs_on_one_orbit_are_told_from_chaotic_ones():
    own = escapes(0, 0, 5, 40)["lifetimes"].arrays
    assert transients.on_shared_orbits(own, 2000.0).tolist() == [True] * 5 + [False] * 40
    two = escapes(0, 0, 2, 4)["lifetimes"].arrays
    assert not transients.on_shared_orbits(two, 2000.0).any()
    own["final_stick_rate"][0, 3] += 2 / 2000  # two sticks more: the ends of the time
    own["final_stick_rate"][1, 3] += 4 / 2000
    own["final_amplitude"][2] *= 1.002
    assert transients.on_shared_orbits(own, 2000.0)[:5].tolist() == [True, False, False, True, True]


def test_transients_need_runs_at_u20_of_twice_the_printed_length():
    with pytest.raises(NotEnoughDataError, match="runs of 7999 cannot show lifetimes of 4000"):
        judged("u20-transient", escapes(9, 9, 0, 0, duration=7999.0))
    with pytest.raises(NotEnoughDataError, match="0 runs with belt_velocity = 20"):
        judged("u20-transient", escapes(9, 9, 0, 0, u=20.5))


def test_transients_by_the_exact_dynamics():
    def survival(short, long, sticking, open_ended):
        size = short + long + sticking + open_ended
        index = np.arange(size)
        calm = index < short + long
        arrays = columns(
            n_blocks=np.full(size, 5),
            belt_velocity=20.0,
            initial_spread=10.0,
            settled=index < size - open_ended,
            lifetime=np.where(index < short, 900.0, np.where(calm, 6000.0, 1000.0)),
            disorder_parameter=np.where(calm, 0.02, 0.12),
        )
        arrays["lifetime"][size - open_ended :] = 30_000.0
        return {"survival": Dataset(arrays, {})}

    for counts, verdict in (((60, 40, 0, 0), "holds"), ((15, 10, 75, 0), "partly"),
                            ((30, 10, 0, 60), "undecided")):  # fmt: skip
        found = judged("u20-transient", survival(*counts), "exact dynamics")
        assert found[0] == verdict
    # a run that is not settled has a long transient
    assert found[2].judged["runs with a transient beyond 4000"].value == 0.7


def test_one_run_decides_nothing_at_u20():
    kinds = [("time", "f8"), ("block", "i8"), ("kind", "U5")]
    for last, ending in ((4100.0, 1.0), (3900.0, 1.0), (11_900.0, 0.0)):
        rows = [
            (10.0, 5, "slip"),
            (last, 5, "stick"),
            (last + 1, 4, "stick"),
            (last + 2, 5, "slip"),
        ]
        series = Dataset(
            {"events": np.array(rows, dtype=kinds)}, {"n_blocks": 5, "duration": 12_000.0}
        )
        found = judged("u20-transient", {"u20": series}, "run from the declared state")
        assert found[0] == "undecided"
        numbers = [each.value for each in found[2].judged.values()]
        assert numbers == [float(last > 4000), ending]


@pytest.mark.parametrize(
    ("escaped", "disorder", "rates", "label"),
    [
        (1, 0.0499, [0.1, 0.0], transients.SMALL_SLIP),
        (1, 0.05, [0.1, 0.0], transients.LARGE_SLIP),
        (0, 0.13, [0.1, 0.0], transients.STICK_SLIP),  # still irregular, for all that is known
        (1, 0.13, [0.0, 0.2], transients.STICK_SLIP),
        (1, 0.0, [0.0, 0.1, np.nan], transients.STICK_SLIP),  # the last block of a shorter chain
        (1, 0.0, [0.1, 0.0, np.nan], transients.SMALL_SLIP),
    ],
)
def test_attractors_are_labelled_by_sticks_and_amplitude(escaped, disorder, rates, label):
    found = transients.label_attractors([escaped] * 2, [disorder] * 2, np.array([rates] * 2))
    assert found.tolist() == [label] * 2

"""Claims on the chain without noise on series and scans whose law is known."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.transition import transients
from made_up import columns, escapes, few_resamples, judged, scan_of_laws  # noqa: F401

RNG = np.random.default_rng


# --- the spectrum ---------------------------------------------------------------------------------


def coloured(exponent, prefactor, *, duration=80_000.0, interval=0.5):
    """Series with the spectral density prefactor * nu**exponent, and a transient of 1000."""
    size = int(duration / interval)
    nu = np.fft.rfftfreq(size, interval)
    density = np.zeros(nu.size)
    density[1:] = prefactor * nu[1:] ** exponent
    rng = RNG(1)
    noise = rng.standard_normal(nu.size) + 1j * rng.standard_normal(nu.size)
    x = np.fft.irfft(noise * np.sqrt(density * size / interval) / 2, size)
    arrays = {"time": interval * np.arange(size), "positions": np.column_stack([x[::-1], x])}
    return {"u1": Dataset(arrays, {"transient": 1000.0})}


@pytest.mark.parametrize(
    ("exponent", "prefactor", "verdict"),
    [
        (-1.21, 0.0016, "holds"),
        (-1.6, 0.0016, "partly"),
        (-1.21, 0.01, "partly"),
        (-1.6, 0.01, "fails"),
        (-1.36, 0.0016, "undecided"),
    ],
)
def test_the_exponent_and_the_prefactor_of_a_spectrum(exponent, prefactor, verdict):
    found = judged("spectrum-exponent", coloured(exponent, prefactor))
    numbers = found[2].judged
    assert numbers["exponent"].value == pytest.approx(exponent, abs=0.05)
    assert numbers["prefactor"].value == pytest.approx(prefactor, rel=0.15)
    assert found[0] == verdict


def test_the_amplitude_of_a_spectrum_is_that_of_a_long_series():
    """2|X|/n of white noise of variance s^2 and interval d over a time T: 2 s sqrt(d / T)."""
    made = coloured(-2.42, 1.28)
    found = judged("spectrum-exponent", made, "amplitude, T = 1e6")
    assert found[0] == "holds"
    assert found[2].judged["prefactor"].value == pytest.approx(0.0016, rel=0.15)
    white = RNG(2).standard_normal(160_000) * 3
    arrays = {"time": 0.5 * np.arange(white.size), "positions": white[:, None]}
    series = {"u1": Dataset(arrays, {"transient": 0.0})}
    law = judged("spectrum-exponent", series, "amplitude, T = 1e6")[2].judged
    size = 2e6  # samples in a time of 1e6
    spectrum = 2 * np.abs(np.fft.rfft(white)) / white.size * np.sqrt(white.size / size)
    assert law["prefactor"].value == pytest.approx(np.sqrt(np.mean(spectrum**2)), rel=0.1)


def test_a_spectrum_needs_four_stretches_of_ten_cycles():
    shortest = 4 * 10 / 0.003
    enough = coloured(-1.21, 0.0016, duration=1000 + shortest + 1)
    assert judged("spectrum-exponent", enough)[2].runs == 4
    with pytest.raises(NotEnoughDataError, match="4 stretches of 3333 are needed"):
        judged("spectrum-exponent", coloured(-1.21, 0.0016, duration=1000 + shortest - 10))
    assert judged("spectrum-exponent", coloured(-1.2, 1e-3, duration=2e5))[2].runs == 20


# --- slips in a series ----------------------------------------------------------------------------


def velocity_series(peaks, *, stuck=0.0):
    """Slips of 2 time units every 10 from t = 5 on, with given peaks of |v_r|; u = 2."""
    time = 0.5 * np.arange(20 * len(peaks) + 20)
    relative = np.zeros(time.size)
    kinds = [("time", "f8"), ("block", "i8"), ("kind", "U5")]
    rows = []
    for index, peak in enumerate(peaks):
        begin = 5 + 10.0 * index
        relative[(time > begin) & (time < begin + 2)] = -peak / 2
        relative[time == begin + 1] = -peak
        relative[time == begin + 5] = stuck
        rows += [(begin, 2, "slip"), (begin + 2, 2, "stick"), (begin + 3, 1, "slip")]
    arrays = {"time": time, "velocities": np.column_stack([time, 2 + relative])}
    arrays["events"] = np.array(rows, dtype=kinds)
    return {"u1": Dataset(arrays, {"n_blocks": 2, "belt_velocity": 2.0})}


@pytest.mark.parametrize(
    ("factor", "spread", "verdict"),
    [(50, 0.5, "holds"), (50, 0.01, "partly"), (5, 0.01, "fails"), (20, 0.5, "undecided")],
)
def test_peaks_of_the_velocity_in_slips(factor, spread, verdict):
    peaks = factor * np.exp(spread * RNG(3).standard_normal(200))
    found = judged("slip-velocity", velocity_series(peaks))
    assert found[0] == verdict
    assert found[2].judged["median peak |v_r| / u"].value == pytest.approx(np.median(peaks) / 2)
    ratio = np.quantile(peaks, 0.95) / np.quantile(peaks, 0.05)
    assert found[2].judged["peaks: 95 % over 5 % quantile"].value == pytest.approx(ratio)
    assert found[2].runs == 20


def test_what_is_said_of_velocities_while_stuck():
    peaks = np.full(60, 60.0)
    note = judged("slip-velocity", velocity_series(peaks, stuck=-2e-7))[2].note
    assert "|v_r| up to 2e-07 while stuck" in note
    with pytest.raises(NotEnoughDataError, match="39 slips of the last block, not 40"):
        judged("slip-velocity", velocity_series(peaks[:39]))


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

"""Each claim function on a few made-up numbers: values, errors, counts, both sides of checks."""

import math

import numpy as np
import pytest
from scipy import stats

from alternating import experiments
from beltrepro.analysis import avalanches, spectra
from beltrepro.analysis.errors import NotEnoughDataError
from beltrepro.model import ChainParameters, spring, units
from made_up import LAW, REGISTRY, Stub, cut, data, measured, passed, transition


def events(rows):
    """Events (time, block, kind) and, where given, position and force."""
    table = np.zeros(len(rows), [("time", "f8"), ("block", "i8"), ("kind", "U5"),
                                 ("position", "f8"), ("force", "f8")])  # fmt: skip
    for index, row in enumerate(rows):
        for name, value in zip(table.dtype.names, row, strict=False):
            table[name][index] = value
    return table


# --- model ----------------------------------------------------------------------------------------


def test_constants_of_the_runs_are_compared_with_the_printed_ones():
    found = measured("friction-constants")
    assert found.value["static_friction"] == pytest.approx(1.98 / (19.8 * 1.4e-3))
    assert found.value["friction_ratio"] == pytest.approx(0.89 / 1.98)
    assert passed(found) == [1, 1]
    stub = Stub("friction-constants")
    stub.settings = {"model": LAW | {"friction_ratio": 0.46}}
    assert passed(REGISTRY["friction-constants"](stub)) == [1, 0]


@pytest.mark.parametrize(
    ("change", "failing"),
    [
        (lambda x, force: force, set()),
        (lambda x, force: force - 1e-4 * (abs(x) < 20) * x, {"linear inside"}),
        (lambda x, force: force * np.where(x < -20, 1 + 0.001 * x, 1), {"compressed"}),
        (lambda x, force: force + 1e-3 * (x > 20), {"continuous, stretched"}),
        (lambda x, force: force - 0.01 * np.maximum(x - 20, 0), {"continuous slope, stretched"}),
        (lambda x, force: force - 0.01 * np.minimum(x + 20, 0), {"continuous slope, compressed"}),
        (lambda x, force: force - 1e-3 * np.maximum(x - 20, 0) ** 2, {"exponential, stretched"}),
    ],
)
def test_another_spring_law_is_noticed(monkeypatch, change, failing):
    own = spring.spring_force
    monkeypatch.setattr(spring, "spring_force", lambda x, chain: change(x, own(x, chain)))
    checks = measured("spring-law").checks
    assert len(checks) == 7
    fails = {name for name, passes in checks.items() if not passes}
    assert bool(fails) == bool(failing)
    assert all(any(word in name for name in fails) for word in failing)


def test_the_springs_of_a_chain_with_another_scheme_are_noticed(monkeypatch):
    own = spring.external_force
    assert passed(measured("setup")) == [1, 1, 1]

    def with_(change):
        monkeypatch.setattr(spring, "external_force", lambda x, c: change(x, own(x, c)))
        return passed(measured("setup"))

    assert with_(lambda x, force: force + 1.0) == [0, 0, 0]
    rest = ChainParameters(5, 1.0).rest_positions
    # a spring from the last block to a wall; one from the first to the third block
    assert with_(lambda x, force: force - np.eye(5)[4] * (x - rest)[4]) == [1, 0, 0]
    assert with_(lambda x, force: force + 0.1 * np.eye(5)[2] * (x - rest)[0]) == [1, 1, 0]


def friction_series(*, shift=0.0, spread=1.0, imbalance=0.0, memory=0.0, before=71.4, size=8000):
    rng = np.random.default_rng(0)
    chain = ChainParameters(2, 1.0, noise=2.0)
    slipping = np.arange(size) % 200 >= 100
    positions = chain.rest_positions + rng.uniform(-5, 5, (size, 2))
    drawn = rng.standard_normal((size, 2))
    drawn[1:] = memory * drawn[:-1] + math.sqrt(1 - memory**2) * drawn[1:]
    kinetic = 0.45 * 71.4 * (1 + shift) + 0.45 * 2.0 * spread * drawn
    stuck = -spring.external_force(positions, chain) + imbalance
    arrays = {
        "positions": positions,
        "velocities": np.where(slipping[:, None], -20.0, 1.0) * np.ones(2),
        "friction": np.where(slipping[:, None], kinetic, stuck),
        "events": events([(1.0, 2, "slip", 0, -before), (2.0, 2, "stick"), (3, 1, "slip", 0, 9)]),
    }
    return data(arrays, n_blocks=2, belt_velocity=1.0, noise=2.0), slipping, kinetic


@pytest.mark.parametrize(
    ("change", "checks"),
    [
        ({}, [1, 1, 1, 1, 1]),
        ({"imbalance": 0.7}, [1, 1, 1, 1, 1]),
        ({"imbalance": 0.73}, [0, 1, 1, 1, 1]),
        ({"imbalance": -0.73}, [0, 1, 1, 1, 1]),
        ({"shift": 0.012}, [1, 0, 1, 1, 1]),
        ({"shift": -0.012}, [1, 0, 1, 1, 1]),
        ({"spread": 1.2}, [1, 1, 0, 1, 1]),
        ({"spread": 0.8}, [1, 1, 0, 1, 1]),
        ({"memory": 0.2}, [1, 1, 1, 0, 1]),
        ({"memory": -0.2}, [1, 1, 1, 0, 1]),
        ({"before": 48.0}, [1, 1, 1, 1, 0]),
    ],
)
def test_the_friction_law_is_read_off_the_samples(change, checks):
    series, slipping, kinetic = friction_series(**change)
    found = measured("friction-law", datasets={"friction_event": series})
    assert passed(found) == checks
    # pairs of samples that both slip
    used = kinetic[:-1][slipping[:-1] & slipping[1:]]
    assert found.sample_size == used.size
    assert found.value["mean kinetic friction"] == pytest.approx(used.mean())
    assert found.value["standard deviation"] == pytest.approx(used.std())
    assert found.value["friction before slip"] == pytest.approx(change.get("before", 71.4))
    error = found.uncertainty["mean kinetic friction"]
    assert error == pytest.approx(used.std() / math.sqrt(used.size))


def test_the_friction_law_needs_samples():
    short, *_ = friction_series(size=1000)
    with pytest.raises(NotEnoughDataError, match="too few samples"):
        measured("friction-law", datasets={"friction_event": short})


def test_the_chain_length_is_the_median_near_the_speed_in_metres():
    speeds = [units.from_si(speed, "velocity") for speed in (0.22, 0.28)]
    u = [speeds[0] - 1.01, speeds[0] - 0.99, speeds[0], speeds[0] + 0.99, speeds[1]]
    row = cut(u, mean_length=[1.0, 500, 700, 600, 650])
    found = measured("chain-length", rows={(5, 1.0): row})
    assert found.value == {
        "0.22 m/s": pytest.approx(600 * 1.4e-3),
        "0.28 m/s": pytest.approx(650 * 1.4e-3),
    }
    with pytest.raises(NotEnoughDataError, match=r"no point within 1 of u = 0.28"):
        measured("chain-length", rows={(5, 1.0): cut(u[:4], mean_length=u[:4])})


# --- without noise --------------------------------------------------------------------------------


def test_the_readings_of_the_spectrum_are_what_their_names_say():
    rng = np.random.default_rng(1)
    size, interval = 40_000, 0.125
    x = np.cumsum(rng.standard_normal((size, 2)), axis=0)
    arrays = {"time": interval * np.arange(size), "positions": x}
    found = REGISTRY["spectrum-exponent"](
        Stub("spectrum-exponent", datasets={"u1": data(arrays, transient=125.0)})
    )
    values = x[1000:, 1]

    def expected(window, segment, low, high, amplitude):
        nu, s = spectra.power_spectrum(values, interval, window=window, segment=segment)
        if amplitude:
            s = spectra.amplitude_spectrum(nu, s)
        return spectra.fit_power_law(nu, s, low=low, high=high)

    readings = {
        "power": ("hann", None, 0.003, 0.3, False),
        "amplitude": ("hann", None, 0.003, 0.3, True),
        "power, no window function": ("boxcar", None, 0.003, 0.3, False),
        "amplitude, no window function": ("boxcar", None, 0.003, 0.3, True),
        "power, averaged over 8 segments": ("hann", values.size // 8, 0.006, 0.3, False),
        "power, fit for 0.01 to 1": ("hann", None, 0.01, 1.0, False),
        "amplitude, fit for 0.01 to 1": ("hann", None, 0.01, 1.0, True),
        "power, fit for 0.001 to 0.1": ("hann", None, 0.001, 0.1, False),
        "amplitude, fit for 0.001 to 0.1": ("hann", None, 0.001, 0.1, True),
    }
    assert list(found) == list(readings)
    for name, settings in readings.items():
        fit, measurement = expected(*settings), found[name]()
        assert (measurement.value, measurement.uncertainty) == (fit.exponent, fit.exponent_error)
        assert measurement.sample_size == 39_000
        assert f"{fit.prefactor:.2g}" in measurement.note
    short = {name: values[: int(3334 / interval)] for name, values in arrays.items()}
    stub = Stub("spectrum-exponent", datasets={"u1": data(short, transient=0.0)})
    assert REGISTRY["spectrum-exponent"](stub)  # ten periods of the lowest frequency
    short = data({name: values[:-10] for name, values in short.items()}, transient=0.0)
    with pytest.raises(NotEnoughDataError, match="3333 are needed"):
        REGISTRY["spectrum-exponent"](Stub("spectrum-exponent", datasets={"u1": short}))


def velocity_series(peaks, *, stuck=0.0):
    """Slips of 2 time units every 10 from t = 5 on, with given peaks of |v_r|; u = 2."""
    time = 0.5 * np.arange(20 * len(peaks) + 20)
    relative = np.zeros(time.size)
    rows = []
    for index, peak in enumerate(peaks):
        begin = 5 + 10.0 * index
        relative[(time > begin) & (time < begin + 2)] = -peak / 2
        relative[time == begin + 1] = -peak
        relative[time == begin + 5] = stuck
        rows += [(begin, 2, "slip"), (begin + 2, 2, "stick"), (begin + 3, 1, "slip")]
    arrays = {"time": time, "velocities": np.column_stack([time, 2 + relative])}
    return data(arrays | {"events": events(rows)}, n_blocks=2, belt_velocity=2.0)


@pytest.mark.parametrize(
    ("peaks", "stuck", "checks"),
    [
        ([24.0] * 19 + [16, 99], 0.0, [1, 1, 0]),  # the last slip is not looked at
        ([24.0] * 19 + [15.9, 99], 0.0, [1, 1, 1]),
        ([20.0] * 19 + [10, 99], 0.0, [1, 0, 1]),
        ([20.1] * 19 + [10, 99], 2e-9, [0, 1, 1]),
        ([20.1] * 19 + [10, 99], -2e-9, [0, 1, 1]),
    ],
)
def test_velocities_in_and_between_slips(peaks, stuck, checks):
    found = measured("slip-velocity", datasets={"u1": velocity_series(peaks, stuck=stuck)})
    assert passed(found) == checks
    assert found.value == {
        "largest |v_r| while stuck": pytest.approx(abs(stuck), rel=1e-3),
        "largest |v_r| / u in slips": max(peaks[:-1]) / 2,
        "smallest peak / u": min(peaks[:-1]) / 2,
    }
    assert found.sample_size == len(peaks) - 1


def test_velocities_need_twenty_slips():
    with pytest.raises(NotEnoughDataError, match="19 slips of the last block, not 20"):
        measured("slip-velocity", datasets={"u1": velocity_series([30.0] * 19)})


def catalogue(chains=10, per_chain=200, seed=2):
    """Slips of the last of two blocks with power-law sizes, and avalanches about each of them."""
    rng = np.random.default_rng(seed)
    size = chains * per_chain
    slips = np.zeros(2 * size, [("point", "i4"), ("block", "i4"), ("start_time", "f8"),
                                ("stop_time", "f8"), ("start_position", "f8"),
                                ("stop_position", "f8"), ("dissipated", "f8")])  # fmt: skip
    start = np.tile(20.0 * np.arange(per_chain), chains)
    slips["point"] = np.repeat(np.arange(chains), 2 * per_chain)
    slips["block"] = np.tile([2, 1], size)
    slips["start_time"] = np.repeat(start, 2) + np.tile([0.0, 1.0], size)
    slips["stop_time"] = slips["start_time"] + 4
    slips["start_position"] = 60 + 60 * rng.pareto(1.2, 2 * size)
    slips["dissipated"] = 10 * (1 + rng.pareto(0.9, 2 * size))
    found = np.zeros(2 * size, [("point", "i4"), ("start_time", "f8"), ("stop_time", "f8"),
                                ("dissipated", "f8"), ("spring_energy_drop", "f8")])  # fmt: skip
    found["point"] = slips["point"]
    found["start_time"] = np.repeat(start, 2) + np.tile([-1.0, 10.0], size)  # each second: none
    found["stop_time"] = found["start_time"] + 7
    found["dissipated"] = 1e3 * (1 + rng.pareto(0.8, 2 * size))
    found["spring_energy_drop"] = 1e3 * (1 + rng.pareto(1.5, 2 * size))
    return data({"slips": slips, "avalanches": found}, n_blocks=2, belt_velocity=3.0)


def exponent(values, bins_per_decade=10, whole=False):
    histogram = avalanches.log_histogram(values, bins_per_decade=bins_per_decade)
    low, high = avalanches.falling_range(*histogram)
    if whole:
        low, high = histogram[0][0], histogram[0][-1]
    return avalanches.fit_density(*histogram, low=low, high=high)


def test_the_readings_of_slip_sizes_are_what_their_names_say():
    made = catalogue()
    slips = made.arrays["slips"][::2]
    size = slips["start_position"] - slips["stop_position"]
    samples = {
        "laboratory frame": (size, 10, False),
        "belt frame": (size + 3.0 * 4, 10, False),
        "5 bins per decade": (size, 5, False),
        "20 bins per decade": (size, 20, False),
        "all bins": (size, 10, True),
    }
    stub = Stub("slip-size-exponent", datasets={"slips_u1": made})
    found = REGISTRY["slip-size-exponent"](stub)
    assert list(found) == [*samples, "maximum likelihood"]
    for name, settings in samples.items():
        fit, measurement = exponent(*settings), found[name]()
        assert measurement.value == fit.exponent and measurement.sample_size == 2000
        assert measurement.uncertainty >= fit.exponent_error
        assert f"{fit.low:.3g} to {fit.high:.3g}, {fit.sample_size} bins" in measurement.note
    likely = found["maximum likelihood"]()
    low, high = avalanches.falling_range(*avalanches.log_histogram(size, bins_per_decade=10))
    fit = avalanches.maximum_likelihood_exponent(size, low=low, high=high)
    assert (likely.value, likely.uncertainty) == (fit.exponent, fit.exponent_error)
    assert likely.sample_size == fit.sample_size and "a power law fits better" in likely.note
    few = catalogue(chains=1, per_chain=499)
    with pytest.raises(NotEnoughDataError, match="499 slips of the last block, 500 are needed"):
        measured("slip-size-exponent", datasets={"slips_u1": few})


def test_the_readings_of_energies_are_what_their_names_say():
    made = catalogue()
    slips, found = made.arrays["slips"], made.arrays["avalanches"]
    reaching = found[::2]
    # while block 2 slips for 4, block 1 slips for the last 3 of its first 3: three quarters of it
    until_stop = slips["dissipated"][::2] + 0.75 * slips["dissipated"][1::2]
    samples = {
        "chain, until all are stuck": (reaching["dissipated"], 10),
        "chain, until the last block stops": (until_stop, 10),
        "last block only": (slips["dissipated"][::2], 10),
        "all avalanches of the chain": (found["dissipated"], 10),
        "drop in spring energy": (reaching["spring_energy_drop"], 10),
        "20 bins per decade": (reaching["dissipated"], 20),
    }
    readings = REGISTRY["slip-energy-exponent"](
        Stub("slip-energy-exponent", datasets={"slips_u1": made})
    )
    assert list(readings) == [*samples, "maximum likelihood"]
    for name, (values, bins) in samples.items():
        measurement = readings[name]()
        assert measurement.value == pytest.approx(exponent(values, bins).exponent)
        assert measurement.sample_size == values.size
    low, high = avalanches.falling_range(
        *avalanches.log_histogram(reaching["dissipated"], bins_per_decade=10)
    )
    fit = avalanches.maximum_likelihood_exponent(reaching["dissipated"], low=low, high=high)
    assert readings["maximum likelihood"]().value == fit.exponent


def test_the_error_of_a_density_exponent_is_the_spread_over_chains_where_there_are_eight():
    """Chains whose values differ as a whole: the scatter of the bins does not know of that."""
    rng = np.random.default_rng(3)
    made = catalogue(chains=8, per_chain=250)
    sizes = made.arrays["slips"]["start_position"].reshape(8, -1)
    sizes[:] = 60 * (1 + rng.pareto(rng.uniform(0.6, 2.2, 8)[:, None], sizes.shape))
    whole = measured("slip-size-exponent", "laboratory frame", datasets={"slips_u1": made})
    own = made.arrays["slips"][::2]
    groups = [own["start_position"][own["point"] == chain] for chain in range(8)]
    resampled = [
        exponent(np.concatenate([groups[k] for k in rng.integers(0, 8, 8)])).exponent
        for _ in range(200)
    ]
    assert whole.uncertainty == pytest.approx(np.std(resampled), rel=0.35)
    assert whole.uncertainty > 2 * exponent(own["start_position"]).exponent_error
    seven = own[own["point"] < 7]
    made = data({"slips": seven, "avalanches": None}, n_blocks=2, belt_velocity=3.0)
    few = measured("slip-size-exponent", "laboratory frame", datasets={"slips_u1": made})
    assert few.uncertainty == exponent(seven["start_position"]).exponent_error


CYCLE = np.tile([1.0, 5.0, 9.0], 10)


@pytest.mark.parametrize(
    ("velocities", "last_stick", "period", "checks"),
    [
        (CYCLE, 380_001.0, 3, [1, 1]),  # the last tenth of 2e5 to 4e5 begins at 3.8e5
        (CYCLE, 379_999.0, 3, [1, 0]),
        (np.arange(30.0), 4e5, 0, [0, 1]),
    ],
)
def test_the_period_at_u7(velocities, last_stick, period, checks):
    column = cut(
        [7.0, 7, 7], noise=[1.0, 0, 0], disorder=[0.3, 0.06, 0.1],
        velocities=[np.full(31, 7.0), [*velocities, np.nan], np.full(31, 7.0)],
        last_stick_time=[0, last_stick, 0],
    )  # fmt: skip
    found = measured("u7-periodic", columns={(5, 7.0): column})
    assert found.value == {"period in crossings": period, "r": 0.06}
    assert passed(found) == checks and found.sample_size == 30


def escapes(lifetime, escaped, *, u=20.0, sticks=0.0, duration=9000.0):
    size = len(lifetime)
    arrays = {
        "belt_velocity": np.concatenate([np.full(size, u), [30.0]]),
        "lifetime": np.array([*lifetime, 1.0]),
        "escaped": np.array([*escaped, True]),
        "final_disorder": np.full(size + 1, 0.02),
        "final_stick_rate": np.full((size + 1, 5), sticks),
    }
    return {"lifetimes": data(arrays, duration=duration)}


def test_lifetimes_at_u20():
    lifetime = np.arange(1000.0, 11_000, 500)  # 20 members
    escaped = lifetime < 8000
    found = measured("u20-transient", "many runs", datasets=escapes(lifetime, escaped))
    lived = np.where(escaped, lifetime, 9000.0)
    assert found.value == {"median lifetime": np.median(lived), "share that escapes": 0.7}
    assert found.sample_size == 20 and passed(found) == [1, 1]
    rng = np.random.default_rng(5)
    medians = [np.median(rng.choice(lived, 20)) for _ in range(2000)]
    error = found.uncertainty["median lifetime"]
    assert error == pytest.approx(np.std(medians), rel=0.15)
    assert "1238 to inf" in found.note
    half = measured("u20-transient", "many runs", datasets=escapes(lifetime, lifetime < 6000))
    assert half.value["share that escapes"] == 0.5 and passed(half) == [1, 0]
    sticky = escapes(lifetime, escaped, sticks=0.1)
    assert passed(measured("u20-transient", "many runs", datasets=sticky)) == [1, 0]
    late = measured("u20-transient", "many runs", datasets=escapes(lifetime + 3100, escaped))
    assert passed(late) == [0, 1]
    early = escapes(np.full(20, 3900.0), np.full(20, True))
    assert passed(measured("u20-transient", "many runs", datasets=early)) == [0, 1]
    for change, message in (
        ({"u": 20.6}, "no belt velocity near 20"),
        ({"duration": 7999.0}, "runs of 7999 cannot show lifetimes of 4000"),
    ):
        with pytest.raises(NotEnoughDataError, match=message):
            measured("u20-transient", "many runs", datasets=escapes(lifetime, escaped, **change))
    with pytest.raises(NotEnoughDataError, match="9 runs, 10 are needed"):
        measured("u20-transient", "many runs", datasets=escapes(lifetime[:9], escaped[:9]))


@pytest.mark.parametrize(
    ("last", "duration", "checks"),
    [
        (2000.0, 12_000.0, [1, 1]),
        (1999.0, 12_000.0, [1, 0]),
        (8000.0, 12_000.0, [1, 1]),
        (8001.0, 12_000.0, [1, 0]),
        (3000.0, 3200.0, [0, 1]),  # not longer than the laminar time
        (3000.0, 3333.0, [0, 1]),  # not a tenth of the run
        (3000.0, 3334.0, [1, 1]),
    ],
)
def test_the_single_run_at_u20(last, duration, checks):
    rows = [(10.0, 5, "slip"), (last, 5, "stick"), (last + 1, 4, "stick"), (last + 1, 5, "slip")]
    series = data({"events": events(rows)}, n_blocks=5, duration=duration)
    found = measured("u20-transient", "run from the declared state", datasets={"u20": series})
    assert found.value == {"last stick": last} and passed(found) == checks


def test_the_jump_of_r():
    row = cut([1.0], fall=transition(15, 18, 16, error=0.7, high=0.12, low=0.02, n=33))
    jump = measured("r-jump", rows={(5, 0.0): row})
    assert jump.value == {"r_chaotic": 0.12, "r_periodic": 0.02}
    assert jump.uncertainty == {"r_chaotic": 0.003, "r_periodic": 0.004}
    assert jump.sample_size == 33 and passed(jump) == [1] and "ratio 6" in jump.note
    critical = measured("u-critical", rows={(5, 0.0): row})
    assert (critical.value, critical.uncertainty, critical.sample_size) == (16, 0.7, 33)
    assert "15 to 18" in critical.note
    for low, met in ((0.02, 1), (0.0201, 0)):
        row = cut([1.0], fall=transition(15, 18, high=0.1, low=low))
        assert passed(measured("r-jump", rows={(5, 0.0): row})) == [met]


@pytest.mark.parametrize(
    ("disorder", "labels", "counts", "checks"),
    [
        ([0.9, 0.061, 0.06, 0.2, 0.01, 0.9], "cpqscc", (2, 2), [1, 1, 1]),
        ([0.9, 0.061, 0.06, 0.2, 0.01, 0.9], "cpqicc", (2, 1), [1, 1, 0]),
        ([0.9, 0.061, 0.06, 0.2, 0.01, 0.9], "cuqccc", (2, 0), [1, 0, 0]),
        ([0.9, 0.06, 0.06, 0.06, 0.01, 0.9], "cpqscc", (0, 0), [0, 0, 1]),
    ],
)
def test_outliers_beyond_the_transition(disorder, labels, counts, checks):
    u = [19.9, 20.0, 20.5, 21, 22.0, 22.1]
    row = cut(u, disorder=disorder, labels=labels, fall=transition(15, 18, high=0.12))
    found = measured("outliers", rows={(5, 0.0): row})
    assert found.value == {"outliers": counts[0], "of them not chaotic": counts[1]}
    assert passed(found) == checks and found.sample_size == 4
    assert found.note == ("u = 20, 21" if counts[0] else "")
    lost = cut(u, disorder=disorder, labels=labels, fall=transition(15, 18, found=False))
    for other, message in ((lost, "no transition found"), (cut(u[:4], fall=lost), "3 points")):
        with pytest.raises(NotEnoughDataError, match=message):
            measured("outliers", rows={(5, 0.0): other})


# --- with noise -----------------------------------------------------------------------------------

WINDOW = np.arange(2.0, 17)  # 3 to 15 are looked at


def filling(*shares, size=200):
    """Section velocities (P, size) that fill so many of 100 bins of -100 to 0 evenly."""
    return np.array([-100 + np.arange(size) % share + 0.5 for share in shares])


def window_rows(noise, filled, **other):
    """Rows at sigma = 1, in which the usual point fills 80 bins, and at another noise."""
    usual = filling(*[80] * WINDOW.size)
    usual[:, 0], usual[:, 1] = -100.0, 0.0
    rows = {(5, 1.0): cut(WINDOW, velocities=usual)}
    velocities = filling(99, *filled, 1)  # 2 and 16 are outside
    velocities[:, 0], velocities[:, 1] = -100.0, 0.0
    return rows | {(5, noise): cut(WINDOW, velocities=velocities, **other)}


def test_windows_against_noise():
    scan = data({"noise": np.array([0.0, 0.5, 1.0, 2.0, 0.5])})
    counts = {0.0: 7, 0.5: 3, 2.0: 0}
    rows = {}
    for noise, count in counts.items():
        rows |= window_rows(noise, [20] * count + [80] * (13 - count))
    found = measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})
    assert found.value == {
        "windows at 0": 7 / 13, "windows at 0.5": 3 / 13, "windows at 1": 0, "windows at 2": 0
    }  # fmt: skip
    assert passed(found) == [1, 1, 1] and found.sample_size == 13 * 4
    rows |= window_rows(2.0, [20] + [80] * 12)
    found = measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})
    assert passed(found) == [1, 0, 1]
    rows |= window_rows(0.0, [80] * 13) | window_rows(0.5, [20] + [80] * 12)
    found = measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})
    assert passed(found) == [0, 0, 0]
    few = data({"noise": np.array([0.0, 0.5, 1.0])})
    with pytest.raises(NotEnoughDataError, match="3 noise levels, 4 are needed"):
        measured("windows-vanish", rows=rows, datasets={"n5_rows": few})


@pytest.mark.parametrize(("bins", "share"), [(38, 1.0), (45, 0.0)])
def test_a_window_fills_less_than_half_of_the_usual_bins(bins, share):
    """Nine tenths of 80 bins are usual, and so 36 of 38 or 41 of 45 are less than half or more."""
    scan = data({"noise": np.array([0.0, 3.0, 1.0, 2.0])})
    rows = {}
    for noise in (0.0, 2.0, 3.0):
        rows |= window_rows(noise, [bins] * 13)
    found = measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})
    assert found.value["windows at 0"] == share


def test_windows_need_points_with_crossings():
    rows = window_rows(0.0, [80] * 13)
    rows[5, 0.0].points["section_velocity"][6:, 5:] = np.nan  # 5 of them are left
    scan = data({"noise": np.arange(4.0)})
    with pytest.raises(NotEnoughDataError, match="5 points with enough crossings, 6 are needed"):
        measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})
    rows[5, 1.0].points["section_velocity"][:] = np.nan
    with pytest.raises(NotEnoughDataError):
        measured("windows-vanish", rows=rows, datasets={"n5_rows": scan})


@pytest.mark.parametrize(
    ("shift", "filled", "scatter", "checks"),
    [
        (1.99, 80, 0.01, [1, 1, 1]),
        (-1.99, 80, 0.01, [1, 1, 1]),
        (2.0, 80, 0.01, [0, 1, 1]),
        (0.0, 20, 0.01, [1, 0, 1]),
        (0.0, 80, 0.05, [1, 1, 0]),
    ],
)
def test_the_transition_at_sigma_1(shift, filled, scatter, checks):
    zigzag = np.where(np.arange(WINDOW.size) % 2, 1.0, -1.0)
    outside = np.where((WINDOW < 3) | (WINDOW > 15), 9.0, 0.0)
    rows = window_rows(1.0, [80] * 12 + [filled], disorder=0.1 + scatter * zigzag + outside)
    fall = transition(15, 18, 16.0, error=0.5, n=30)
    rows[5, 0.0] = cut(WINDOW, disorder=0.1 + 0.05 * zigzag - outside, fall=fall)
    noisy = transition(16, 19, 16.0 + shift, error=0.7, n=12)
    rows[5, 1.0].__dict__["transition"] = noisy
    found = measured("sigma1-transition", rows=rows)
    assert passed(found) == checks
    assert found.value["u_c at 0"] == 16 and found.value["u_c at 1"] == 16 + shift
    assert found.uncertainty == {"u_c at 0": 0.5, "u_c at 1": 0.7} and found.sample_size == 42
    # a zigzag of amplitude a about 0.1 has second differences of 4 a; 3 of 13 points are low
    for name, size in (("roughness at 0", 0.05), ("roughness at 1", scatter)):
        values = 0.1 + size * zigzag[1:-1]
        assert found.value[name] == pytest.approx(4 * size / np.median(values))
    assert found.value["windows at 1"] == (1 / 13 if filled < 40 else 0)


@pytest.mark.parametrize(
    ("critical", "error", "checks"),
    [
        ([16, 17, 18, 21], 1.0, [1, 1]),
        ([16, 17, 18, 18.82], 1.0, [1, 0]),
        ([16, 17, 18, 18.84], 1.0, [1, 1]),
        ([20, 16, 24, 21], 1.0, [0, 1]),  # rank correlation 0.4
        ([16, 18, 24, 21], 1.0, [1, 1]),
    ],
)
def test_critical_velocities_against_noise(critical, error, checks):
    levels = [0.0, 1.0, 2.0, 5.0]
    falls = [transition(u - 1, u + 1, error=error, n=7) for u in critical]
    rows = {("n5_rows", s): cut(fall=fall) for s, fall in zip(levels, falls, strict=True)}
    rows["n5_rows", 9.0] = cut(fall=transition(1, 99, found=False, n=7))
    stub = {"rows": rows, "datasets": {"n5_rows": data({"noise": np.array([*levels, 9.0, 0.0])})}}
    found = measured("uc-of-sigma", "fine rows", **stub)
    assert [found.value[f"u_c at {s:g}"] for s in levels] == critical
    assert found.uncertainty["u_c at 2"] == error and found.sample_size == 35
    assert passed(found) == checks
    del rows["n5_rows", 5.0], rows["n5_rows", 2.0]
    few = data({"noise": np.array([0.0, 1.0, 9.0])})
    with pytest.raises(NotEnoughDataError, match="r falls at 2 of 3 noise levels, 3 are needed"):
        measured("uc-of-sigma", "fine rows", rows=rows, datasets={"n5_rows": few})
    with pytest.raises(NotEnoughDataError, match="2 noise levels in scans/n5_map"):
        two = {"n5_map": data({"noise": np.array([0.0, 1.0])})}
        measured("uc-of-sigma", "map", rows=rows, datasets=two)


def noisy_motion(exponents, *, runs=8, n_blocks=5, u=7.0):
    """Runs with exponents of one standard error of 1e-4 about the given means by noise."""
    scatter = np.tile([-1.0, 1.0], runs)[:runs]
    scatter *= 1e-4 / stats.sem(scatter)
    noise = np.repeat(list(exponents), runs)
    arrays = {
        "n_blocks": np.full(noise.size, n_blocks),
        "belt_velocity": np.full(noise.size, u),
        "noise": noise,
        "largest_exponent": np.repeat(list(exponents.values()), runs)
        + np.tile(scatter, len(exponents)),
    }
    return arrays


@pytest.mark.parametrize(
    ("exponents", "met"),
    [
        ({0.5: 0.0, 0.8: 3.1e-4, 1: 3.1e-4, 2.2: 2.9e-4, 2.3: 0.0}, 1),
        ({0.5: 9e-4, 0.8: 3.1e-4, 1: 2.9e-4, 1.5: 9e-4, 2.2: -9e-4, 2.3: 9e-4}, 0),  # half
        ({0.79: 9e-4, 0.8: 0.0, 2.2: 0.0, 2.21: 9e-4}, 0),
    ],
)
def test_the_rise_at_u7(exponents, met):
    rise = transition(0.6, 1.1, 0.8, error=0.1, high=0.12, low=0.06, n=21)
    other = [noisy_motion({1.0: -1.0}, u=16.0), noisy_motion({1.0: 1.0}, n_blocks=6)]
    parts = [noisy_motion(exponents), *other]
    made = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    given = {"columns": {(5, 7.0): cut(rise=rise)}, "datasets": {"noisy_motion": data(made)}}
    found = measured("sigma-c-u7", **given)
    assert (found.value, found.uncertainty, found.sample_size) == (0.8, 0.1, 21)
    assert "from 0.06 to 0.12" in found.note and "between 0.6 and 1.1" in found.note
    assert passed(found) == [met]
    assert f"{exponents[2.2]:.2g} +- 0.0001 at 2.2" in found.note and "at 0.5" not in found.note


def test_the_rise_at_u7_needs_exponents_beyond_it():
    def at(noise, rise, runs=8):
        made = noisy_motion(dict.fromkeys(noise, 1.0), runs=runs)
        columns = {(5, 7.0): cut(rise=rise)}
        return measured("sigma-c-u7", columns=columns, datasets={"noisy_motion": data(made)})

    rise = transition(0.6, 1.1, 0.8)
    with pytest.raises(NotEnoughDataError, match=r"no exponent between sigma = 0.8 and 2.2"):
        at([0.5, 5.0], rise)
    with pytest.raises(NotEnoughDataError, match="7 runs at a noise level, 8 are needed"):
        at([1.0], rise, runs=7)
    flat = at([1.0], transition(math.nan, math.nan, math.nan, found=False))
    assert math.isnan(flat.value) and passed(flat) == [0]


@pytest.mark.parametrize(
    ("critical", "widths", "lost", "checks"),
    [
        ([2, 3, 4, 5], [1, 2, 3, 4], (), [1, 1, 1]),
        ([2, 3, 4, 5], [3, 2, 3, 4], (), [1, 1, 0]),
        ([3, 4, 2, 5], [1, 2, 3, 4], (), [1, 0, 1]),  # rank correlation 0.4
        ([2, 3, 4, 5], [1, 2, 3, 4], (3,), [0, 1, 1]),
    ],
)
def test_rises_against_u(critical, widths, lost, checks):
    u = [20.0, 22, 25, 30]
    columns = {(5, 19.0): None}
    for k, place in enumerate(u):
        half = widths[k] / 2
        rise = transition(critical[k] - half, critical[k] + half, n=8, found=k not in lost)
        columns[5, place] = cut(rise=rise)
    scan = data({"belt_velocity": np.array([*u, 19.0, 20.0])})
    found = measured("r-of-sigma", columns=columns, datasets={"n5_columns": scan})
    assert found.value == {f"sigma_c at u = {u[k]:g}": critical[k] for k in range(4)}
    assert found.uncertainty["sigma_c at u = 22"] == 0.5 and found.sample_size == 32
    assert passed(found) == checks
    few = data({"belt_velocity": np.array(u[:3])})
    with pytest.raises(NotEnoughDataError, match="3 columns with u >= 20, 4 are needed"):
        measured("r-of-sigma", columns=columns, datasets={"n5_columns": few})
    for place in u[:2]:
        columns[5, place] = cut(rise=transition(1, 2, found=False))
    with pytest.raises(NotEnoughDataError, match="too few to compare"):
        measured("r-of-sigma", columns=columns, datasets={"n5_columns": scan})


@pytest.mark.parametrize(
    ("phases", "share", "counts", "checks"),
    [
        ([[0, 300], [500, 950]], [0.0] * 6, (2, 0), [1, 1, 1]),
        ([[0, 500]], [0.0] * 6, (1, 0), [0, 1, 1]),
        ([[0, 20], [500, 529]], [0.0] * 6, (2, 0), [1, 0, 1]),
        ([[0, 450], [460, 970]], [0.0] * 6, (2, 0), [1, 0, 1]),
        ([[0, 300], [500, 950]], [0.5, 0, 0.5, 0, 0, 0.5], (2, 1), [1, 1, 0]),
    ],
)
def test_intermittency_of_the_series_and_none_without_noise(phases, share, counts, checks):
    u = [14.9, 15, 17, 18, 20, 20.1]
    row = cut(u, laminar_fraction=share, laminar_count=np.full(6, 9))
    given = {"phases": {"u17": (np.array(phases, dtype=float), 1000.0)}, "rows": {(5, 0.0): row}}
    found = measured("intermittency", **given)
    assert found.value == {
        "laminar share": sum(b - a for a, b in phases) / 1000,
        "laminar phases": counts[0],
        "intermittent points at sigma = 0": counts[1],
    }
    assert passed(found) == checks and found.sample_size == counts[0]
    assert "4 points without noise" in found.note
    given["rows"] = {(5, 0.0): cut(u[:4], laminar_fraction=share[:4], laminar_count=[9] * 4)}
    with pytest.raises(NotEnoughDataError, match="3 points in 15 <= u <= 20"):
        measured("intermittency", **given)


def test_the_critical_velocity_in_metres_per_second():
    row = cut(fall=transition(17, 21, 19.5, error=0.4, n=50))
    found = measured("uc-sigma22", rows={(5, 2.2): row})
    metre = 1.4e-3 / math.sqrt(0.1158 / 19.8)
    assert found.value == {"u_c": 19.5, "u_c_m_s": pytest.approx(19.5 * metre)}
    assert found.uncertainty == {"u_c": 0.4, "u_c_m_s": pytest.approx(0.4 * metre)}
    assert found.sample_size == 50 and "17 to 21" in found.note


@pytest.mark.parametrize(("r", "met"), [(0.13, 1), (0.53, 0), (0.51, 1), (0.0051, 0), (0.0053, 1)])
def test_r_at_the_speeds_of_the_experiment(r, met):
    """Medians within 1 of the speeds; the experiment found 0.052 at the second."""
    speeds = [units.from_si(speed, "velocity") for speed in (0.22, 0.28)]
    u = [speeds[0] - 1.01, speeds[0] - 0.99, speeds[0], speeds[0] + 0.99, speeds[1]]
    row = cut(u, disorder=[9.0, 0.1, 0.13, 0.11, r])
    rows = {(5, s): row for s in (0.0, 1.0, 2.0)}
    given = {"rows": rows, "datasets": {"n5_rows": data({"noise": np.array([0.0, 1, 2])})}}
    found = measured("r-experiment", "sigma = 2", **given)
    assert list(REGISTRY["r-experiment"](Stub("r-experiment", **given))) == [
        "sigma = 1", "sigma = 0", "sigma = 2", "films, sigma = 1"
    ]  # fmt: skip
    assert found.value == {"r_022": 0.11, "r_028": r}
    assert found.uncertainty["r_022"] == pytest.approx(np.std([0.1, 0.13, 0.11]) / math.sqrt(3))
    assert found.sample_size == 4
    assert passed(found) == [met]


def test_the_natural_distribution():
    u = np.concatenate([WINDOW, np.arange(25.0, 40)])
    low, high = WINDOW.size, 15

    def row(bins_low, bins_high, fall=None):
        velocities = filling(*[bins_low] * low, *[bins_high] * high)
        velocities[low] = -99.5  # u = 25 itself is not looked at
        velocities[0, :2] = -100, 0
        return cut(u, velocities=velocities, fall=fall)

    def checks(**change):
        rows = {
            (5, 0.0): row(80, 10),
            (5, 1.0): row(80, 80, transition(15, 18)),
            (5, 5.0): row(80, 80, transition(15, 20)),
            (5, 10.0): row(80, 80),
        } | {(5, float(name[1:])): value for name, value in change.items()}
        return measured("natural-distribution", rows=rows)

    found = checks()
    assert passed(found) == [1, 1, 1, 1] and found.sample_size == 4 * u.size
    assert found.value["width at 1"] == 3 and found.value["width at 5"] == 5
    assert found.value["spread ratio at 10"] == 1
    assert found.value["spread ratio at 0"] == pytest.approx(9 / 72, abs=0.02)
    assert passed(checks(s5=row(80, 80, transition(15, 18)))) == [1, 1, 0, 1]
    assert passed(checks(s5=row(80, 80, transition(1, 2, found=False)))) == [1, 1, 1, 1]
    assert passed(checks(s1=row(80, 80, transition(15, 18, found=False)))) == [1, 0, 0, 1]
    assert passed(checks(s10=row(80, 30))) == [1, 1, 1, 0]
    assert passed(checks(s0=row(80, 45))) == [1, 1, 1, 0]
    assert passed(checks(s0=row(80, 36), s10=row(80, 44))) == [1, 1, 1, 1]


def map_table(**change):
    """Twelve u at three noise levels: chaotic up to 15, quiet from 25 on, some intermittent."""
    u = np.tile([2.0, 5, 8, 11, 15, 18, 20, 22, 25, 30, 40, 50], 3)
    noise = np.repeat([0.0, 1.0, 3.0], 12)
    disorder = np.where(u <= 20, 0.13, 0.02)
    points = {
        "n_blocks": np.full(36, 5),
        "noise": noise,
        "disorder": disorder,
        "laminar_fraction": np.where((u == 22) & (noise > 0), 0.5, 0.0),
        "laminar_count": np.full(36, 9),
    }
    return cut(u, **points | change), u, noise, disorder


@pytest.mark.parametrize(
    ("factor", "checks"), [(1.10, [1, 1, 1, 1]), (0.91, [1, 1, 1, 1]), (1.11, [0, 1, 1, 1])]
)
def test_the_map_agrees_with_the_rows(factor, checks):
    table, u, _, disorder = map_table()
    near = np.arange(36) % 3 < 2
    rows = cut(
        u[near] + 1e-9, noise=table.noise[near], n_blocks=np.full(24, 5),
        disorder=disorder[near] * factor,
    )  # fmt: skip
    found = measured("r-map", tables={"n5_map": table, "n5_rows": rows})
    assert passed(found) == checks and found.sample_size == 36
    assert found.value == {
        "median difference from rows": pytest.approx(abs(math.log(factor))),
        "r > 0.1 at u <= 15, least share": 1.0,
        "r < 0.05 at u >= 25, sigma <= 2": 1.0,
        "intermittent share": pytest.approx(2 / 36),
    }


@pytest.mark.parametrize(
    ("low", "high", "checks"),
    [(2, 3, [1, 1, 1]), (3, 3, [1, 0, 1]), (2, 4, [1, 1, 0])],
)
def test_the_plateaus_of_the_map(low, high, checks):
    """Of 5 points at u <= 15 of each noise so many are quiet; of 8 at u >= 25 so many are not."""
    table, u, noise, disorder = map_table(laminar_fraction=np.zeros(36))
    disorder[(noise == 1)][:] = 0.1
    quiet = np.flatnonzero((u <= 15) & (noise == 1))[:low]
    disorder[quiet] = 0.1
    loud = np.flatnonzero((u >= 25) & (noise <= 2))[:high]
    disorder[loud] = 0.05
    disorder[(u >= 25) & (noise > 2)] = 1.0
    table.points["disorder_parameter"] = disorder
    found = measured("r-map", tables={"n5_map": table, "n5_rows": table})
    assert passed(found) == [*checks, 0]
    assert found.value["r > 0.1 at u <= 15, least share"] == (5 - low) / 5
    assert found.value["r < 0.05 at u >= 25, sigma <= 2"] == (8 - high) / 8
    few = cut(u[:9], noise=noise[:9], n_blocks=np.full(9, 5), disorder=disorder[:9])
    with pytest.raises(NotEnoughDataError, match="9 points shared with the rows"):
        measured("r-map", tables={"n5_map": table, "n5_rows": few})


def region(widths):
    """Map with u = 1 to 40 in which so many points from u = 10 on are intermittent."""
    u = np.tile(np.arange(1.0, 41), len(widths))
    noise = np.repeat(list(widths), 40).astype(float)
    wide = np.repeat(list(widths.values()), 40)
    return cut(
        u, noise=noise, laminar_fraction=np.where((u >= 10) & (u < 10 + wide), 0.5, 0.0),
        laminar_count=np.full(u.size, 2),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("change", "checks"),
    [
        ({}, [1, 1, 1]),
        ({0: 1}, [0, 1, 1]),
        ({4: 4, 8: 7}, [1, 1, 0]),  # means 3 and 5.67
        ({4: 3, 8: 6}, [1, 1, 1]),  # means 2.67 and 5.33
        ({1: 0, 2: 0, 4: 0}, [1, 0, 0]),
        ({1: 3, 4: 9, 9: 99}, [1, 1, 0]),
    ],
)
def test_the_region_of_intermittency_widens(change, checks):
    widths = {0: 0, 1: 2, 2: 3, 4: 1, 5: 5, 6: 5, 8: 5, 9: 0} | change
    found = measured(
        "intermittency-region", "laminar share 5 % to 95 %", tables={"n5_map": region(widths)}
    )
    weak, strong = ([widths[s] for s in levels] for levels in ((1, 2, 4), (5, 6, 8)))
    assert found.value == {
        "width at 0": widths[0],
        "mean width, 0 to 4": pytest.approx(np.mean(weak)),
        "mean width, 4 to 8": pytest.approx(np.mean(strong)),
    }
    assert passed(found) == checks and found.sample_size == 320
    del widths[1]
    with pytest.raises(NotEnoughDataError, match="three noise levels on each side of 4"):
        measured(
            "intermittency-region", "laminar share 5 % to 95 %", tables={"n5_map": region(widths)}
        )


def test_the_share_of_a_reading_is_that_of_its_name():
    table = region({0: 0, 1: 2, 2: 3, 4: 1, 5: 5, 6: 5, 8: 5})
    for share, reading in (
        (0.03, "laminar share 1 % to 99 %"),
        (0.97, "laminar share 1 % to 99 %"),
        (0.07, "laminar share 5 % to 95 %"),
        (0.93, "laminar share 5 % to 95 %"),
        (0.12, "laminar share 10 % to 90 %"),
    ):
        inside = table.points["laminar_fraction"] > 0
        table.points["laminar_fraction"][inside] = share
        order = ["laminar share 10 % to 90 %", "laminar share 5 % to 95 %"]
        order.append("laminar share 1 % to 99 %")
        seen = [
            measured("intermittency-region", name, tables={"n5_map": table}).value[
                "mean width, 4 to 8"
            ]
            > 0
            for name in order
        ]
        assert seen == [k >= order.index(reading) for k in range(3)]


@pytest.mark.parametrize(
    ("best", "interval", "posterior", "met"),
    [
        ([1.0, 1.4], (1, 1.4), 1.0, [1, 1, 1, 1]),
        ([1.0, 4.0], (1, 4), 0.5, [1, 1, 1, 0]),
        ([0.7, 4.0, 1.4], (0.7, 4), 1 / 3, [1, 1, 0, 0]),
        ([0.5], (0.5, 0.5), 0.0, [0, 0, 0, 0]),
    ],
)
def test_the_noise_of_the_experiment(best, interval, posterior, met, monkeypatch):
    monkeypatch.setattr("beltrepro.analysis.trials.BANDWIDTH", {})
    reading = "r within 10%"
    found = measured("sigma-experiment", reading, datasets=experiments(best, runs=30))
    assert found.value["sigma, 90 %"] == interval and passed(found) == met
    assert found.value["posterior of 1 to 2"] == pytest.approx(posterior)
    share = len({1.0, 1.4, 2.0} & set(best)) / 3
    assert f"{share:.2g} of the trials agree at 0.22 m/s" in found.note
    assert "before the trials 1 to 2 had 0.43" in found.note
    for other in ("r within 5%", "r within 20%"):
        assert passed(measured("sigma-experiment", other, datasets=experiments(best, runs=30)))


def test_the_noise_of_the_experiment_needs_trials_and_agreement(monkeypatch):
    monkeypatch.setattr("beltrepro.analysis.trials.BANDWIDTH", {})
    with pytest.raises(NotEnoughDataError, match="78 trials, 80 are needed"):
        measured("sigma-experiment", "r within 10%", datasets=experiments([1.0], runs=26))
    few = experiments([1.0], runs=30) | {"trials_free": experiments([1.0], runs=19)["trials_free"]}
    with pytest.raises(NotEnoughDataError, match="19 trials agree with a recording, 20 are needed"):
        measured("sigma-experiment", "r within 10%", datasets=few)
    with pytest.raises(NotEnoughDataError, match="0 and 0 of 210 trials agree"):
        measured("sigma-experiment", "r within 10%", datasets=experiments([], runs=30))


# --- evidence -------------------------------------------------------------------------------------


def test_a_cut_reads_its_points():
    made = cut([1.0, 5, 9], noise=[0, 1, 2], disorder=[0.1, 0.2, 0.3], velocities=[[1], [2], [3]])
    assert made.between(1, 5).tolist() == [True, True, False]
    assert made.between(1 + 1e-12, 9 - 1e-12).tolist() == [True, True, True]
    assert made.noise.tolist() == [0, 1, 2] and made.disorder.tolist() == [0.1, 0.2, 0.3]
    assert made.velocities.tolist() == [[1], [2], [3]]

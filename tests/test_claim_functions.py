"""Each claim function on a few made-up numbers: values, errors, counts, both sides of checks."""

import math

import numpy as np
import pytest

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


# --- evidence -------------------------------------------------------------------------------------


def test_a_cut_reads_its_points():
    made = cut([1.0, 5, 9], noise=[0, 1, 2], disorder=[0.1, 0.2, 0.3], velocities=[[1], [2], [3]])
    assert made.between(1, 5).tolist() == [True, True, False]
    assert made.between(1 + 1e-12, 9 - 1e-12).tolist() == [True, True, True]
    assert made.noise.tolist() == [0, 1, 2] and made.disorder.tolist() == [0.1, 0.2, 0.3]
    assert made.velocities.tolist() == [[1], [2], [3]]

"""Claims: the ledger is whole, and measuring all of it takes whatever data there are."""

import datetime
from pathlib import Path

import numpy as np
import pytest
import yaml

from alternating import experiments
from beltrepro.base.store import Dataset
from beltrepro.model import ChainParameters, spring
from beltrepro.replication.studies.every_claim import COLUMNS, ESTIMATE_COLUMNS, measure
from beltrepro.replication.verdicts.criteria import (
    HOLDS,
    NOT_MEASURED,
    NOT_TESTABLE,
    UNDECIDED,
    bounds,
)
from beltrepro.replication.verdicts.ledger import KINDS, REGISTRY, load_ledger
from beltrepro.replication.verdicts.ledger import SECTIONS as ledger_places
from beltrepro.stats import estimates
from recorded import recordings

CONFIG = Path(__file__).parents[2] / "config.yaml"
SETTINGS = {
    "preset": "test",
    "model": {
        "static_friction": 71.4,
        "friction_ratio": 0.45,
        "rest_length": 50,
        "linear_limit": 20,
        "compression_rate": 0.2,
        "extension_rate": 0.01,
    },
    "defaults": {"laminar_time": 200.0},
}
# Transition regions of the made-up chains, and of the paper (Fig. 19).
REGIONS = {5: (15.0, 18.0), 6: (19.0, 25.0), 7: (23.0, 32.0), 10: (27.0, 40.0)}
EVENT = [("time", "f8"), ("block", "i8"), ("kind", "U5"), ("force", "f8"), ("position", "f8")]
EVENT += [("dissipated", "f8")]


# --- made-up datasets -----------------------------------------------------------------------------


def logistic(size, rate=4.0):
    value, orbit = 0.3, np.empty(size)
    for step in range(size):
        value = rate * value * (1 - value)
        orbit[step] = value
    return orbit


CHAOS = -100 * logistic(300)


def made_up_point(n_blocks, belt_velocity, noise, rng):
    """r, section velocities, laminar share and number, last stick, as the paper would have them."""
    regular = (0.08, np.tile([-20.0, -40.0], 150), 0.0, 0, 20_000.0)
    if n_blocks < 5:
        return regular
    lower, upper = (edge + noise * (n_blocks == 5) for edge in REGIONS[n_blocks])
    if noise > 4:
        upper += 4 * (noise - 4)
    share = np.interp(belt_velocity, [lower, upper], [1.0, 0.0])
    disorder = (0.02 + 0.11 * share) * rng.normal(1, 0.01 if noise else 0.05)
    if n_blocks == 5 and noise < 0.75 and 6.4 < belt_velocity < 7.6:
        return (0.064, *regular[1:])
    if share == 0:
        return disorder, np.tile([-10.0, -12.0, -14.0], 100), 1.0, 1, 500.0
    if share < 1 and (noise > 0 or n_blocks == 10):
        return disorder, CHAOS, 1 - share, 5, 20_000.0
    if share < 0.5:
        return disorder, np.tile([-10.0, -12.0, -14.0], 100), 1.0, 1, 500.0
    return disorder, CHAOS, 0.0, 0, 20_000.0


def made_up_scan(points, transient=1e5, duration=2e5, method="verlet", runs=1):
    """A scan with so many runs at each point (N, u, sigma)."""
    rng = np.random.default_rng(7)
    points = [point for point in points for _ in range(runs)]
    rows = [made_up_point(*point, rng) for point in points]
    size = len(points)
    n_blocks, velocity, noise = (np.array(column) for column in zip(*points, strict=True))
    arrays = {
        "n_blocks": n_blocks.astype(int),
        "belt_velocity": velocity.astype(float),
        "noise": noise.astype(float),
        "replicate": np.arange(size) % runs,
        "time_step": np.full(size, 0.001),
        "method": np.full(size, method),
        "initial_spread": np.full(size, 1.0),
        "mean_length": 120.0 * n_blocks,
        "disorder_parameter": np.array([row[0] for row in rows]),
        "section_velocity": np.array([row[1] for row in rows], dtype="f4"),
        "section_count": np.full(size, 300),
        "slip_count": np.full((size, 10), 300),
        "laminar_fraction": np.array([row[2] for row in rows]),
        "laminar_count": np.array([row[3] for row in rows]),
        "laminar_longest": np.array([row[2] for row in rows]) * (duration - transient),
        "last_stick_time": np.array([row[4] for row in rows]) * duration / 20_000,
    }
    attributes = {"kind": "scan", "method": method, "transient": transient, "duration": duration}
    return Dataset(arrays, attributes)


def grid(sizes, velocities, noises):
    return [(n, float(u), float(s)) for n in sizes for s in noises for u in velocities]


def made_up_scans(**lengths):
    velocities = np.arange(1.0, 51.0)
    fine = np.arange(0.5, 50.1, 0.5)
    noises = [0, 0.5, 1, 2.2, 5, 10]
    edges = {5: 18, 6: 25, 7: 32, 10: 40}
    scans = {
        "n5_map": grid([5], velocities, range(11)),
        "n5_rows": grid([5], fine, noises[:1]) + grid([5], velocities, noises[1:]),
        "size_rows": grid([2, 3, 4, 6, 7, 10], velocities, [0, 1, 5]),
    }
    several = {
        "n5_u7": grid([5], [7.0], np.arange(0, 2.01, 0.2)),
        "n5_columns": grid([5], [20, 22, 25, 30], np.arange(0, 16.1)),
        "size_columns": [(n, u, s) for n, u in edges.items() for s in np.arange(0, 8.1)],
        "n5_replicates": grid([5], np.arange(6.0, 37, 1), noises[:5]),
        "n5_replicates_check": grid([5], np.arange(6.0, 37, 1), [0]),
        "size_replicates": grid([6, 7, 10], np.arange(8.0, 51, 2), [0, 1]),
    }
    return {name: made_up_scan(points, **lengths) for name, points in scans.items()} | {
        name: made_up_scan(points, runs=4, **lengths) for name, points in several.items()
    }


def slip_events(starts, stops, n_blocks=5):
    events = np.zeros(2 * len(starts), dtype=EVENT)
    events["time"] = np.column_stack([starts, stops]).ravel()
    events["block"] = n_blocks
    events["kind"] = np.tile(["slip", "stick"], len(starts))
    events["force"] = -71.4
    return events


def made_up_series(events, n_blocks=5, belt_velocity=1.0, noise=0.0, duration=20_000.0, **arrays):
    attributes = {"kind": "series", "method": "verlet", "duration": duration, "transient": 0.0}
    attributes |= {"n_blocks": n_blocks, "belt_velocity": belt_velocity, "noise": noise}
    if "positions" not in arrays:
        time = np.arange(0.0, duration, 0.5)
        wave = np.sin(0.1 * time * np.arange(1, n_blocks + 1)[:, None])
        arrays |= {"time": time, "positions": (50 * np.arange(1, n_blocks + 1)[:, None] + wave).T}
    return Dataset({"events": events} | arrays, attributes)


def stick_slip_series():
    """x_N whose amplitude falls as frequency**-1.21, and v_N with exact zeros between bursts."""
    rng = np.random.default_rng(1)
    size, interval = 2**16, 0.1
    frequency = np.fft.rfftfreq(size, interval)
    amplitude = np.zeros_like(frequency)
    amplitude[1:] = frequency[1:] ** -1.21
    positions = np.fft.irfft(amplitude * np.exp(2j * np.pi * rng.random(frequency.size)), size)
    starts = np.arange(50.0, 6000, 60)
    stops = starts + 9.0
    time = interval * np.arange(size)
    velocity = np.ones(size)
    for start, stop, peak in zip(starts, stops, rng.uniform(30, 90, starts.size), strict=True):
        inside = (time > start) & (time < stop)
        velocity[inside] = 1 - peak * np.sin(np.pi * (time[inside] - start) / 9.0)
    arrays = {name: np.tile(x[:, None], 5) for name, x in [("positions", 600 + positions)]}
    arrays |= {"velocities": np.tile(velocity[:, None], 5), "time": time}
    return made_up_series(slip_events(starts, stops), duration=size * interval, **arrays)


def friction_series():
    """Samples that obey the friction law: one block pulled up, slipping back, with noise."""
    rng = np.random.default_rng(2)
    size, chain = 20_000, ChainParameters(n_blocks=5, belt_velocity=1.0)
    slipping = (np.arange(size) // 1000) % 2 == 1
    positions = chain.rest_positions + rng.uniform(-30, 30, (size, 5))
    velocities = np.where(slipping[:, None], -20.0, 1.0) * np.ones((1, 5))
    kinetic = 0.45 * rng.normal(71.4, 1.0, (size, 5))
    stuck = -spring.external_force(positions, chain)
    friction = np.where(slipping[:, None], kinetic, stuck)
    starts = np.arange(1.0, 20, 2)
    arrays = {"positions": positions, "velocities": velocities, "friction": friction}
    return made_up_series(slip_events(starts, starts + 1), noise=1.0, duration=20.0, **arrays)


def laminar_series(phases, mean, **parameters):
    """Sticks every 10 time units but for so many laminar phases of a mean length."""
    starts, stops, time = [], [], 0.0
    for length in np.repeat([10.0, mean], [20, 1])[None].repeat(phases, 0).ravel():
        starts.append(time)
        time += length
        stops.append(time - 1.0)
    n_blocks = parameters.get("n_blocks", 5)
    instants = np.arange(0, time, 0.5)
    chaotic = np.random.default_rng(5).normal(120.0 * n_blocks, 60, instants.size)
    laminar = np.any(
        [
            (instants > a) & (instants < b)
            for a, b in zip(starts, stops, strict=True)
            if b - a > 100
        ],
        0,
    )
    regular = 120.0 * n_blocks + np.cos(0.1 * np.pi * np.outer(np.arange(1, 6), instants)).sum(0)
    position = np.where(laminar, regular, chaotic)[:, None] * np.ones(n_blocks)
    events = slip_events(starts, stops, n_blocks)
    return made_up_series(events, time=instants, positions=position, **parameters)


def made_up_catalogue(chains=8, per_chain=500):
    """Slip sizes ~ size**-1.47 and chain energies ~ energy**-0.87, on a Henon section."""
    rng = np.random.default_rng(3)
    size = chains * per_chain

    def power_law(exponent, low, high):
        power = 1 + exponent
        return (low**power + rng.random(size) * (high**power - low**power)) ** (1 / power)

    chain = np.repeat(np.arange(chains, dtype="i4"), per_chain)
    start = np.tile(100.0 * np.arange(per_chain), chains)
    slip = [("point", "i4"), ("block", "i4"), ("start_time", "f8"), ("stop_time", "f8")]
    slip += [("start_position", "f8"), ("stop_position", "f8"), ("dissipated", "f8")]
    slips = np.zeros(size, dtype=slip)
    slips["point"], slips["block"] = chain, 5
    slips["start_time"], slips["stop_time"] = start, start + 5
    slips["start_position"], slips["stop_position"] = power_law(-1.47, 60, 400), 0.0
    slips["dissipated"] = 30 * slips["start_position"]
    avalanche = [("point", "i4"), ("start_time", "f8"), ("stop_time", "f8"), ("dissipated", "f8")]
    avalanche += [("spring_energy_drop", "f8"), ("blocks", "i4")]
    avalanches = np.zeros(size, dtype=avalanche)
    avalanches["blocks"] = 5
    avalanches["point"] = chain
    avalanches["start_time"], avalanches["stop_time"] = start - 1, start + 8
    avalanches["dissipated"] = power_law(-0.87, 7e3, 4e4)
    avalanches["spring_energy_drop"] = avalanches["dissipated"]
    coordinates = [("positions", "f8", (5,)), ("velocities", "f8", (5,))]
    points = np.zeros(3000, dtype=[("point", "i4"), *coordinates])
    x, y = 0.1, 0.1
    for index in range(points.size):
        x, y = 1 - 1.4 * x * x + y, 0.3 * x
        points[index] = (
            index % chains,
            [50, 304.3, 400, 500 + 20 * y, 600 + 50 * x],
            [1, 1, 1, 1, -30 + 20 * y],
        )
    attributes = {"kind": "catalogue", "n_blocks": 5, "belt_velocity": 1.0, "noise": 0.0}
    return Dataset({"slips": slips, "avalanches": avalanches, "section": points}, attributes)


def made_up_escapes(members=60, duration=40_000.0):
    rng = np.random.default_rng(4)
    velocity = np.repeat(np.arange(18.0, 35.0), members)
    tau = 400 + 5600 * np.exp(-(velocity - 18) / 3)
    lifetime = rng.exponential(tau)
    size = velocity.size
    arrays = {
        "n_blocks": np.full(size, 5),
        "belt_velocity": velocity,
        "lifetime": np.minimum(lifetime, duration),
        "escaped": lifetime < duration,
        "final_disorder": np.full(size, 0.02),
        "final_stick_rate": np.zeros((size, 5)),
        "final_amplitude": np.full(size, 10.0),
    }
    return Dataset(arrays, {"kind": "escapes", "duration": duration, "settle_time": 2000.0})


EXPONENTS = 0.002 + 1e-4 * np.tile([-1.0, 1.0], 4)  # of eight runs


def made_up_motion_map(duration=2e5):
    """Chaos below the transition, fewer windows with N, periodic motion and slip beyond."""
    points = grid([2, 3, 4, 5, 6, 7, 10], np.arange(1.0, 51), [0])
    window = {5: 3, 6: 4, 7: 6}  # each so many velocities
    states = [
        ("periodic" if u % window.get(n, 99) == 0 else "chaotic")
        if n > 4 and u < REGIONS[n][0]
        else "equilibrium slip"
        if n > 4 and u > REGIONS[n][1]
        else "periodic"
        for n, u, _ in points
    ]
    n_blocks, velocity, _ = (np.array(column) for column in zip(*points, strict=True))
    arrays = {"n_blocks": n_blocks, "belt_velocity": velocity, "state": np.array(states)}
    arrays["period_returns"] = np.where(arrays["state"] == "periodic", 3, 0)
    arrays["disorder_parameter"] = np.where(arrays["state"] == "chaotic", 0.13, 0.02)
    return Dataset(arrays, {"kind": "motion", "duration": duration, "transient": duration / 2})


def made_up_survival(duration=2e5):
    """Eight runs a point: lasting chaos at u = 1 and 15, transients elsewhere."""
    velocity = np.repeat([1.0, 7, 15, 19, 21, 25, 29, 31, 35], 8)
    arrays = {"belt_velocity": velocity, "irregular_exponent": np.tile(EXPONENTS, 9)}
    mean = 400 + 5600 * np.exp(-np.abs(velocity - 18) / 3)
    lifetime = mean * np.tile(np.linspace(0.6, 1.4, 8), 9)
    lifetime[velocity == 7] = 3e4
    lifetime[np.isin(velocity, [1, 15])] = duration
    lifetime = np.minimum(lifetime, duration)
    arrays |= {"lifetime": lifetime, "settled": lifetime < duration}
    arrays["state"] = np.where(arrays["settled"], "periodic", "irregular")
    arrays["period_returns"] = np.where(arrays["settled"], 3, 0)
    arrays |= {"irregular_error": np.full(velocity.size, 1e-4), "irregular_time": lifetime}
    arrays = {name: np.tile(values, 2) for name, values in arrays.items()}
    arrays["initial_spread"] = np.repeat([1.0, 10.0], velocity.size)
    arrays["n_blocks"] = np.full(2 * velocity.size, 5)
    return Dataset(arrays, {"kind": "settling", "duration": duration})


def made_up_noisy_motion():
    """At u = 7, chaos from sigma = 0.75 on."""
    noise = np.repeat([0.25, 0.5, 1, 1.5, 2.2], 8)
    exponent = np.where(noise > 0.75, np.tile(EXPONENTS, 5), 0.0)
    arrays = {"noise": noise, "largest_exponent": exponent}
    arrays |= {"n_blocks": np.full(noise.size, 5), "belt_velocity": np.full(noise.size, 7.0)}
    return Dataset(arrays, {"kind": "motion", "duration": 2e5, "transient": 1e5})


def made_up_motions(**lengths):
    return {
        "motion_map": made_up_motion_map(**lengths),
        "survival": made_up_survival(**lengths),
        "noisy_motion": made_up_noisy_motion(),
    }


@pytest.fixture(scope="module", autouse=True)
def few_resamples():
    """Intervals as such are tested elsewhere."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(estimates, "RESAMPLES", 40)
        yield


@pytest.fixture(scope="module")
def paper_like():
    """Verdicts for datasets made up to agree with the paper, by id."""
    escape = slip_events([*np.arange(0, 4000.0, 20), 4000.0], [*np.arange(5, 4005.0, 20), 4005.0])
    series = {
        "friction_event": friction_series(),
        "u1": stick_slip_series(),
        "u20": made_up_series(escape, belt_velocity=20.0, duration=12_000.0),
        "u17": laminar_series(8, 400.0, noise=2.2, duration=9000.0),
        "n10_u28": laminar_series(10, 250.0, n_blocks=10, belt_velocity=28.0, duration=9000.0),
        "n10_u31": laminar_series(10, 300.0, n_blocks=10, belt_velocity=31.0, duration=9000.0),
        "n10_u34": laminar_series(8, 500.0, n_blocks=10, belt_velocity=34.0, duration=9000.0),
        "n10_u38": laminar_series(4, 1500.0, n_blocks=10, belt_velocity=38.0, duration=9000.0),
    }
    others = {"slips_u1": made_up_catalogue(), "lifetimes": made_up_escapes()}
    others |= experiments([1.0, 1.4, 2.0], runs=30)
    others |= recordings()
    return measure(made_up_scans() | made_up_motions() | series | others, SETTINGS)


def verdicts(measured):
    counted = measured.claims[measured.claims["variant"] == ""]
    return dict(zip(counted["id"], counted["verdict"], strict=True))


# --- ledger ---------------------------------------------------------------------------------------


def test_every_claim_has_a_function_in_the_module_of_its_section():
    ledger = load_ledger()
    assert set(REGISTRY) <= set(ledger)
    sections = {name: place.replace("/", ".") for name, place in ledger_places.items()}
    for claim in ledger.values():
        assert claim.section in sections and claim.kind in KINDS
        if claim.testable:
            assert (
                REGISTRY[claim.id].__module__
                == f"beltrepro.replication.studies.{sections[claim.section]}"
            )
        assert bool(claim.open) == bool(claim.reading)
        assert claim.testable or claim.id in REGISTRY or claim.reason


def test_every_criterion_can_hold_and_can_fail_and_says_when_it_was_written():
    for claim in load_ledger().values():
        criterion = claim.criterion
        assert criterion.keys() <= {"allowed", "text", "version", "since", "changed"}, claim.id
        assert criterion["text"]
        if not claim.testable:
            continue
        assert isinstance(criterion["since"], datetime.date) and criterion["version"] >= 1
        assert criterion["version"] == 1 or criterion["changed"], claim.id
        ends = [bounds(allowed) for allowed in criterion["allowed"].values()]
        assert all(low <= high and (low, high) != (-np.inf, np.inf) for low, high in ends), claim.id


def test_the_datasets_that_claims_need_are_in_the_configuration():
    config = yaml.safe_load(CONFIG.read_text())
    known = set(config["datasets"]) | {f"{film}_track" for film in config["films"]}
    needed = {name for claim in load_ledger().values() for name in claim.needs}
    assert needed <= known


def test_what_is_true_by_construction_is_marked():
    marked = {claim.id for claim in load_ledger().values() if not claim.finding}
    assert marked == {"units", "friction-constants", "spring-law", "friction-law", "setup"}


# --- made-up data ---------------------------------------------------------------------------------


@pytest.mark.thorough
def test_data_like_the_papers_make_its_claims_hold(paper_like):
    found = verdicts(paper_like)
    holding = ("units", "setup", "friction-law", "r-jump", "u-critical", "slip-size-exponent")
    holding += ("u15-aperiodic", "sigma-c-u7", "uc-sigma22", "r-of-sigma")
    expected = dict.fromkeys(holding, HOLDS)
    assert {name: found[name] for name in holding} == expected, paper_like.claims
    assert_no_fault(paper_like)


@pytest.mark.thorough
def test_the_tables_have_the_promised_layout(paper_like):
    claims, estimates = paper_like.claims, paper_like.estimates
    assert list(claims.columns) == list(COLUMNS)
    assert list(estimates.columns) == list(ESTIMATE_COLUMNS)
    assert list(claims.loc[claims["variant"] == "", "id"]) == list(load_ledger())
    assert claims.map(lambda cell: isinstance(cell, str)).all(axis=None)
    judged = estimates[estimates["verdict"] != ""]
    assert judged["allowed_low"].notna().all() and set(judged["id"]) <= set(claims["id"])
    measured = claims[(claims["variant"] == "") & ~claims["verdict"].isin([NOT_MEASURED])]
    ledger = load_ledger()
    for claim in map(ledger.get, measured["id"]):
        own = judged[(judged["id"] == claim.id) & (judged["variant"] == "")]
        assert list(own["name"]) == list(claim.criterion.get("allowed", {})), claim.id


# --- too little data ------------------------------------------------------------------------------


def assert_no_fault(measured):
    notes = measured.claims["note"]
    assert not notes.str.contains("fault in its code").any(), notes.tolist()


def test_without_datasets_all_but_the_model_is_not_measured():
    found = measure({}, SETTINGS)
    assert_no_fault(found)
    model = {"units", "friction-constants", "spring-law", "setup"}
    for name, verdict in verdicts(found).items():
        assert verdict == (HOLDS if name in model else NOT_MEASURED), name
    claims = found.claims
    assert (claims.loc[claims["verdict"] == NOT_MEASURED, "note"] != "").all()


def test_short_runs_are_not_judged():
    short = made_up_scans(transient=500.0, duration=2000.0) | made_up_motions(duration=2000.0)
    found = measure(short, SETTINGS)
    assert_no_fault(found)
    assert set(verdicts(found).values()) <= {HOLDS, NOT_MEASURED, NOT_TESTABLE, UNDECIDED}
    notes = found.claims.set_index("id").loc["u-critical", "note"]
    assert "discards a transient of 500" in str(notes)


@pytest.mark.parametrize("transient", [500.0, 1e5])
def test_tiny_and_empty_datasets_cause_no_fault(transient):
    coarse = made_up_scans(transient=transient)
    for scan in coarse.values():
        keep = np.arange(scan.arrays["noise"].size) % 17 == 0
        for name in scan.arrays:
            scan.arrays[name] = scan.arrays[name][keep]
        scan.arrays["section_velocity"][::2] = np.nan
    empty = slip_events([], [])
    nothing = {name: np.zeros((20, 5)) for name in ("positions", "velocities", "friction")}
    names = ("friction_event", "u1", "u20", "u17", "n10_u28", "n10_u31", "n10_u34", "n10_u38")
    series = {name: made_up_series(empty, time=np.arange(20.0), **nothing) for name in names}
    catalogue = made_up_catalogue()
    for name in catalogue.arrays:
        catalogue.arrays[name] = catalogue.arrays[name][:3]
    others = {"slips_u1": catalogue, "lifetimes": made_up_escapes(members=2)}
    motions = made_up_motions()
    for dataset in motions.values():
        for name in dataset.arrays:
            dataset.arrays[name] = dataset.arrays[name][::7]
    motions["survival"].arrays["irregular_exponent"][:] = np.nan
    data = coarse | series | others | motions
    found = measure(data, SETTINGS)
    assert_no_fault(found)
    for name in catalogue.arrays:
        catalogue.arrays[name] = catalogue.arrays[name][:0]
    assert_no_fault(measure({"slips_u1": catalogue}, SETTINGS))

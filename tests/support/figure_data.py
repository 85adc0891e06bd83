"""Made-up data for every figure, in which each number tells where it belongs.

r of a point is a formula of the dataset, N, u and sigma that differs between any two points, and
rows of a scan come in no order.
"""

import functools
import importlib
import itertools

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text
from numpy.lib.recfunctions import append_fields

import alternating
import irregular
import recorded
from beltrepro.base.store import Dataset
from beltrepro.replication.plan import attractors as attracted
from beltrepro.replication.plan import registry
from beltrepro.replication.studies.integrators import measure as integrators
from made_up import LAW

HOW = {
    "preset": "smoke",
    "method": "verlet",
    "time_step": 0.001,
    "duration": 2000.0,
    "transient": 500.0,
    "laminar_time": 200.0,
    "seed": 1,
    "code_version": "0.0+gabc",
}
EVENT = [("time", "f8"), ("block", "i8"), ("kind", "U5")]
U = np.arange(2.0, 50, 3)
LEVELS = (0.0, 0.25, 0.5, 1.0, 2.2, 5.0, 10.0)
SIZES = (2, 3, 4, 6, 7, 10)
# Numbers of blocks, belt velocities and noises of each scan; more than its figures may show.
SCANS = {
    "n5_density": ((4, 5), U, LEVELS),
    "n5_map": ((4, 5), U, np.arange(0.0, 10.1, 2.5)),
    "n5_u7": ((5, 6), (6.0, 7.0, 8.0), np.arange(0.0, 2.1, 0.25)),
    "n5_columns": ((5, 6), (20.0, 30.0, 40.0), np.arange(0.0, 10.1, 2)),
    "size_density": (SIZES, U, (0.0, 1.0, 5.0)),
    "size_columns": ((5, 7, 10), (18.0, 32.0), np.arange(0.0, 10.1, 2)),
    "n5_rows": ((4, 5), U, (0.0, 10.0)),
    "size_rows": (SIZES, U, (0.0,)),
    "n5_rows_check": ((5, 6), U[::2], (0.0,)),
    "n5_replicates": ((4, 5), U[2:11], (0.0, 0.5, 1.0, 2.2, 5.0)),
    "n5_replicates_check": ((5,), U[1:11], (0.0,)),
    "n5_replicates_wide": ((5,), U[2:11], (0.0,)),
    "size_replicates": ((6, 7, 10), U[3:], (0.0, 1.0)),
}
SCATTER = np.array([-2e-3, 0.0, 9e-3])  # of r about its median: mean and median differ
CROSSINGS = 12
V_BINS = np.linspace(-120.0, 0.0, 121)


# --- scans ----------------------------------------------------------------------------------------


def r(name, n, u, s):
    """Disorder parameter of a point; falls beyond u = 15 + 2 * sigma + N and rises with sigma."""
    high = u < 15 + 2 * s + n if name != "n5_u7" else s > 0.9
    number = list(SCANS).index(name) + 1
    return (0.12 if high else 0.03) + 1e-4 * u + 2e-5 * s + 7e-7 * n + 1e-8 * number


def crossings(name, n, u, s):
    """Velocities at the section of a point, one of them far off; the last two are missing."""
    number = list(SCANS).index(name) + 1
    values = -0.3 * u - 1e-2 * n - 0.5 * s - 1e-3 * number - 0.011 * np.arange(CROSSINGS)
    values[0] -= 60
    values[-2:] = np.nan
    return values


def histogram(name, n, u, s):
    """Crossings of a point in each bin."""
    return np.histogram(crossings(name, n, u, s)[:-2], V_BINS)[0].astype(np.uint32)


def laminar(u, s):
    """Share of laminar phases: intermittent from 14 + sigma to 26 + 2 sigma with noise."""
    return np.where((s > 1) & (u > 14 + s) & (u < 26 + 2 * s), 0.5, 0.99)


def scan(name):
    """Three replicates of every point."""
    sizes, velocities, noises = SCANS[name]
    grid = [(n, u, s, k) for n in sizes for u in velocities for s in noises for k in range(3)]
    grid = np.random.default_rng(3).permutation(np.array(grid))
    n, u, s, replicate = grid.T
    replicate = replicate.astype(int)
    # without noise ten blocks slip for good beyond u = 30, but in replicate 2: 1760 and 1840 are
    # 1.2 and 0.8 laminar times before the end
    ended = (n == 10) & (u > 30) & (s == 0)
    arrays = {
        "n_blocks": n.astype(int),
        "belt_velocity": u,
        "noise": s,
        "replicate": replicate,
        "disorder_parameter": np.array([r(name, *row[:3]) for row in grid]) + SCATTER[replicate],
        "section_position": 111.0 * n,
        "laminar_fraction": laminar(u, s),
        "laminar_count": np.where(laminar(u, s) == 0.5, 9, 1),
        "last_stick_time": np.where(ended, np.array([np.nan, 1760, 1840])[replicate], 1840.0),
    }
    if name.endswith("density"):
        counts = [histogram(name, *row[:3]) for row in grid]
        arrays |= {"section_histogram": np.array(counts), "section_bins": V_BINS}
    else:
        arrays["section_velocity"] = np.array([crossings(name, *row[:3]) for row in grid])
    # replicates are exact, and their check is by the scheme; other scans are the other way round
    exact = name.endswith("_check") != name.startswith("n5_replicates")
    method = "event" if exact else "verlet"
    arrays["method"] = np.full(s.size, method)
    return Dataset(arrays, HOW | {"kind": "scan", "method": method})


# --- series and catalogues ------------------------------------------------------------------------


def series(n_blocks, belt_velocity, noise, *, length=2000, interval=2.0, transient=500.0):
    """Samples without any pattern, all different; blocks stick at every tenth one.

    The last block slips twice for longer than 200 after the transient; so does block 1, elsewhere.
    """
    rng = np.random.default_rng(int(10 * belt_velocity))
    time = interval * np.arange(length)
    velocities = belt_velocity - rng.uniform(1, 50, (length, n_blocks))
    velocities[::10] = belt_velocity
    positions = 60.0 * np.arange(1, n_blocks + 1) + rng.uniform(0, 20, (length, n_blocks))
    slips = [(block, *slip) for block in (1, n_blocks) for slip in long_slips(time[-1], block)]
    events = [(begin, block, "slip") for block, begin, _ in slips]
    events += [(end, block, "stick") for block, _, end in slips]
    arrays = {"time": time, "positions": positions, "velocities": velocities}
    arrays["events"] = np.sort(np.array(events, EVENT), order="time")
    chain = {"n_blocks": n_blocks, "belt_velocity": belt_velocity, "noise": noise}
    span = {"transient": transient, "duration": float(time[-1]), "kind": "series"}
    return Dataset(arrays, HOW | LAW | chain | span)


def moved(data):
    """The same with a start that is moved, and a last block that sticks no more from t = 3000."""
    late = data.arrays["time"] > 3000
    velocities = np.where(late[:, None], -5.0, data.arrays["velocities"])
    arrays = data.arrays | {"velocities": velocities}
    return Dataset(arrays, data.attributes | {"initial_spread": 0.001})


def long_slips(end, block):
    """(begin, end) of slips: the first is too short, the last too early."""
    late = end - 100 * block
    return [(late - 3000, late - 2810), (late - 2000, late - 1500), (late - 900, late), (0, 450)]


def friction_event():
    """Block 5 of 5 sticks from 5 to 9, slips to 14; block 4 moves at other times."""
    data = series(5, 1.0, 1.0, length=3000, interval=0.01)
    events = [(2, 4, "slip"), (5, 5, "stick"), (9, 5, "slip"), (12, 4, "stick"), (14, 5, "stick")]
    friction = np.random.default_rng(9).uniform(-70, 70, data.arrays["positions"].shape)
    law = {"static_friction": 80.0, "friction_ratio": 0.4, "rest_length": 55.0}
    law |= {"linear_limit": 18.0, "compression_rate": 0.21, "extension_rate": 0.012}
    arrays = data.arrays | {"events": np.array(events, EVENT), "friction": friction}
    return Dataset(arrays, data.attributes | law)


def catalogue(n_blocks=5, *, count=1200):
    """Slips of the last two blocks in two chains, each an avalanche."""
    rng = np.random.default_rng(n_blocks + 3)
    names = ["start_time", "stop_time", "start_position", "stop_position", "dissipated"]
    slips = np.zeros(count, [("point", "i4"), ("block", "i4"), *[(name, "f8") for name in names]])
    slips["point"] = np.arange(count) % 2
    slips["block"] = n_blocks - 1 + np.arange(count) // 2 % 2
    slips["start_time"] = 100.0 * np.arange(count)
    slips["stop_time"] = slips["start_time"] + rng.uniform(1, 9, count)
    slips["stop_position"] = rng.uniform(-5, 5, count)
    slips["start_position"] = slips["stop_position"] + 10 * (1 - 0.99 * rng.random(count)) ** -0.8
    slips["dissipated"] = 3 * (1 - 0.99 * rng.random(count)) ** -0.7
    events = slips[["point", "start_time", "stop_time", "dissipated"]].copy()
    events["dissipated"] = n_blocks**2 * (1 - 0.99 * rng.random(count)) ** -0.7
    size = slips["start_position"] - slips["stop_position"]
    more = {
        "slips": np.ones(count, dtype=int),
        "blocks": np.full(count, 2),
        "spring_energy_drop": 1.1 * events["dissipated"],
        "last_block_displacement": np.where(slips["block"] == n_blocks, size, 0.0),
    }
    events = append_fields(events, list(more), list(more.values()), usemask=False)
    fields = [("point", "i4"), ("time", "f8")]
    fields += [("positions", "f8", n_blocks), ("velocities", "f8", n_blocks)]
    states = np.zeros(900, fields)
    states["point"] = np.arange(900) % 2
    states["positions"] = 300 + rng.uniform(0, 90, (900, n_blocks))
    states["velocities"] = 1.5 - rng.uniform(0, 40, (900, n_blocks))
    chain = {"n_blocks": n_blocks, "belt_velocity": 1.5, "noise": 0.0, "kind": "catalogue"}
    return Dataset({"slips": slips, "avalanches": events, "section": states}, HOW | chain)


def section(method="verlet", count=900):
    """Position and velocity of the last block at a section; it sticks at every seventh point."""
    rng = np.random.default_rng(len(method))
    fields = [("point", "i4"), ("position", "f4"), ("velocity", "f4")]
    crossings = np.zeros(count, fields)
    crossings["position"] = 520 + rng.uniform(0, 180, count)
    crossings["velocity"] = 1.5 - rng.uniform(1, 40, count)
    crossings["velocity"][::7] = 1.5
    about = {"n_blocks": 5, "belt_velocity": 1.5, "noise": 0.0}
    about |= {"section_block": 3, "section_position": 271.5, "kind": "section", "method": method}
    return Dataset({"crossings": crossings}, HOW | about)


# --- long runs without noise ----------------------------------------------------------------------


def lifetimes():
    """At u = 18, 20 and 30 four, five and two of six runs escape."""
    escaped = np.array([[1, 1, 1], [1, 1, 1], [1, 1, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]], bool)
    u = np.tile([18.0, 20.0, 30.0], 6)
    arrays = {"belt_velocity": u, "lifetime": 100.0 + 10 * np.arange(18) + u}
    arrays |= {"escaped": escaped.ravel(), "n_blocks": np.full(18, 5)}
    return Dataset(arrays, HOW | {"kind": "escapes", "noise": 0.0, "settle_time": 500.0})


def critical_velocities():
    rows = [
        ("n5_replicates", 5, 0.0, 18.0, 17.5, 18.6, 17.0, 19.0),
        ("n5_replicates", 5, 1.0, 18.5, 18.2, 18.8, 18.0, 19.2),
        ("n5_replicates", 5, 2.2, *[np.nan] * 5),
        ("n5_replicates_check", 5, 0.0, 19.5, 19.1, 20.1, 17.5, 21.5),
        ("n5_replicates_wide", 5, 0.0, 17.5, np.nan, np.nan, 16.5, 18.5),
        ("size_replicates", 7, 0.0, 28.0, 27.0, 29.0, 26.0, 30.0),
        ("size_replicates", 7, 1.0, *[np.nan] * 5),
        ("size_replicates", 10, 0.0, *[np.nan] * 5),
        ("size_replicates", 10, 1.0, *[np.nan] * 5),
    ]
    names = ["dataset", "n_blocks", "noise", "critical", "low", "high", "lower", "upper"]
    return pd.DataFrame(rows, columns=names)


ENDS = [3.0, 12.0, 30.0]  # belt velocities of the runs that settle


@functools.cache
def settling():
    """Datasets of the end of irregular motion, and the table of their lifetimes."""
    made = irregular.survivals(n_blocks=[4, 6, 7, 10], belt_velocity=ENDS, initial_spread=[1, 10.0])
    return made | {"mean_lifetimes": table("mean_lifetimes", made)}


# --- both integrators -----------------------------------------------------------------------------

PAIRED_U, RUNS = (10.0, 30.0, 50.0), 9


def paired(side, method):
    """Noisy runs, and runs at their end, by one of the integrators; in no order."""
    rng = np.random.default_rng(side)

    def runs(**axes):
        grid = np.array(list(itertools.product(PAIRED_U, *axes.values(), range(RUNS))))
        columns = rng.permutation(grid).T[:-1]
        columns = dict(zip(["belt_velocity", *axes], columns, strict=True))
        return columns | {"n_blocks": np.full(len(grid), 5)}

    noisy, ends = (
        runs(noise=(1.0, 5.0)),
        runs(initial_spread=(0.001, 1.0), time_step=(0.001, 0.002)),
    )
    noisy["disorder_parameter"] = 0.001 * noisy["belt_velocity"] + rng.normal(0.05, 0.01, 54)
    ends |= {"noise": np.zeros(108), "escaped": np.ones(108, dtype=bool)}
    ends |= {"lifetime": np.arange(108.0), "final_disorder": rng.uniform(0.01, 0.2, 108)}
    ends["final_stick_rate"] = np.outer(rng.random(108) < 0.6, [0, 0, 0, 0, 1.0])
    kinds = {"pairs_r": noisy, "pairs_states": ends}
    about = HOW | {"method": method}
    return {f"{name}_{method}": Dataset(arrays, about) for name, arrays in kinds.items()}


@functools.cache
def pairs():
    """The runs by both integrators, and the comparisons of r and of the states reached."""
    made = paired(1, "verlet") | paired(2, "event")
    sides = {name: [made[f"pairs_{name}_{method}"] for method in ("verlet", "event")]
             for name in ("r", "states")}  # fmt: skip
    columns = {name: name for name in ("n_blocks", "belt_velocity", "noise")}
    columns[integrators.DISORDER] = "disorder_parameter"
    noisy = [pd.DataFrame({name: side.arrays[column] for name, column in columns.items()})
             for side in sides["r"]]  # fmt: skip
    rows = [*integrators.compare_points(*noisy), *integrators.compare_attractors(*sides["states"])]
    return made | {"agreement": pd.DataFrame(rows)}


# --- branches and basins ---


def basins(sizes=(5,)):
    """Two branches for each N; slipping starts reach that of small r from a lower u on."""
    n, u, run = map(np.ravel, np.meshgrid(sizes, np.arange(10.0, 40.0, 5), range(4), indexing="ij"))
    energies = np.array([0.0, 60.0, 600.0])
    small = (u + 2 * run)[:, np.newaxis] > 15 + n[:, np.newaxis] + np.arange(3) * 3
    first = np.flatnonzero(run == 0)
    attractors = np.zeros(2 * first.size, attracted.ATTRACTOR)
    attractors["point"], attractors["attractor"] = np.repeat(first, 2), np.tile([1, 2], first.size)
    attractors["state"], attractors["period_events"] = "periodic", 9
    attractors["disorder_parameter"] = np.tile([0.12, 0.012], first.size)
    begin = first[:: first.size // len(sizes)]
    branches = np.zeros(6 * len(sizes), attracted.BRANCH)
    branches["point"] = np.repeat(begin, 6)
    branches["attractor"] = np.tile([1, 1, 1, 2, 2, 2], len(sizes))
    branches["belt_velocity"] = np.tile([10, 15, 21, 17, 25, 35.5], len(sizes))
    branches["disorder_parameter"] = np.tile([0.12, 0.12, 0.13, 0.014, 0.013, 0.012], len(sizes))
    branches["end"] = np.tile(["edge", "", "fold", "grazing", "", "grazing"], len(sizes))
    branches["period_events"] = 9
    arrays = {"n_blocks": n, "belt_velocity": u, "replicate": run, "start_energy": energies}
    arrays |= {
        "attractor": np.where(small, 2, 1),
        "state": np.where(small, "periodic", "irregular"),
        "lifetime": np.where(small, 500.0, 3000.0),
        "period_events": np.where(small, 9, 0),
        "disorder_parameter": np.where(small, 0.012, 0.13),
        "attractors": attractors,
        "branches": branches,
    }
    return Dataset(arrays, HOW | {"kind": "basins"})


def sweeps(hold):
    """r falls later on the way up than it rises on the way down, the less the slower."""
    noise, u, run = map(np.ravel, np.meshgrid([0.0, 1.0], np.arange(10.0, 40, 5), range(3)))
    late = np.array([1, -1]) * (6 - np.log10(hold))
    small = (u + run)[:, np.newaxis] > 20 + late
    arrays = {"n_blocks": np.full(u.size, 5), "noise": noise, "belt_velocity": u, "replicate": run}
    arrays |= {"disorder_parameter": np.where(small, 0.02, 0.13)}
    return Dataset(arrays, HOW | {"kind": "sweep", "duration": hold})


def small_orbits():
    """Births on straight lines with linear springs, and lower with others."""
    events, linear, ratio = map(np.ravel, np.meshgrid([5, 23], [0, 1], [0.3, 0.5, 0.7]))
    births = np.zeros(ratio.size, attracted.BIRTH)
    births["point"], births["period_events"], births["friction_ratio"] = linear, events, ratio
    births["belt_velocity"] = (0.4 + 0.1 * linear - events / 400) * (1 - ratio) * 71.4
    births["disorder_parameter"], births["end"] = 0.01, "grazing"
    arrays = {"linear_limit": np.array([20.0, 1e9]), "static_friction": np.full(2, 71.4)}
    return Dataset(arrays | {"births": births}, HOW | {"kind": "births"})


def friction_map():
    """r falls at 0.5 u*, where at u = 18 of the smallest ratio one run is early."""
    ratio, u = map(np.ravel, np.meshgrid([0.3, 0.4, 0.5, 0.6, 0.7], np.arange(5.0, 31, 0.5)))
    small = (u > 0.5 * (1 - ratio) * 71.4) | ((ratio == 0.3) & (u == 18))
    arrays = {"n_blocks": np.full(u.size, 5), "friction_ratio": ratio, "belt_velocity": u}
    return Dataset(arrays | {"disorder_parameter": np.where(small, 0.015, 0.12)}, HOW)


def fall_orbits():
    """Below 17 no run ends at small r, above every second, on one orbit after the other."""
    u, run = map(np.ravel, np.meshgrid(np.arange(14.0, 22, 0.1), range(8)))
    small = (u > 17.05) & (run % 2 == 0)
    small_orbits, others = np.array([5, 11, 23, 48]), np.array([33, 60, 900, 0])
    slips = np.where(small, small_orbits[run // 2], others[run // 2])
    arrays = {"n_blocks": np.full(u.size, 5), "belt_velocity": u, "period_events": slips}
    arrays["state"] = np.where(slips, "periodic", "irregular")
    arrays |= {"settled": slips > 0, "lifetime": np.where(slips, 100.0 + run, 2000.0)}
    arrays["initial_spread"] = np.full(u.size, 7.0)
    return Dataset(arrays | {"disorder_parameter": np.where(small, 0.015, 0.12)}, HOW)


def chaos_ends(velocities, lasts):
    """Lifetimes and periods of a few sizes; from one velocity on no run settles."""
    u, run = map(np.ravel, np.meshgrid(velocities, range(3)))
    settled = u < lasts
    arrays = {"n_blocks": np.full(u.size, 5), "belt_velocity": u, "settled": settled}
    arrays["lifetime"] = np.where(settled, 10.0 ** (2 + run), 1e5)
    arrays["period_events"] = np.where(settled, 10 ** (1 + run), 0)
    return Dataset(arrays, HOW)


def disturbances(shares):
    """Of ten runs at each u above 17.2 so many are at small r, by noise."""
    noise, u, run = map(np.ravel, np.meshgrid([*shares], np.arange(16.0, 22.1, 0.25), range(10)))
    small = (u > 17.2) & (run < 10 * np.vectorize(shares.get, otypes=[float])(noise))
    arrays = {"n_blocks": np.full(u.size, 5), "belt_velocity": u, "noise": noise, "replicate": run}
    return Dataset(arrays | {"disorder_parameter": np.where(small, 0.015, 0.12)}, HOW)


@functools.cache
def branching():
    """The datasets and tables of the study of the fall."""
    made = {"basins": basins()}
    made |= {"small_orbits": small_orbits(), "friction_map": friction_map()}
    made["fall_orbits"] = fall_orbits()
    made["chaos_ends"] = chaos_ends(np.arange(9.0, 17, 0.1), 16.55)
    made["chaos_ends_near"] = chaos_ends(10.74 + 0.0005 * np.arange(40), 10.755)
    holds = {"sweeps": 1000.0, "sweeps_fast": 200.0, "sweeps_slow": 5000.0}
    made |= {name: sweeps(hold) for name, hold in holds.items()}
    tables = "basin_shares", "sweep_falls", "birth_lines", "fall_onsets", "fall_shares"
    made["disturbances"] = disturbances({0.0: 0.6, 1e-4: 0.6, 1e-2: 0.9, 1.0: 0.3})
    made["disturbances_scheme"] = disturbances({0.0: 0.9})
    made |= {name: dataset(name) for name in ("motion_map", "survival")}
    tables += "chaos_lifetimes", "disturbance_shares", "contraction"
    return made | {name: table(name, made) for name in tables}


# --- all of them ----------------------------------------------------------------------------------


def table(name, data):
    """A table as the workflow makes it."""
    module = importlib.import_module(registry.tables()[name].module)
    return getattr(module, name)(data)


def every(names):
    """The datasets and tables of these names."""
    return {name: dataset(name) for name in names}


@functools.cache
def recordings():
    return recorded.recordings(seconds=300, calm=(90, 210))


@functools.cache
def trials():
    return alternating.studies(runs=16)


@functools.cache
def dataset(name):
    """The dataset or table of this name; do not change it in place."""
    made = {
        "friction_event": friction_event,
        "u1": lambda: series(5, 1.0, 0.0, length=12_000),
        "u20": lambda: series(5, 20.0, 0.0, transient=0.0),
        "u20_slips": lambda: moved(series(5, 20.0, 0.0, length=2500, transient=0.0)),
        "u17": lambda: series(5, 17.5, 2.2, length=8000),
        "u19": lambda: series(5, 19.0, 2.2, length=9000),
        "slips_u1": catalogue,
        "slips_u1_event": catalogue,
        "section_u1": section,
        "section_u1_event": lambda: section(method="event"),
        "lifetimes": lifetimes,
        "lifetimes_wide": lifetimes,
        "motion_map": lambda: irregular.motion(n_blocks=[5, *SIZES], belt_velocity=ENDS, runs=3),
        "noisy_motion": lambda: irregular.motion(
            n_blocks=[5], belt_velocity=[7.0, 16.0], noise=[0.25, 1.0, 2.2, 5.0, 10.0], runs=3
        ),
        "motions": lambda: table("motions", every(["motion_map"])),
        "critical_velocities": critical_velocities,
    }
    made |= {name: functools.partial(scan, name) for name in SCANS}
    made |= {
        f"n10_u{u}": lambda u=u: series(10, u, 0.0, length=5500 + 9 * u) for u in (28, 31, 34, 38)
    }
    made["u1_event"] = made["u1"]
    made |= {
        f"slips_n{n}{method}": lambda n=n: catalogue(n, count=4800 + n)
        for n in (3, 7, 10)
        for method in ("", "_event")
    }
    groups = {
        "belt_": recordings, "trials": trials,
        "basin": branching, "sweep": branching,
        "small_orbits": branching, "birth_lines": branching,
        "friction_map": branching, "fall_": branching, "chaos_": branching,
        "disturbance": branching, "contraction": branching,
        "experiment_odds": trials, "alternation": trials,
        "agreement": pairs, "pairs": pairs,
    }  # fmt: skip
    if name in made:
        return made[name]()
    group = next((make for start, make in groups.items() if name.startswith(start)), settling)
    return group()[name]


def data_of(figure, *, also=(), **changed):
    """What a figure uses, checks by the other integrator included, with some of it `changed`."""
    names = (*registry.figures()[figure].uses, *also)
    return {name: changed[name] if name in changed else dataset(name) for name in names} | changed


def draw(figure, data):
    """A figure, as wide as a column of the paper, or as both, and legible there."""
    made = getattr(importlib.import_module(registry.figures()[figure].module), figure)(data)
    sizes = {text.get_text(): text.get_size() for text in made.findobj(Text) if text.get_text()}
    assert made.get_figwidth() * 2.54 == pytest.approx(17.8 if figure == "fig22" else 8.6)
    assert min(sizes.values(), default=8) >= 7.8, sizes  # points, of capitals of 2 mm
    return made

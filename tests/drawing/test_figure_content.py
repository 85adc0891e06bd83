"""What each figure plots: the right rows, in the right panel, under the right words.

Every number in the datasets made up here tells where it belongs: r of a point is a formula of the
dataset, N, u and sigma, which differs between any two points. What a figure must show is written
down from the formulas, without the functions that cut rows out of files.
"""

import dataclasses
import importlib
import itertools
import re

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import naive
import recorded
from alternating import studies
from beltrepro.base.store import Dataset
from beltrepro.model import ChainParameters
from beltrepro.model.units import LENGTH_M
from beltrepro.replication.camera import recording
from beltrepro.replication.drawing import motion_panels as motions
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.drawing.content import content
from beltrepro.replication.plan import registry
from beltrepro.replication.studies.avalanches import measure as avalanches
from beltrepro.replication.studies.integrators import divergence, measure, samples
from beltrepro.replication.studies.integrators.steps import FORCE_ORDER
from beltrepro.stats import intermittency, spectra, transitions
from irregular import motion

FIGURES = registry.figures()
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
RNG = np.random.default_rng(3)

U = np.arange(2.0, 50, 3)
LEVELS = (0.0, 0.25, 0.5, 1.0, 2.2, 5.0, 10.0)
SIZES = (2, 3, 4, 6, 7, 10)
CROSSINGS = 12
# The points of each scan: sizes, belt velocities, noises. A check is drawn over another scan.
SCANS = {
    "n5_rows": ((4, 5), U, LEVELS),
    "n5_map": ((4, 5), U, np.arange(0.0, 10.1, 2.5)),
    "n5_u7": ((5, 6), (6.0, 7.0, 8.0), np.arange(0.0, 2.1, 0.25)),
    "n5_columns": ((5, 6), (20.0, 30.0, 40.0), np.arange(0.0, 10.1, 2)),
    "size_rows": (SIZES, U, (0.0, 1.0, 5.0)),
    "size_columns": ((5, 7, 10), (18.0, 32.0), np.arange(0.0, 10.1, 2)),
    "n5_rows_check": ((5, 6), U[::2], (0.0, 1.0)),
    "size_rows_check": ((2, 6), U[::2], (0.0, 1.0)),
    "n5_columns_check": ((5,), (20.0, 40.0), np.arange(0.0, 10.1, 5)),
    "size_columns_check": ((5, 7), (18.0,), np.arange(0.0, 10.1, 5)),
    "n5_replicates": ((4, 5), U[2:11], (0.0, 0.5, 1.0, 2.2, 5.0)),
    "n5_replicates_check": ((5,), U[2:11:2], (0.0,)),
    "size_replicates": ((6, 7, 10), U[3:], (0.0, 1.0)),
}
SCATTER = np.array([-2e-3, 0.0, 9e-3])  # of r about its median, in the replicates


# --- datasets whose numbers tell where they belong ------------------------------------------------


def r(name, n, u, s):
    """Disorder parameter of a point; falls beyond u = 15 + 2 * sigma + N and rises with sigma."""
    high = u < 15 + 2 * s + n if name != "n5_u7" else s > 0.9
    return (0.12 if high else 0.03) + 1e-4 * u + 2e-5 * s + 7e-7 * n + 1e-8 * _tag(name)


def crossings(name, n, u, s):
    """Velocities at the section of a point, one of them far off; the last two are missing."""
    values = -0.3 * u - 1e-2 * n - 0.5 * s - 1e-3 * _tag(name) - 0.011 * np.arange(CROSSINGS)
    values[0] -= 60
    values[-2:] = np.nan
    return values


def section_position(n):
    return 111.0 * n


def _tag(name):
    return list(SCANS).index(name) + 1


def scan(name):
    """Three replicates of every point, r with a known median, rows in no order."""
    sizes, velocities, noises = SCANS[name]
    grid = [(n, u, s, k) for n in sizes for u in velocities for s in noises for k in range(3)]
    grid = [grid[index] for index in RNG.permutation(len(grid))]
    n, u, s, replicate = (np.array(column) for column in zip(*grid, strict=True))
    disorder = np.array([r(name, *point[:3]) for point in grid]) + SCATTER[replicate]
    share, count = laminar(u, s)
    arrays = {
        "n_blocks": n.astype(int),
        "belt_velocity": u,
        "noise": s,
        "replicate": replicate,
        "disorder_parameter": disorder,
        "section_position": section_position(n),
        "section_velocity": np.array([crossings(name, *point[:3]) for point in grid]),
        "laminar_fraction": share,
        "laminar_count": count,
        "last_stick_time": last_stick_time(n, u, s, replicate),
    }
    method = "event" if name.endswith(panels.CHECK) else "verlet"
    return Dataset(arrays, HOW | {"kind": "scan", "method": method})


def laminar(u, s):
    """Share of laminar phases and their number: intermittent from 14 + sigma to 26 + 2 sigma."""
    inside = (s > 1) & (u > 14 + s) & (u < 26 + 2 * s)
    return np.where(inside, 0.5, 0.99), np.where(inside, 9, 1)


def last_stick_time(n, u, s, replicate):
    """Near the end of 2000; of ten blocks beyond u = 30 without noise only in replicate 2."""
    early = (n == 10) & (u > 30) & (s == 0)
    return np.where(early, np.array([np.nan, 1200.0, 1900.0])[replicate], 1900.0)


def series(
    n_blocks, belt_velocity, noise, *, length=2000, interval=2.0, transient=500.0, start=0.0
):
    """Samples without any pattern, all different; blocks stick at every tenth one.

    The last block slips twice for longer than 200 after the transient; so does block 1, elsewhere.
    """
    rng = np.random.default_rng(int(10 * belt_velocity))
    time = start + interval * np.arange(length)
    velocities = belt_velocity - rng.uniform(1, 50, (length, n_blocks))
    velocities[::10] = belt_velocity
    positions = 60.0 * np.arange(1, n_blocks + 1) + rng.uniform(0, 20, (length, n_blocks))
    fields = [("time", "f8"), ("block", "i8"), ("kind", "U5")]
    slips = [(block, *slip) for block in (1, n_blocks) for slip in long_slips(time[-1], block)]
    events = [(begin, block, "slip") for block, begin, _ in slips]
    events += [(end, block, "stick") for block, _, end in slips]
    arrays = {"time": time, "positions": positions, "velocities": velocities}
    arrays["events"] = np.sort(np.array(events, fields), order="time")
    chain = {"n_blocks": n_blocks, "belt_velocity": belt_velocity, "noise": noise}
    span = {"transient": transient, "duration": float(time[-1])}
    return Dataset(arrays, HOW | chain | span | {"kind": "series"})


def long_slips(end, block):
    """(begin, end) of slips: the first of the last block is too short, the last too early."""
    late = end - 100 * block
    return [(late - 3000, late - 2810), (late - 2000, late - 1500), (late - 900, late), (0, 450)]


def friction_event():
    """Block 5 of 5 sticks from 20 to 23, slips to 25, sticks again; others move at other times."""
    data = series(5, 1.0, 1.0, length=3000, interval=0.01)
    fields = [("time", "f8"), ("block", "i8"), ("kind", "U5")]
    events = [(2, 4, "slip"), (5, 5, "stick"), (9, 5, "slip"), (12, 4, "stick"), (14, 5, "stick")]
    friction = np.random.default_rng(9).uniform(-70, 70, data.arrays["positions"].shape)
    law = {
        "static_friction": 80.0,
        "friction_ratio": 0.4,
        "rest_length": 55.0,
        "linear_limit": 18.0,
        "compression_rate": 0.21,
        "extension_rate": 0.012,
    }
    arrays = data.arrays | {"events": np.array(events, fields), "friction": friction}
    return Dataset(arrays, data.attributes | law)


def slips_u1(points=900, *, repeats=0, method="verlet"):
    """Slips of blocks 4 and 5 in two chains; avalanches that reach the last block and others."""
    rng = np.random.default_rng(8)
    fields = [("point", "i4"), ("block", "i4"), ("start_time", "f8"), ("stop_time", "f8"),
              ("start_position", "f8"), ("stop_position", "f8"), ("dissipated", "f8")]  # fmt: skip
    count = 1200
    slips = np.zeros(count, fields)
    slips["point"], slips["block"] = np.arange(count) % 2, 4 + (np.arange(count) // 2) % 2
    slips["start_time"] = 100.0 * np.arange(count)
    slips["stop_time"] = slips["start_time"] + rng.uniform(1, 9, count)
    slips["stop_position"] = rng.uniform(-5, 5, count)
    slips["start_position"] = slips["stop_position"] + 10 * (1 - 0.99 * rng.random(count)) ** -0.8
    slips["dissipated"] = 3 * (1 - 0.99 * rng.random(count)) ** -0.7
    fields = [("point", "i4"), ("start_time", "f8"), ("stop_time", "f8"), ("dissipated", "f8")]
    events = np.zeros(count, fields)
    for name in ("point", "start_time", "stop_time"):
        events[name] = slips[name]
    events["dissipated"] = 7 * (1 - 0.99 * rng.random(count)) ** -0.7
    fields = [("point", "i4"), ("positions", "f8", 5), ("velocities", "f8", 5)]
    section = np.zeros(points, fields)
    section["positions"] = 300 + rng.uniform(0, 90, (points, 5))
    section["velocities"] = 1.5 - rng.uniform(0, 40, (points, 5))
    section["velocities"][::7] = 1.5
    section["point"] = np.arange(points) % 2
    # the last points are nearly those at the begin
    if repeats:
        section["positions"][-repeats:] = section["positions"][:repeats] + 0.05
        section["velocities"][-repeats:] = section["velocities"][:repeats]
    chain = {"n_blocks": 5, "belt_velocity": 1.5, "noise": 0.0}
    where = {"section_block": 3, "section_position": 271.5}
    arrays = {"slips": slips, "avalanches": events, "section": section}
    return Dataset(arrays, HOW | chain | where | {"kind": "catalogue", "method": method})


def lifetimes():
    """At u = 18, 24 and 30 four, five and two of six runs escape."""
    u = np.tile([18.0, 24.0, 30.0], 6)
    escaped = np.array([[1, 1, 1], [1, 1, 1], [1, 1, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]], bool)
    life = 100.0 + 10 * np.arange(18) + u
    arrays = {"belt_velocity": u, "lifetime": life, "escaped": escaped.ravel()}
    return Dataset(arrays, HOW | {"kind": "escapes", "n_blocks": 5, "noise": 0.0})


RECORDED = recorded.recordings(seconds=300, calm=(90, 210))
DATASETS = (
    RECORDED
    | {name: scan(name) for name in SCANS}
    | {
        "friction_event": friction_event(),
        "u1": series(5, 1.0, 0.0),
        "u20": series(5, 20.0, 0.0, transient=0.0),
        "u17": series(5, 17.5, 2.2, length=8000),
        "u19": series(5, 19.0, 2.2, length=9000),
        "n10_u28": series(10, 28.0, 0.0, length=5500),
        "n10_u31": series(10, 31.0, 0.0, length=5700),
        "n10_u34": series(10, 34.0, 0.0, length=5900),
        "n10_u38": series(10, 38.0, 0.0, length=6100),
        "slips_u1": slips_u1(),
        "slips_u1_event": slips_u1(repeats=40, method="event"),
        "lifetimes": lifetimes(),
        "motion_map": motion(
            n_blocks=[2, 3, 4, 5, 6, 7, 10], belt_velocity=[5.0, 20.0, 40.0], runs=3
        ),
    }
)


def shown(name, *, also=(), **changed):
    """Panels of a figure, drawn from all that it uses."""
    names = (*FIGURES[name].uses, *also)
    data = {used: DATASETS[used] for used in names if used not in changed} | changed
    module = importlib.import_module(registry.figures()[name].module)
    return content(module.draw(data, "small print"))


# --- what a panel must show -----------------------------------------------------------------------


def points(curve):
    return np.column_stack([curve.x, curve.y])


def same(curve, x, y, *, label="", index=None, colour=None, marker=None, rtol=1e-12):
    """A curve with these points, and this label, style number, colour or marker."""
    np.testing.assert_allclose(curve.x, x, rtol=rtol)
    np.testing.assert_allclose(curve.y, y, rtol=rtol)
    assert curve.label == label
    if index is not None:
        colour = colour or style.COLOURS[index % len(style.COLOURS)]
    assert colour is None or curve.colour == colour
    assert marker is None or curve.marker == marker


def axes_are(panel, xlabel, ylabel, *, scales=("linear", "linear")):
    assert (panel.xlabel, panel.ylabel) == (xlabel, ylabel)
    assert (panel.xscale, panel.yscale) == scales


def row_of(name, n, s):
    """(u, r) of a row, from the formula."""
    velocities = SCANS[name][1]
    return velocities, [r(name, n, u, s) for u in velocities]


def column_of(name, n, u):
    noises = SCANS[name][2]
    return noises, [r(name, n, u, s) for s in noises]


def is_diagram(curve, name, n, s):
    """A dot for each crossing of a row: right u, right velocities, three replicates of each."""
    expected = sorted((u, v) for u in SCANS[name][1] for v in crossings(name, n, u, s)[:-2])
    found = points(curve)
    found = found[np.lexsort((found[:, 1], found[:, 0]))]
    np.testing.assert_allclose(found, np.repeat(expected, 3, axis=0), rtol=1e-12)
    assert not curve.line


# --- every figure ---------------------------------------------------------------------------------

IN_WORDS = {"Two": 2, "Three": 3, "Four": 4, "Five": 5, "Six": 6, "Twelve": 12}


def alt_fits(name, figure):
    """The alternative text counts the panels that there are, and speaks of insets if there are."""
    alt = FIGURES[name].alt
    first = alt.split()[0]
    assert not re.search(r"\d+ (panels|diagrams|maps|curves)", alt)
    assert IN_WORDS.get(first, len(figure.panels)) == len(figure.panels)
    insets = any(panel.insets for panel in figure.panels)
    assert insets == ("inset" in alt)


@pytest.mark.thorough
@pytest.mark.parametrize("name", [name for name, entry in FIGURES.items() if entry.number])
def test_alternative_text_fits(name):
    alt_fits(name, shown(name))


@pytest.mark.thorough
@pytest.mark.parametrize("name", [name for name, entry in FIGURES.items() if entry.number])
def test_small_print_is_at_the_foot(name):
    assert shown(name).caption == "small print"


# --- drawings of the model ------------------------------------------------------------------------


def test_fig01_draws_five_blocks_joined_by_springs():
    (panel,) = shown("fig01").panels
    assert sorted(panel.texts) == sorted(["$k$", *["$m$"] * 5, "$u$", "$x_N$"])
    springs = [curve for curve in panel.curves if curve.colour == style.BLUE]
    assert len(springs) == 5
    ends = [(spring.x[0], spring.x[-1]) for spring in springs]
    assert ends[0][0] == 0 and all(a[1] < b[0] for a, b in itertools.pairwise(ends))
    belt, measure = panel.arrows
    assert belt[1][0] > belt[0][0] > ends[-1][1]  # away from the wall
    assert measure[0][0] == 0 and ends[-1][1] < measure[1][0] < belt[0][0]


def test_fig06_is_the_force_of_the_spring():
    (panel,) = shown("fig06").panels
    axes_are(panel, r"$\Delta l$", "$F_e$")
    ideal, model, joins = panel.curves
    same(ideal, model.x, -model.x, label=r"ideal spring, $-\Delta l$")
    assert (ideal.line, ideal.x[0], ideal.x[-1]) == ("--", -36, 100)
    same(model, ideal.x, [naive.spring_force(x) for x in model.x], label="spring of the model")
    same(joins, [-20, 20], [20, -20])
    assert panel.spans == (("x", -20, 20),)
    assert panel.legend == (ideal.label, model.label)
    assert set(panel.texts) == {"linear", "$b_1 = 0.2$", "$b_2 = 0.01$"}
    assert panel.xlim == (-36, 100) and panel.ylim[0] < min(model.y[model.x > -30])


# --- series ---------------------------------------------------------------------------------------


def test_fig07_is_the_friction_of_one_event_of_the_last_block():
    panel, enlarged = shown("fig07").panels
    axes_are(panel, "$F_{ex}$", "$F_f$")
    axes_are(enlarged, "$F_{ex}$", "$F_f$")
    arrays = DATASETS["friction_event"].arrays
    time, friction = arrays["time"], arrays["friction"][:, 4]
    gap = arrays["positions"][:, 4] - arrays["positions"][:, 3]
    external = np.array([naive.spring_force(dx - 55, 18, 0.21, 0.012) for dx in gap])
    stuck, slips = (time > 5) & (time < 9), (time > 9) & (time < 14)
    first, second = panel.curves
    same(first, external[stuck], friction[stuck], label="stuck: $F_f = -F_{ex}$")
    same(second, external[slips], friction[slips], label="slipping: $F_f = f_s F_{st}$")
    assert panel.legend == (first.label, second.label, "sudden change")
    assert panel.titles[2] == "block 5 of 5, slip at $t$ = 9.00"
    assert panel.guides == (("y", 0), ("x", 0), ("y", 80), ("y", 0.4 * 80))
    assert set(panel.texts) == {"$F_{st_0}$", "$f_s F_{st_0}$"}
    kinetic = friction[slips].mean()
    begin, end = external[slips][[0, -1]]
    arrows = [(begin, friction[stuck][-1]), (begin, kinetic), (end, kinetic), (end, -end)]
    np.testing.assert_allclose(np.reshape(panel.arrows, (4, 2)), arrows)
    (alone,) = enlarged.curves
    same(alone, external[slips], friction[slips])
    assert enlarged.guides == (("y", 0.4 * 80),)  # noise of 1 on F_st
    assert enlarged.spans == (("y", pytest.approx(31.6), pytest.approx(32.4)),)
    assert enlarged.titles[2] == rf"measured {friction[slips].std():.2f}, $f_s \sigma$ = 0.40"


def is_trace(panel, time, values, ylabel):
    (curve,) = panel.curves
    same(curve, time, values, marker="")
    assert panel.ylabel == ylabel and panel.xlim == pytest.approx((time[0], time[-1]))


def is_spectrum(panel, series, *, printed=None):
    """Of x_N after the transient."""
    axes_are(panel, r"$\nu$", r"$S(\nu)$", scales=("log", "log"))
    time = series.arrays["time"]
    after = time >= series.attributes["transient"]
    interval = time[1] - time[0]
    frequency, power = spectra.power_spectrum(series.arrays["positions"][after, -1], interval)
    same(panel.curves[0], frequency, power)
    assert len(panel.curves) == (1 if printed is None else 3)
    if printed is not None:
        law = spectra.fit_power_law(frequency, power, low=0.003, high=0.3)
        _, fitted, paper = panel.curves
        same(fitted, [law.low, law.high], law(np.array([law.low, law.high])), label=fitted.label)
        for number in (f"{law.exponent:.2f}", f"{law.exponent_error:.2f}"):
            assert number in fitted.label
        assert rf"\nu^{{{law.exponent / 2:.2f}}}" in panel.titles[1]
        has_slope(paper, fitted, printed)
        assert panel.legend == (fitted.label, paper.label)


def has_slope(paper, fitted, exponent):
    """A dashed line over the range of a fitted one, through its middle, with the paper's slope."""
    assert (paper.label, paper.line) == (f"paper: {exponent:g}", "--")
    np.testing.assert_allclose(paper.x, fitted.x)
    assert np.diff(np.log(paper.y)) / np.diff(np.log(paper.x)) == pytest.approx(exponent)
    assert np.prod(paper.y) == pytest.approx(np.prod(fitted.y))


def is_zoom(panel, inner, time, values, begin, end):
    assert panel.spans == (("x", pytest.approx(begin), pytest.approx(end)),)
    inside = (time >= begin) & (time <= end)
    (curve,) = inner.curves
    same(curve, time[inside], values[inside])
    assert inner.xlim == pytest.approx((begin, end)) and inner.titles[1] == "enlarged"


def test_fig08_is_the_last_part_of_the_series_and_the_spectrum_of_all():
    upper, spectrum, lower, enlarged = shown("fig08").panels
    data = DATASETS["u1"]
    last = data.arrays["time"] >= data.arrays["time"][-1] - 3000
    time = data.arrays["time"][last]
    position = data.arrays["positions"][last, 4]
    relative = data.arrays["velocities"][last, 4] - 1.0
    assert (upper.titles[0], lower.titles[0]) == ("a.", "b.")
    is_trace(upper, time, position, "$x_N$")
    is_spectrum(spectrum, data, printed=-1.21)  # caption of Fig. 8
    is_trace(lower, time, relative, "$v_{rN}$")
    assert lower.xlabel == "$t$"
    middle = time[np.argmin(relative)]
    is_zoom(lower, enlarged, time, relative, middle - 15, middle + 15)


def ending(*, period, sticks):
    """A series at u = 20 that is periodic from t = 2000 on; the last block may stick there."""
    time = 0.2 * np.arange(25_000)
    phase = 2 * np.pi * (time[:, np.newaxis] + 3 * np.arange(5)) / period
    regular = time >= 2000
    data = series(5, 20.0, 0.0, length=time.size, interval=0.2, transient=0.0)
    arrays = {name: values.copy() for name, values in data.arrays.items()}
    arrays["positions"][regular] = 600 + 40 * np.sin(phase)[regular]
    arrays["velocities"][regular] = 10 * np.cos(phase)[regular]
    if sticks:
        arrays["velocities"][regular & (np.arange(time.size) % 50 == 0), 4] = 20
    return Dataset(arrays, data.attributes)


@pytest.mark.parametrize("sticks", [False, True])
def test_fig11_marks_the_end_of_the_transient_and_enlarges_three_periods(sticks):
    data = ending(period=50.0, sticks=sticks)
    upper, end_above, lower, end_below = shown("fig11", u20=data).panels
    arrays = data.arrays
    assert (upper.titles[0], lower.titles[0]) == ("a.", "b.")
    ((axis, since),) = upper.guides
    assert lower.guides == upper.guides and axis == "x"
    assert 2000 <= since <= 2050  # the first crossing of the settled motion
    assert upper.titles[2] == f"periodic from $t$ = {since:.0f} on, period 50.0"
    only = (
        "goes on sticking; in the paper it only slips" if sticks else "only slips, as in the paper"
    )
    assert lower.titles[2] == f"the last block {only}"
    early = arrays["time"] <= 1.6 * since + 150
    time = arrays["time"][early]
    position, relative = arrays["positions"][early, 4], arrays["velocities"][early, 4] - 20.0
    is_trace(upper, time, position, "$x_N$")
    is_trace(lower, time, relative, "$v_{rN}$")
    assert lower.xlabel == end_below.xlabel == "$t$"
    for panel, inner, values in ((upper, end_above, position), (lower, end_below, relative)):
        is_zoom(panel, inner, time, values, time[-1] - 150, time[-1])


def test_fig11_marks_the_last_stick_where_the_motion_does_not_repeat_itself():
    data = DATASETS["u20"]
    arrays = {name: values.copy() for name, values in data.arrays.items()}
    arrays["velocities"][1001:] -= 1.0  # the last stick is at sample 1000, t = 2000
    upper, _, lower, _ = shown("fig11", u20=Dataset(arrays, data.attributes)).panels
    assert upper.guides == (("x", 2000.0),)
    assert upper.titles[2] == "last stick at $t$ = 2000, no period found"
    assert "as in the paper" in lower.titles[2]
    assert upper.curves[0].x[-1] == pytest.approx(1.6 * 2000 + 60)


def test_fig11_says_when_the_transient_does_not_end():
    upper, _, lower, _ = shown("fig11").panels
    assert upper.titles[2] == "no end of the transient in this series" and not upper.guides
    assert "goes on sticking" in lower.titles[2]


def are_laminar(panel, data, window, *, zero=0.0):
    """Long slips of the last block after the transient are shaded and counted; no others are."""
    about = data.attributes
    slips = long_slips(about["duration"], about["n_blocks"])
    inside = [(max(begin, window[0]), min(end, window[1])) for begin, end in slips[1:3]]
    expected = [("x", begin - zero, end - zero) for begin, end in inside if end > begin]
    assert len(panel.spans) == len(expected) > 0
    for span, known in zip(panel.spans, expected, strict=True):
        assert span == ("x", pytest.approx(known[1]), pytest.approx(known[2]))
    length = about["duration"] - about["transient"]
    point = rf"$u = {about['belt_velocity']:g}$, $\sigma = {about['noise']:g}$"
    share = f"{1400 / length:.0%}"
    assert panel.titles[2] == f"{point}: 2 laminar phases, {share} of $t$ = {length:g}"


def test_fig16_is_the_last_part_of_two_series_with_their_spectra_and_laminar_shares():
    above, first, below, second, shares = shown("fig16").panels
    places = ((above, first, "u17", "a."), (below, second, "u19", "b."))
    for panel, spectrum, name, letter in places:
        data = DATASETS[name]
        end = data.attributes["duration"]
        last = data.arrays["time"] >= end - 10000
        is_trace(panel, data.arrays["time"][last], data.arrays["positions"][last, 4], "$x_N$")
        are_laminar(panel, data, (end - 10000, end))
        is_spectrum(spectrum, data)
        assert panel.titles[0] == letter
    assert below.xlabel == "$t$"
    axes_are(shares, "$u$", "laminar share")
    assert shares.guides == (("x", 17.5), ("x", 19.0))
    _, velocities, _ = SCANS["n5_replicates"]
    runs, mean = shares.curves
    same(mean, velocities, laminar(velocities, 2.2)[0])
    assert runs.x.size == 3 * velocities.size
    assert shares.titles[2].startswith(r"$\sigma = 2.2$")


def test_a_slip_that_never_ends_is_one_laminar_phase():
    data = DATASETS["n10_u34"]
    arrays = {name: values.copy() for name, values in data.arrays.items()}
    arrays["events"] = arrays["events"][arrays["events"]["block"] != 10]
    arrays["velocities"][..., -1] = 1.0
    panel = shown("fig20", n10_u34=Dataset(arrays, data.attributes)).panels[2]
    assert ": 1 laminar phase, 100% of" in panel.titles[2] and len(panel.spans) == 1


def test_fig20_is_a_panel_for_each_belt_velocity_after_the_transient():
    *stack, _ = shown("fig20").panels
    for panel, letter, u in zip(stack, "abcd", (28, 31, 34, 38), strict=True):
        data = DATASETS[f"n10_u{u}"]
        arrays = data.arrays
        part = (arrays["time"] >= 500) & (arrays["time"] <= 10500)
        (curve,) = panel.curves
        same(curve, arrays["time"][part] - 500, arrays["positions"][part, 9])
        assert panel.ylabel == "$x_N$" and panel.titles[0] == f"{letter}."
        are_laminar(panel, data, (500, 10500), zero=500)
    assert stack[-1].xlabel == r"$t - t_{\rm trans}$"


def test_fig20_tells_which_runs_stick_to_the_end():
    *_, panel = shown("fig20").panels
    axes_are(panel, "$u$", "last stick / duration")
    assert panel.titles[0] == "e." and panel.guides == (("y", 0.25),)
    runs, share = panel.curves
    _, velocities, _ = SCANS["size_replicates"]
    last = np.where(velocities > 30, [[0.25], [0.6], [0.95]], [[0.95], [0.95], [0.95]])
    expected = sorted(zip(np.tile(velocities, 3), last.ravel(), strict=True))
    np.testing.assert_allclose(sorted(map(tuple, points(runs))), expected)
    same(share, velocities, np.where(velocities > 30, 1 / 3, 1), label=share.label)
    assert panel.legend == ("a run", "share of runs that stick to the end")


# --- the catalogue --------------------------------------------------------------------------------


def is_density(curve, values, label, *, run=None):
    centre, density, count = avalanches.log_histogram(values, bins_per_decade=10)
    same(curve, centre[count > 0], density[count > 0], label=label)
    # a density: its integral over the bins is one
    width = centre * (10**0.05 - 10**-0.05)
    assert np.sum(np.interp(centre, curve.x, curve.y)[count > 0] * width[count > 0]) == (
        pytest.approx(1, abs=1e-9)
    )
    assert (curve.error is None) == (run is None)
    if run is not None:
        error = avalanches.density_error(values, run, centre, bins_per_decade=10)
        np.testing.assert_allclose(curve.error, error[count > 0])


def is_law(curve, values):
    histogram = avalanches.log_histogram(values, bins_per_decade=10)
    low, high = avalanches.falling_range(*histogram)
    law = avalanches.fit_density(*histogram, low=low, high=high)
    label = rf"$\alpha = {law.exponent:.2f}$"
    same(curve, [low, high], law(np.array([low, high])), label=label, rtol=1e-6)


def test_fig09_is_sizes_of_the_last_block_and_energies_of_avalanches_with_it():
    left, right = shown("fig09").panels
    arrays = DATASETS["slips_u1"].arrays
    own = arrays["slips"][arrays["slips"]["block"] == 5]
    laboratory = own["start_position"] - own["stop_position"]
    belt = laboratory + 1.5 * (own["stop_time"] - own["start_time"])
    # each avalanche is one slip here
    reaching = arrays["avalanches"]["dissipated"][arrays["slips"]["block"] == 5]
    expected = (
        (left, "a.", r"$\Delta x_s$", laboratory, "laboratory frame, 600 slips", belt,
         "frame of the belt", -1.47),
        (right, "b.", r"$\Delta E$", reaching, "whole chain, 600 avalanches", own["dissipated"],
         "last block only", -0.87),
    )  # fmt: skip
    for panel, letter, xlabel, values, label, others, other_label, printed in expected:
        assert panel.titles[0] == letter
        axes_are(panel, xlabel, f"$P({xlabel.strip('$')})$", scales=("log", "log"))
        main, law, paper, second = panel.curves
        is_density(main, values, label, run=own["point"])
        is_law(law, values)
        has_slope(paper, law, printed)
        is_density(second, others, other_label)
        assert (main.marker, second.marker, law.marker) == ("o", "s", "")
        assert {" ".join(each.label.split()) for each in panel.curves} == set(panel.legend)


def test_fig10_is_the_points_at_which_the_last_block_slips_by_both_integrators():
    first, second = shown("fig10").panels
    assert (first.titles[0], second.titles[0]) == ("a.", "b.")
    assert (first.ylabel, second.ylabel) == ("$v_{rN}$", "")
    for panel, name, old in ((first, "slips_u1", 0), (second, "slips_u1_event", 40)):
        assert panel.xlabel == "$x_N$"
        section = DATASETS[name].arrays["section"]
        position, relative = section["positions"][:, 4], section["velocities"][:, 4] - 1.5
        new = (relative < 0) & (np.arange(900) < 900 - old)
        *again, curve = panel.curves
        same(curve, position[new], relative[new], colour=style.BLUE)
        assert not curve.line and len(again) == bool(old)
        if old:
            repeats = (relative < 0) & ~new
            same(again[0], position[repeats], relative[repeats], colour=style.ORANGE)
        count = f"{(relative < 0).sum()} points with $v_{{rN}} < 0$, {new.sum()} of them new"
        method = DATASETS[name].attributes["method"]
        assert panel.titles[2] == f"{method}: $x_{{3}} = 271.5$, 2 runs,\n{count}"


def test_fig10_is_a_density_where_points_are_many():
    data = slips_u1(points=30_000)
    panel, _ = shown("fig10", slips_u1=data).panels
    section = data.arrays["section"]
    position, relative = section["positions"][:, 4], section["velocities"][:, 4] - 1.5
    slips = relative < 0
    (image,) = panel.images
    count, x_edges, y_edges = np.histogram2d(position[slips], relative[slips], (240, 240))
    np.testing.assert_allclose(image.x_edges, x_edges)
    np.testing.assert_allclose(image.y_edges, y_edges)
    np.testing.assert_array_equal(np.nan_to_num(image.values), count.T)
    assert (image.scale, image.label) == ("log", "points per cell")


# --- scans ----------------------------------------------------------------------------------------


def test_fig12_is_the_row_without_noise_with_the_other_method_over_it():
    top, _, disorder, lifetimes = shown("fig12").panels
    assert top.ylabel == "$v_N$" and top.titles[2] == "section $x_N = 555$"
    (diagram,) = top.curves
    is_diagram(diagram, "n5_rows", 5, 0.0)
    assert diagram.colour == style.BLUE
    axes_are(disorder, "", "$r$")
    starts, first, second = disorder.curves
    has_dots(
        dataclasses.replace(starts, label=""),
        *means_of("n5_replicates_check", 5, 0.0),
        colour=style.GREY,
    )
    same(first, *row_of("n5_rows", 5, 0.0), colour=style.BLUE)
    same(second, *row_of("n5_rows_check", 5, 0.0), colour=style.ORANGE, marker="x")
    assert disorder.legend == ("other starts", "method event") and not second.line
    assert disorder.xlim[0] == disorder.ylim[0] == 0 and lifetimes.xlabel == "$u$"


def test_fig12_without_replicates_has_no_other_starts():
    data = {name: DATASETS[name] for name in FIGURES["fig12"].uses}
    del data["n5_replicates_check"], data["n5_rows_check"]
    disorder = content(
        importlib.import_module("beltrepro.replication.studies.transition.fig12").draw(data, "")
    ).panels[2]
    (only,) = disorder.curves
    same(only, *row_of("n5_rows", 5, 0.0))


def test_fig12_marks_the_transition():
    bottom = shown("fig12").panels[2]
    arrays = DATASETS["n5_rows"].arrays
    row = (arrays["n_blocks"] == 5) & (arrays["noise"] == 0)
    order = np.lexsort((arrays["replicate"][row], arrays["belt_velocity"][row]))
    fall = transitions.transition_region(
        arrays["belt_velocity"][row][order], arrays["disorder_parameter"][row][order]
    )
    assert fall.found
    assert bottom.spans == (("x", fall.lower, fall.upper),)
    assert bottom.guides == (("x", fall.critical),)
    edges = f"{fall.lower:.1f} to {fall.upper:.1f}"
    assert bottom.titles[2] == (
        f"grey: transition region {edges}, dashed: $u_c$ = {fall.critical:.1f}"
    )


def test_fig12_shows_mean_lifetimes_and_limits_where_few_runs_end():
    *_, panel = shown("fig12").panels
    axes_are(panel, "$u$", r"$\tau$", scales=("linear", "log"))
    known, limit = panel.curves
    arrays = DATASETS["lifetimes"].arrays
    times = np.where(arrays["escaped"], arrays["lifetime"], 2000.0)
    total = {u: times[arrays["belt_velocity"] == u].sum() for u in (18.0, 24.0, 30.0)}
    expected = [total[18.0] / 4, total[24.0] / 5]  # at 30 only two escape
    same(known, [18, 24], expected, marker="o")
    np.testing.assert_allclose(known.error, known.y / np.sqrt([4, 5]))
    # of two ends: as few come in 2.5 % of all cases if the mean is the limit
    ratio = total[30.0] / limit.y[0]
    assert stats.poisson.cdf(2, ratio) == pytest.approx(0.025)
    same(limit, [30], limit.y, label="too few runs end: longer", marker="^")
    assert panel.titles[2] == "measured from $u$ = 18 on"


def is_family(panel, curves, xlabel, overlay="method event", line=True):
    """Curves of r: (label, style number, x, y), then those drawn over them without a label."""
    axes_are(panel, xlabel, "$r$")
    found = list(panel.curves)
    assert len(found) == len(curves)
    for curve, (label, index, x, y) in zip(found, curves, strict=True):
        same(curve, x, y, label=label, index=index)
        assert (curve.marker == "x") == (label == "")
        assert bool(curve.line) == (line and label != "")
    labels = [label for label, *_ in curves if label]
    assert sorted(panel.legend) == sorted([*labels, *([overlay] if overlay else [])])
    assert panel.ylim[0] == 0


def means_of(name, n, s):
    """(u, mean of r over the replicates) of a row."""
    velocities, median = row_of(name, n, s)
    return velocities, np.array(median) + SCATTER.mean()


def has_bands(panel, curves):
    """A band for each (style number, x, mean): the middle 80 % of three replicates."""
    # of three values the quantile 0.1 lies a fifth of the way from the least to the middle one
    low, high = (0.8 * SCATTER[end] - SCATTER.mean() for end in (0, -1))
    for band, (index, x, mean) in zip(panel.bands, curves, strict=True):
        np.testing.assert_allclose(band.x, x)
        np.testing.assert_allclose(band.low, mean + low)
        np.testing.assert_allclose(band.high, mean + high)
        assert band.colour == style.COLOURS[index % len(style.COLOURS)]


def has_dots(curve, x, mean, *, colour):
    """A dot for each of three replicates."""
    expected = [(a, b + d) for a, b in zip(x, mean - SCATTER.mean(), strict=True) for d in SCATTER]
    np.testing.assert_allclose(sorted(map(tuple, points(curve))), sorted(expected))
    assert not curve.line and not curve.label and curve.colour == colour


def test_fig13_is_replicates_and_single_runs_for_each_noise():
    above, below = shown("fig13").panels
    assert (above.titles[0], below.titles[0]) == ("a.", "b.")
    noises = (0.0, 1.0, 2.2, 5.0, 10.0)
    means = [(noises.index(s), *means_of("n5_replicates", 5, s)) for s in noises[:4]]
    lines = [(rf"$\sigma = {noises[index]:g}$", index, x, y) for index, x, y in means]
    dots, *curves, over = above.curves
    has_dots(dots, *means[0][1:], colour=style.BLUE)
    is_family(dataclasses.replace(above, curves=tuple(curves)), lines, "$u$")
    checked = means_of("n5_replicates_check", 5, 0.0)
    same(over, *checked, label="method event", index=0, marker="x")
    has_bands(above, means[1:])
    rows = [
        (rf"$\sigma = {s:g}$", index, *row_of("n5_rows", 5, s)) for index, s in enumerate(noises)
    ]
    over = [("", noises.index(s), *row_of("n5_rows_check", 5, s)) for s in (0.0, 1.0)]
    is_family(below, rows + over, "$u$", line=False)
    assert not below.bands and below.xlim[0] == 0


def test_fig14_is_a_diagram_for_each_noise_and_a_column():
    *diagrams, last = shown("fig14").panels
    for panel, s in zip(diagrams, LEVELS, strict=True):
        (curve,) = panel.curves
        is_diagram(curve, "n5_rows", 5, s)
        assert panel.titles[1] == rf"$\sigma = {s:g}$"
    assert [panel.ylabel for panel in diagrams] == ["$v_N$", *[""] * 3, "$v_N$", "", ""]
    assert [panel.xlabel for panel in diagrams][4:] == ["$u$"] * 3
    axes_are(last, r"$\sigma$", "$r$")
    are_replicates(last, "n5_u7", 5, 7.0, index=1)
    arrays = DATASETS["n5_u7"].arrays
    chosen = (arrays["n_blocks"] == 5) & (arrays["belt_velocity"] == 7)
    order = np.lexsort((arrays["replicate"][chosen], arrays["noise"][chosen]))
    rise = transitions.critical_noise(
        arrays["noise"][chosen][order], arrays["disorder_parameter"][chosen][order]
    )
    assert rise.found and last.guides == (("x", rise.critical),)
    assert last.titles[1] == rf"$u = 7$: $\sigma_c = {rise.critical:.2f}$"


def are_replicates(panel, name, n, u, *, index=0, over=None):
    """A dot for each run, the mean and the middle 80 % of r against noise; crosses over them."""
    runs, line, *crosses = panel.curves
    noises, median = column_of(name, n, u)
    mean = np.array(median) + SCATTER.mean()
    has_dots(runs, noises, mean, colour=style.BLACK)
    same(line, noises, mean, index=index)
    has_bands(panel, [(index, noises, mean)])
    assert len(crosses) == bool(over)
    if over:
        noises, median = column_of(over, n, u)
        mean = np.array(median) + SCATTER.mean()
        same(crosses[0], noises, mean, label="method event", colour=style.VERMILION, marker="x")
        assert panel.legend == ("method event",) and not crosses[0].line


def test_fig15_is_a_panel_of_replicates_for_each_belt_velocity():
    grid = shown("fig15", also=["n5_columns_check"]).panels
    for panel, u in zip(grid, (20.0, 30.0, 40.0), strict=True):
        are_replicates(panel, "n5_columns", 5, u, over="n5_columns_check" if u != 30 else None)
        assert panel.titles[1] == f"$u = {u:g}$"
        assert panel.guides == (("x", 5.0),) and panel.ylim[0] == 0
    assert [(panel.xlabel, panel.ylabel) for panel in grid] == [
        (r"$\sigma$", "$r$"),
        (r"$\sigma$", ""),
        (r"$\sigma$", ""),
    ]


def test_fig17_is_the_density_of_the_crossings_at_four_noises():
    grid = shown("fig17").panels
    noises = (0.0, 1.0, 5.0, 10.0)
    lowest = np.floor(min(crossings("n5_rows", 5, U[-1], 10.0)[:-2]))
    densities = []
    for panel, letter, s in zip(grid, "abcd", noises, strict=True):
        assert panel.titles[:2] == (f"{letter}.", rf"$\sigma = {s:g}$")
        (image,) = panel.images
        np.testing.assert_allclose(image.y_edges, np.linspace(lowest, 0, 121))
        np.testing.assert_allclose(image.x_edges, np.append(U - 1.5, U[-1] + 1.5))
        for column, u in enumerate(U):
            values = crossings("n5_rows", 5, u, s)[:-2]
            if s in SCANS["n5_replicates"][2] and u in SCANS["n5_replicates"][1]:
                values = np.append(values, crossings("n5_replicates", 5, u, s)[:-2])
            expected, _ = np.histogram(values, image.y_edges, density=True)
            np.testing.assert_allclose(np.nan_to_num(image.values[:, column]), expected)
        densities.append(image.values)
        assert image.scale == "log"
    highest, least = np.nanmax(densities), np.nanmin(densities)
    for panel in grid:
        assert panel.images[0].limits == pytest.approx((max(least, highest / 1000), highest))
        assert panel.ylim[0] < lowest and panel.ylim[1] == 0
    assert [panel.xlabel for panel in grid] == ["", "", "$u$", "$u$"]
    assert [panel.ylabel for panel in grid] == ["$v_N$", "", "$v_N$", ""]
    assert [panel.images[0].label for panel in grid][-1] == "density of $v_N$ at given $u$"


def test_fig17_marks_where_the_last_block_does_not_always_stick():
    for panel, s in zip(shown("fig17").panels, (0.0, 1.0, 5.0, 10.0), strict=True):
        share, _ = laminar(U, s)
        marks = {curve.colour: curve for curve in panel.curves}
        for colour, chosen in ((style.BLUE, share > 0.95), (style.ORANGE, share == 0.5)):
            assert (colour in marks) == chosen.any()
            if chosen.any():
                curve = marks[colour]
                same(curve, U[chosen], curve.y, marker="|")
                assert np.all((curve.y < panel.images[0].y_edges[0]) & (curve.y > panel.ylim[0]))


def test_fig18_is_the_map_of_r_with_a_dot_at_each_intermittent_point():
    panel, _ = shown("fig18").panels
    axes_are(panel, "$u$", r"$\sigma$")
    (image,) = panel.images
    noises = SCANS["n5_map"][2]
    np.testing.assert_allclose(image.x_edges, np.append(U - 1.5, U[-1] + 1.5))
    np.testing.assert_allclose(image.y_edges, np.append(noises - 1.25, noises[-1] + 1.25))
    expected = np.array([[r("n5_map", 5, u, s) for u in U] for s in noises])
    np.testing.assert_allclose(image.values, expected)
    assert (image.scale, image.label, image.limits[0]) == ("linear", "$r$", 0)
    assert expected.max() <= image.limits[1] < expected.max() + 0.02
    (dots,) = panel.curves
    inside = [(u, s) for s in noises for u in U if laminar(u, s)[0] == 0.5]
    np.testing.assert_allclose(sorted(map(tuple, points(dots))), np.repeat(sorted(inside), 3, 0))
    assert not dots.line
    share = f"{intermittency.LAMINAR_SHARE[0]:.0%} to {intermittency.LAMINAR_SHARE[1]:.0%}"
    assert panel.titles[2].startswith("dots: intermittent") and share in panel.titles[2]


def test_fig18_shows_the_share_of_laminar_phases_for_each_noise():
    _, panel = shown("fig18").panels
    axes_are(panel, "$u$", "laminar share")
    assert panel.guides == tuple(("y", limit) for limit in intermittency.LAMINAR_SHARE)
    _, velocities, _ = SCANS["n5_replicates"]
    noises = (0.0, 1.0, 2.2, 5.0)
    for index, (curve, s) in enumerate(zip(panel.curves, noises, strict=True)):
        share = laminar(velocities, s)[0]
        same(curve, velocities, share, label=rf"$\sigma = {s:g}$", index=index)
    for band, s in zip(panel.bands, noises[1:], strict=True):
        np.testing.assert_allclose(band.low, laminar(velocities, s)[0])
        np.testing.assert_allclose(band.high, band.low)


def test_fig19_is_replicates_of_three_sizes_and_single_runs_of_all():
    above, below = shown("fig19").panels
    sizes = (5, 7, 10, 2, 3, 4, 6)
    names = {5: "n5_replicates", 7: "size_replicates", 10: "size_replicates"}
    means = [(sizes.index(n), *means_of(name, n, 1.0)) for n, name in names.items()]
    lines = [(f"$N = {sizes[index]}$", index, x, y) for index, x, y in means]
    is_family(above, lines, "", overlay="")
    has_bands(above, means)
    assert above.spans == (("x", 15, 18), ("x", 23, 32), ("x", 27, 40))  # caption of Fig. 19
    curves = []
    for name in ("n5_rows", "n5_rows_check", "size_rows", "size_rows_check"):
        for n in sorted(sizes):
            if n in SCANS[name][0]:
                label = "" if name.endswith(panels.CHECK) else f"$N = {n}$"
                curves.append((label, sizes.index(n), *row_of(name, n, 1.0)))
    is_family(below, curves, "$u$", line=False)
    for panel in (above, below):
        assert r"$\sigma = 1$" in panel.titles[2]


def test_fig21_is_a_panel_of_replicates_for_each_number_of_blocks_and_belt_velocity():
    grid = shown("fig21", also=["size_columns_check"]).panels
    places = [(n, u) for n in (5, 7, 10) for u in (18.0, 32.0)]
    for panel, (n, u) in zip(grid, places, strict=True):
        over = "size_columns_check" if n < 10 and u == 18 else None
        are_replicates(panel, "size_columns", n, u, over=over)
        assert panel.titles[1] == f"$N = {n}$, $u = {u:g}$"
    assert [panel.xlabel for panel in grid] == [""] * 4 + [r"$\sigma$"] * 2
    assert [panel.ylabel for panel in grid] == ["$r$", ""] * 3


def test_fig22_is_a_diagram_for_each_number_of_blocks_and_noise():
    figure = shown("fig22")
    rows = np.reshape(np.array(figure.panels, dtype=object), (4, 6))
    for line, s in enumerate((0.0, 1.0, 5.0)):
        for panel, n in zip(rows[line], SIZES, strict=True):
            (curve,) = panel.curves
            is_diagram(curve, "size_rows", n, s)
            assert curve.colour == (style.BLACK, style.VERMILION, style.BLUE)[line]
    for panel, letter, n in zip(rows[0], "abcdef", SIZES, strict=True):
        assert panel.titles[0] == f"{letter}."
        assert panel.titles[1] == f"$N = {n}$\n$x_N = {111 * n}$"
    assert [panel.xlabel for panel in figure.panels] == [""] * 18 + ["$u$"] * 6
    labels = [panel.ylabel for panel in rows[:, 0]]
    assert labels == [
        *(rf"$v_N$,  $\sigma = {s}$" for s in (0, 1, 5)),
        r"$\lambda_1$,  $\sigma = 0$",
    ]
    assert not any(panel.ylabel for panel in rows[:, 1:].ravel())
    arrays = DATASETS["motion_map"].arrays
    highest = np.max(
        (arrays["largest_exponent"] + arrays["standard_error"])[arrays["n_blocks"] != 5]
    )
    assert all(panel.ylim[1] > highest for panel in rows[-1])


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("figure", "place", "n_blocks"),
    [("fig12", 1, 5)] + [("fig22", 18 + i, n) for i, n in enumerate(SIZES)],
)
def test_exponents_are_those_of_the_motions(figure, place, n_blocks):
    panel = shown(figure).panels[place]
    arrays = DATASETS["motion_map"].arrays
    own = arrays["n_blocks"] == n_blocks
    states = np.unique(arrays["state"][own])
    assert {curve.label for curve in panel.curves} == set(states)
    for curve in panel.curves:
        chosen = own & (arrays["state"] == curve.label)
        expected = arrays["belt_velocity"][chosen], arrays["largest_exponent"][chosen]
        same(curve, *expected, colour=motions.COLOURS[curve.label], label=curve.label)


# --- further studies ------------------------------------------------------------------------------


def test_friction_ratio_is_a_curve_for_each_ratio_and_the_falls():
    ratios, velocities = (0.2, 0.45, 0.8), U[:6]
    grid = [(f, u, k) for f in ratios for u in velocities for k in range(3)]
    f, u, replicate = (np.array(each) for each in zip(*RNG.permutation(grid), strict=True))
    disorder = f + 1e-3 * u + np.array([-2e-3, 0, 9e-3])[replicate.astype(int)]
    arrays = {"friction_ratio": f, "belt_velocity": u, "disorder_parameter": disorder}
    falls = pd.DataFrame(
        {
            "friction_ratio": ratios,
            "critical": [31.0, np.nan, 17.0],
            "error": [0.5, np.nan, 0.7],
            "lower": [28.0, np.nan, 12.0],
            "upper": [35.0, np.nan, 21.0],
        }
    )
    scan = Dataset(arrays, HOW | {"kind": "scan"})
    figure = shown("friction_ratio", friction_ratio=scan, friction_falls=falls)
    alt_fits("friction_ratio", figure)
    left, right = figure.panels
    curves = [
        (f"$f_s = {ratio:g}$", index, velocities, ratio + 1e-3 * velocities)
        for index, ratio in enumerate(ratios)
    ]
    is_family(left, curves, "$u$", overlay="")
    axes_are(right, "$f_s$", "$u_c$")
    (curve,) = right.curves
    same(curve, [0.2, 0.8], [31, 17])
    np.testing.assert_allclose(curve.error, [0.5, 0.7])
    np.testing.assert_allclose(right.bars, [[(0.2, 28), (0.2, 35)], [(0.8, 12), (0.8, 21)]])


def test_critical_velocity_is_the_middles_of_the_falls_with_their_regions():
    rows = [
        ("n5_replicates", 5, 0.0, 18.0, 0.5, 17.0, 19.0),
        ("n5_replicates", 5, 1.0, 18.5, 0.3, 18.0, 19.2),
        ("n5_replicates", 5, 2.2, np.nan, np.nan, np.nan, np.nan),
        ("n5_replicates_check", 5, 0.0, 19.5, 0.4, 17.5, 21.5),
        ("n5_replicates_wide", 5, 0.0, 17.5, np.nan, 16.5, 18.5),
        ("size_replicates", 7, 0.0, 28.0, 1.0, 26.0, 30.0),
        ("size_replicates", 7, 1.0, np.nan, np.nan, np.nan, np.nan),
        ("size_replicates", 10, 0.0, np.nan, np.nan, np.nan, np.nan),
        ("size_replicates", 10, 1.0, np.nan, np.nan, np.nan, np.nan),
    ]
    names = ["dataset", "n_blocks", "noise", "critical", "error", "lower", "upper"]
    table = pd.DataFrame(rows, columns=names)
    wide = {"n5_replicates_wide": DATASETS["n5_replicates"]}
    figure = shown("critical_velocity", critical_velocities=table, **wide)
    alt_fits("critical_velocity", figure)
    left, right = figure.panels
    axes_are(left, r"$\sigma$", "$u_c$")
    axes_are(right, "$N$", "$u_c$")
    found = {curve.label: curve for curve in left.curves if curve.error is not None}
    expected = {
        "exact motion": ([0, 1], [18, 18.5], [0.5, 0.3]),
        "scheme of the paper": ([0], [19.5], [0.4]),
        "the same, wide starts": ([0], [17.5], [0]),
    }
    assert set(found) == set(expected)
    for label, (noise, middle, error) in expected.items():
        np.testing.assert_allclose(found[label].y, middle)
        np.testing.assert_allclose(found[label].error, error)
        assert np.abs(found[label].x - noise).max() < 0.2
    (paper,) = [curve for curve in left.curves if curve.label == "paper"]
    same(paper, [0, 2.2], [16.5, 19], label="paper", marker="x")  # Sec. IV.A and IV.B
    spans = [(begin[1], end[1]) for begin, end in left.bars if begin[1] != end[1]]
    assert {(17, 19), (18, 19.2), (17.5, 21.5), (16.5, 18.5)} == set(spans)
    assert left.titles[2] == r"no fall by half at $\sigma$ = 2.2"
    quiet, noisy = (c for c in right.curves if c.error is not None)
    same(quiet, quiet.x, [18, 28], label=r"$\sigma = 0$")
    same(noisy, noisy.x, [18.5], label=r"$\sigma = 1$")
    assert np.abs(quiet.x - [5, 7]).max() < 0.3
    regions = [tuple(c.y) for c in right.curves if c.line]
    assert regions == [(15, 18), (23, 32), (27, 40)]
    assert right.titles[2] == "no fall by half at $N$ = 10"


def test_avalanches_are_a_density_for_each_number_of_blocks_and_where_it_ends():
    rng = np.random.default_rng(12)
    data = {}
    for n, name in zip((3, 5, 7, 10), FIGURES["avalanches"].uses, strict=True):
        events = np.zeros(400 + n, [("point", "i4"), ("dissipated", "f8")])
        events["point"] = np.arange(events.size) % 8
        events["dissipated"] = n**2 * (1 - 0.99 * rng.random(events.size)) ** -0.7
        arrays = {"avalanches": events, "slips": events}
        data[name] = Dataset(arrays, HOW | {"kind": "catalogue", "n_blocks": n})
    figure = shown("avalanches", **data)
    alt_fits("avalanches", figure)
    left, right = figure.panels
    axes_are(left, r"$\Delta E$", r"$P(\Delta E)$", scales=("log", "log"))
    axes_are(right, "$N$", r"$\Delta E$", scales=("log", "log"))
    ends = []
    for curve, n, each in zip(left.curves, (3, 5, 7, 10), data.values(), strict=True):
        events = each.arrays["avalanches"]
        energy = events["dissipated"]
        centre, density, count = avalanches.log_histogram(energy, bins_per_decade=8)
        same(curve, centre[count > 0], density[count > 0], label=f"$N = {n}$, {400 + n} avalanches")
        error = avalanches.density_error(energy, events["point"], centre, bins_per_decade=8)
        np.testing.assert_allclose(curve.error, error[count > 0])
        ends.append((np.quantile(energy, 0.99), energy.max()))
    largest, law, quantiles = sorted(right.curves, key=lambda curve: curve.error is not None)
    same(quantiles, [3, 5, 7, 10], np.array(ends)[:, 0], label="99% quantile")
    assert np.all(quantiles.error > 0)
    same(largest, [3, 5, 7, 10], np.array(ends)[:, 1], label="largest")
    slope = np.diff(np.log(law.y)) / np.diff(np.log(law.x))
    assert np.ptp(slope) < 1e-9 and slope[0] == pytest.approx(2, abs=0.7)
    assert f"{slope[0]:.2f}" in law.label and right.xticks == ("3", "5", "7", "10")


def test_trials_of_the_experiment_and_their_posteriors(monkeypatch):
    monkeypatch.setattr("beltrepro.replication.studies.experiment.trials.BANDWIDTH", {})
    made = studies(runs=16)
    used = FIGURES["experiment_noise"].uses
    figure = shown("experiment_noise", **{name: made[name] for name in used})
    alt_fits("experiment_noise", figure)
    disorder, share, plane, noise = figure.panels
    axes_are(disorder, r"$\sigma$", "$r$", scales=("log", "linear"))
    medians, least = disorder.curves[::2], disorder.curves[1::2]
    for place, (curve, shift) in enumerate(zip(medians, (0.96, 1.04), strict=True)):
        x = shift * np.array([0.5, 1, 2, 4])
        label = ("0.22 m/s", "0.28 m/s")[place]
        same(curve, x, 4 * [0.1375], label=label, index=place, marker="o")
        same(least[place], x, 4 * [0.13], index=place, marker="v")
    assert [guide[1] for guide in sorted(disorder.guides)] == [0.052, 0.072]
    assert disorder.legend == ("0.22 m/s", "0.28 m/s")
    axes_are(share, "$u$", "share with both regimes")
    for curve, s in zip(share.curves, (0.5, 1, 2, 4), strict=True):
        velocities = 12.01756 * (14 / 11) ** np.arange(-1.0, 3)
        same(curve, velocities, 4 * [0], label=rf"$\sigma = {s:g}$", rtol=1e-5)
    axes_are(plane, "friction ratio $f_s$", "factor on the belt speed")
    (image,) = plane.images
    np.testing.assert_allclose(image.values, [[0, 0], [0, 1], [0, 0]])
    np.testing.assert_allclose(image.x_edges, [0.375, 0.525, 0.675])
    same(plane.curves[0], [0.45], [1.0], marker="x")
    axes_are(noise, r"$\sigma$", "probability", scales=("log", "linear"))
    before, *posteriors = noise.curves
    same(before, [0.5, 1, 2, 4], 4 * [0.25])
    likelihood = np.array([0, 4, 16, 1])  # squares of the trials of four that agree
    for curve, label, index in zip(posteriors, ("$f_s$ free", "both free"), (0, 2), strict=True):
        same(curve, before.x, likelihood / 21, label=label, index=index)
    assert any("speed free" in " ".join(words.split()) for words in noise.texts)


RATES = {(5, "event"): 1e-4, (5, "verlet"): 1e-3, (7, "event"): 0.005, (7, "verlet"): 0.02}


def growth(runs=6):
    """Distances that grow at the rate of N and method, from the first level and from the third."""
    levels = np.geomspace(1e-6, 1e-2, 9)
    rows = [(n, method) for n, method in RATES for _ in range(runs)]
    first = np.array([np.log(levels / levels[0]) / RATES[row] for row in rows])
    later = np.where(levels < 0.99 * levels[2], np.nan, first - first[:, 2:3])
    n, method = zip(*rows, strict=True)
    arrays = {"n_blocks": np.array(n), "method": np.array(method), "levels": levels}
    arrays["passage_time"] = np.stack([first, later], axis=1)
    return Dataset(arrays, HOW | {"kind": "separation", "duration": 1e6, "transient": 0.0})


def settled(irregular, r, **quantity):
    """Four runs at each u and value of a quantity, `irregular(u, value)` of them irregular."""
    (name, values), *same = quantity.items()
    rows = [
        (u, value, k < irregular(u, value), r(u, value) + 0.001 * (k - 1.5))
        for u in (7.0, 16.0)
        for value in values
        for k in range(4)
    ]
    u, value, state, disorder = (np.array(each) for each in zip(*rows, strict=True))
    arrays = {"belt_velocity": u, name: value, "disorder_parameter": disorder, **dict(same)}
    arrays["state"] = np.where(state, "irregular", "periodic").astype("S9")
    return arrays


def test_disturbance_is_growth_shares_r_and_noise():
    kicks, steps, noises = (0.0, 1e-3, 0.1), (1e-4, 1e-3), (0.01, 1.0)
    kicked = settled(lambda u, k: (u > 10) + 2 * (k > 0.01), lambda u, k: u + k, kick=kicks)
    scheme = settled(lambda u, s: 1 + 2 * (s > 5e-4), lambda u, s: u - s, time_step=steps)
    noisy = [
        settled(lambda u, s: 0, lambda u, s, dt=dt: u + s + 100 * dt, noise=noises)
        | {"time_step": np.full(16, dt)}
        for dt in (1e-5, 1e-3)
    ]
    noisy = {name: np.concatenate([each[name] for each in noisy]) for name in noisy[0]}
    data = {
        name: Dataset(arrays, HOW | {"kind": "settling", "transient": None})
        for name, arrays in (("steps", scheme), ("kicked", kicked), ("weak_noise", noisy))
    }
    figure = shown("disturbance", growth=growth(), **data)
    alt_fits("disturbance", figure)
    rates, share, disorder, noise = figure.panels
    is_growth(rates)
    axes_are(share, "disturbance of a slip", "share of irregular runs", scales=("log", "linear"))
    axes_are(disorder, "disturbance of a slip", "$r$", scales=("log", "linear"))
    axes_are(noise, r"$\sigma$", "$r$", scales=("log", "linear"))
    for index, u in enumerate((7.0, 16.0)):
        by_kick, by_step = share.curves[2 * index : 2 * index + 2]
        label = f"$u = {u:g}$"
        more = 0.25 * (u > 10)
        same(by_kick, [1e-3, 0.1], [more, more + 0.5], label=label, index=index, marker="o")
        sizes = u * np.array(steps) / 3**0.5
        same(by_step, sizes, [0.25, 0.75], index=index, marker="s")
        by_kick, by_step = disorder.curves[2 * index : 2 * index + 2]
        same(by_kick, [1e-3, 0.1], [u + 1e-3, u + 0.1], index=index)
        same(by_step, sizes, [u - 1e-4, u - 1e-3], index=index)
        np.testing.assert_allclose(by_kick.error, np.std([0, 1, 2, 3], ddof=1) * 0.001 / 2)
        line, fine, coarse = noise.curves[3 * index : 3 * index + 3]
        same(line, [1e-3, 0.1], [u + 1e-3, u + 0.1], index=index)
        for curve, dt, words in ((fine, 1e-5, "10^{-5}"), (coarse, 1e-3, "0.001")):
            label = f"$u = {u:g}$, $dt = {words}$"
            expected = [u + s + 100 * dt for s in noises]
            same(curve, noises, expected, label=label, index=index)


def is_growth(panel):
    axes_are(panel, "distance of two runs", "rate of growth", scales=("log", "log"))
    levels = np.geomspace(1e-6, 1e-2, 9)
    sizes = np.sqrt(levels[1:] * levels[:-1])[1:]  # of the first level nothing is counted
    rates = [curve for curve in panel.curves if curve.label]
    for curve, (n, method) in zip(rates, RATES, strict=True):
        marker = {"event": "o", "verlet": "x"}[method]
        rates = np.full(7, RATES[n, method])
        index = {5: 0, 7: 1}[n]
        same(curve, sizes, rates, label=f"$N = {n}$, {method}", index=index, marker=marker)


# --- comparison of integrators --------------------------------------------------------------------


def pair(name, tested, reference, **others):
    """Datasets of a comparison in the order of its entry, by method."""
    arrays = [tested, reference, *others.values()]
    methods = ["verlet", "event", "event"]
    return {
        used: Dataset(each, HOW | {"kind": "any", "method": method})
        for used, each, method in zip(FIGURES[name].uses, arrays, methods, strict=False)
    }


def columns(rows, *names):
    return dict(zip(names, map(np.array, zip(*rows, strict=True)), strict=True))


VELOCITIES, NOISES, RUNS = (10.0, 30.0, 50.0), (1.0, 5.0), 9


def noisy_r(side, u, s):
    """r of several runs at a point by one of the methods."""
    scatter = np.random.default_rng([side, int(u), int(s)]).normal(0, 0.01, RUNS)
    return 0.01 * side + 0.001 * u + 0.002 * s + scatter


def test_disorder_of_two_integrators():
    sides = []
    for side in (1, 2):
        rows = [(5, u, s, v) for u in VELOCITIES for s in NOISES for v in noisy_r(side, u, s)]
        rows = [rows[index] for index in RNG.permutation(len(rows))]
        sides.append(columns(rows, "n_blocks", "belt_velocity", "noise", "disorder_parameter"))
    values = [{measure.DISORDER: side["disorder_parameter"]} for side in sides]
    table = pd.DataFrame(measure.compare_points(*sides, *values))
    figure = shown("agreement_disorder", **pair("agreement_disorder", *sides), agreement=table)
    alt_fits("agreement_disorder", figure)
    left, middle, right = figure.panels
    axes_are(left, "$u$", "$r$")
    axes_are(middle, "$u$", "difference / standard error")
    axes_are(right, "expected in order", "p-value")
    assert [panel.titles[0] for panel in figure.panels] == ["a.", "b.", "c."]
    labels = tuple(rf"$\sigma = {s:g}$" for s in NOISES)
    assert figure.legend == labels and right.legend == ("distributions", "means")
    ks, welch = [], []
    for index, (s, label) in enumerate(zip(NOISES, labels, strict=True)):
        ours, theirs = ([noisy_r(side, u, s) for u in VELOCITIES] for side in (1, 2))
        line, crosses = left.curves[2 * index : 2 * index + 2]
        same(line, VELOCITIES, np.mean(theirs, axis=1), index=index, marker="")
        same(crosses, VELOCITIES, np.mean(ours, axis=1), index=index, marker="x", label=label)
        errors = [np.std(each, axis=1, ddof=1) / 3 for each in (ours, theirs)]
        np.testing.assert_allclose(crosses.error, errors[0])
        z = (np.mean(ours, axis=1) - np.mean(theirs, axis=1)) / np.hypot(*errors)
        same(middle.curves[index], VELOCITIES, z, index=index)
        for one, other in zip(ours, theirs, strict=True):
            ks.append(stats.ks_2samp(one, other).pvalue)
            welch.append(stats.ttest_ind(one, other, equal_var=False).pvalue)
    assert middle.spans == (("y", -2, 2),)
    limit = samples.largest_of(6)
    assert middle.guides == (("y", -limit), ("y", limit))
    diagonal, distributions, means = right.curves
    same(diagonal, [0, 1], [0, 1])
    share = (np.arange(6) + 0.5) / 6
    same(distributions, share, np.sort(ks), label="distributions")
    same(means, share, np.sort(welch), label="means")


def settled_r(side, u, spread, step):
    """(sticks, r) of some runs at their end; the number that sticks tells where they belong."""
    rng = np.random.default_rng([side, int(u), int(1000 * spread), int(1e4 * step)])
    sticks = np.arange(RUNS) < rng.integers(1, RUNS)
    return list(zip(sticks, rng.uniform(0.01, 0.2, RUNS), strict=True))


def test_attractors_of_two_integrators():
    spreads, steps = (0.001, 1.0), {1: (0.001, 0.002), 2: (0.001,)}
    sides = []
    for side in (1, 2):
        rows = [
            (u, spread, step, *run)
            for u in VELOCITIES
            for spread in spreads
            for step in steps[side]
            for run in settled_r(side, u, spread, step)
        ]
        rows = [rows[index] for index in RNG.permutation(len(rows))]
        names = ("belt_velocity", "initial_spread", "time_step", "sticks", "final_disorder")
        arrays = columns(rows, *names)
        rate = np.zeros((len(rows), 5))
        rate[:, -1] = arrays["sticks"]
        escaped = np.ones(len(rows), dtype=bool)
        chain = {"n_blocks": np.full(escaped.size, 5), "noise": np.zeros(escaped.size)}
        end = {"final_stick_rate": rate, "escaped": escaped, "lifetime": np.ones(escaped.size)}
        sides.append(arrays | chain | end)
    table = pd.DataFrame(measure.compare_attractors(*sides))
    figure = shown("agreement_attractors", **pair("agreement_attractors", *sides), agreement=table)
    alt_fits("agreement_attractors", figure)
    looks = [
        ("verlet, $dt = 0.001$", style.COLOURS[0], 1, 0.001),
        ("verlet, $dt = 0.002$", style.COLOURS[1], 1, 0.002),
        ("event", style.BLACK, 2, 0.001),
    ]
    assert figure.legend == tuple(label for label, *_ in looks)
    for row, spread in enumerate(spreads):
        left, right = figure.panels[2 * row : 2 * row + 2]
        assert left.titles[0] == f"initial spread {spread:g}"
        assert (left.ylabel, right.ylabel) == ("share still sticking", "$r$ at the end")
        dots = iter(right.curves)
        for (label, colour, side, step), shares in zip(looks, left.curves, strict=True):
            runs = [settled_r(side, u, spread, step) for u in VELOCITIES]
            sticks = np.array([[stuck for stuck, _ in at_u] for at_u in runs], dtype=float)
            same(shares, shares.x, sticks.mean(axis=1), label=label, colour=colour)
            np.testing.assert_allclose(shares.error, sticks.std(axis=1, ddof=1) / np.sqrt(RUNS))
            assert np.abs(shares.x - np.arange(3)).max() < 0.5
            for place, (at_u, curve) in enumerate(zip(runs, dots, strict=False)):
                np.testing.assert_allclose(curve.y, sorted(r for _, r in at_u))
                assert np.abs(curve.x - place).max() < 0.5 and curve.colour == colour
    for panel in figure.panels[-2:]:
        assert panel.xlabel == "$u$" and panel.xticks == ("10", "30", "50")


PATH_TIME = np.arange(0.0, 100.25, 0.5)
EVENT_TIME = 10.0 + 2 * np.arange(25)
MEMBERS = (1.0, 2.0, 10.0)


def drift(n, u, size):
    """How fast runs of an error part, without the factor of the member."""
    return size * (1 + n / 10 + u / 100)


def paths(rows):
    """Runs (N, u, member, time step, allowed error, size of the error) with errors from t = 10."""
    names = ("n_blocks", "belt_velocity", "replicate", "time_step", "allowed_error", "size")
    arrays = columns(rows, *names)
    time = PATH_TIME
    shape = (len(rows), time.size, 10)
    positions = np.broadcast_to(52.0 * np.arange(1, 11), shape) + 0.1 * np.sin(time)[:, np.newaxis]
    velocities = np.broadcast_to(0.3 * np.arange(1, 11), shape).copy()
    events = []
    for row, (n, u, member, _, _, size) in enumerate(rows):
        error = MEMBERS[member] * drift(n, u, size)
        positions[row, :, n - 1] += error * np.maximum(time - 10, 0)
        positions[row, :, n:] = velocities[row, :, n:] = np.nan
        for number, instant in enumerate(EVENT_TIME):
            kind = ("slip", "stick")[number % 2]
            events.append((row, instant + 0.01 * error * (number + 1), 1, kind))
    fields = [("point", "i4"), ("time", "f8"), ("block", "i4"), ("kind", "U5")]
    law = {each.name: each.default for each in dataclasses.fields(ChainParameters)
           if each.default is not dataclasses.MISSING}  # fmt: skip
    alike = {name: np.full(len(rows), value) for name, value in law.items()}
    return alike | arrays | {
        "time": time,
        "positions": positions,
        "velocities": velocities,
        "events": np.array(events, fields),
    }  # fmt: skip


PLACES = [(2, 3.0), (5, 3.0), (5, 20.0), (10, 20.0)]


def all_paths():
    """Runs by verlet with three steps, by event with two, and by event with four tolerances."""
    places = [(n, u, member) for n, u in PLACES for member in range(3)]
    steps = [(*place, dt, np.nan, dt) for place in places for dt in (0.004, 0.002, 0.001)]
    exact = [(*place, dt, np.nan, 0.0) for place in places for dt in (0.001, 0.002)]
    allowed = [(*place, 0.001, e, 1e-3 * e) for place in places for e in (1e-2, 1e-4, 1e-6)]
    tightest = [(*place, 0.001, 1e-14, 0.0) for place in places]
    return paths(steps), paths(exact), paths(allowed + tightest)


def after(n_events, n, u, size):
    """Root-mean-square separation at the first sample after so many events of the reference."""
    time, instant = PATH_TIME, EVENT_TIME[n_events - 1]
    sample = time[time > instant][0]
    return np.sqrt(np.mean(np.square(MEMBERS))) * drift(n, u, size) * (sample - 10)


def test_trajectories_of_two_integrators():
    tested, reference, tolerances = all_paths()
    data = pair("agreement_trajectories", tested, reference)
    others = {"pairs_paths_tolerances": Dataset(tolerances, HOW | {"method": "event"})}
    data["convergence"] = measure.convergence(data | others)
    figure = shown("agreement_trajectories", **data)
    alt_fits("agreement_trajectories", figure)
    first, second, third, fourth = figure.panels
    assert [panel.titles[0] for panel in figure.panels] == ["a.", "b.", "c.", "d."]
    axes_are(first, "$t$", "separation of the blocks", scales=("linear", "log"))
    axes_are(second, "$t$ of the event", "shift of the event", scales=("linear", "log"))
    assert first.titles[1] == second.titles[1] == "$dt = 0.001$"
    assert first.guides == (("y", 1.0),)
    labels = [f"$N = {n}$, $u = {u:g}$" for n, u in PLACES]
    assert figure.legend == tuple(labels)
    edges, instants = np.linspace(0, 100, 41), EVENT_TIME
    for index, (n, u) in enumerate(PLACES):
        slope = 2 * drift(n, u, 0.001)  # of the member in the middle
        separation = slope * np.maximum(PATH_TIME - 10, 0)
        same(first.curves[index], PATH_TIME, np.where(separation > 0, separation, np.nan),
             index=index, rtol=1e-6)  # fmt: skip
        shifts = 0.01 * np.outer(MEMBERS, np.arange(1, 26)) * drift(n, u, 0.001)
        found = {}
        for low, high in itertools.pairwise(edges):
            inside = (instants >= low) & (instants < high)
            if inside.any():
                found[(low + high) / 2] = np.median(shifts[:, inside])
        same(second.curves[index], list(found), list(found.values()), label=labels[index],
             index=index, rtol=1e-6)  # fmt: skip
    assert third.titles[1] == "verlet, $N = 5$, $u = 20$"
    is_convergence(third, "$dt$", (1, 5, 20), [0.001, 0.002, 0.004], [0.001, 0.002, 0.004], 1)
    assert fourth.titles[1] == "event, $N = 5$, $u = 20$"
    here = (tolerances["n_blocks"] == 5) & (tolerances["belt_velocity"] == 20)
    step = divergence.with_steps(tolerances)["step"]
    allowed = (1e-6, 1e-4, 1e-2)
    steps = [step[here & (tolerances["allowed_error"] == e)].mean() for e in allowed]
    sizes = [1e-3 * e for e in allowed]
    xlabel = "mean step, tolerances 1e-06 to 0.01"
    is_convergence(fourth, xlabel, (2, 5, 20), steps, sizes, FORCE_ORDER + 1)
    assert fourth.guides == (("y", divergence.ROUNDING_OF_LONG_STEPS),)


def is_convergence(panel, xlabel, numbers, steps, sizes, order):
    """Errors at N = 5, u = 20 after these numbers of events, over a line of this order."""
    axes_are(panel, xlabel, "error", scales=("log", "log"))
    *curves, guide = panel.curves
    for index, (curve, count) in enumerate(zip(curves, numbers, strict=True)):
        words = f"after {count} event{'s' if count > 1 else ''}: order"
        assert curve.label.startswith(words)
        errors = [after(count, 5, 20.0, size) for size in sizes]
        same(curve, steps, errors, label=curve.label, index=index, rtol=1e-6)
        slope = stats.linregress(np.log(steps), np.log(errors)).slope
        assert f"${slope:.2f} \\pm" in curve.label
    assert guide.label == f"order {order}"
    slope = np.diff(np.log(guide.y)) / np.diff(np.log(guide.x))
    np.testing.assert_allclose(slope, order)
    assert np.all(guide.y[-1] < [curve.y[-1] for curve in curves])


# --- Figs. 2 to 5: the virtual experiment ---------------------------------------------------------


def marked(figure):
    """Says at its top that the experiment is no real one."""
    return "virtual experiment" in figure.top


def test_fig02_is_the_first_frame_with_a_line_to_each_part():
    figure = shown("fig02")
    (panel,) = figure.panels
    assert marked(figure)
    run, first = RECORDED["belt_028"], next(RECORDED["belt_028_film"]())
    (image,) = panel.images
    np.testing.assert_array_equal(image.values, first.picture)
    assert panel.titles[1].startswith(r"$u$ = 0.28 m/s = 15.30,  $\sigma$ = 1")
    # lines end at the blocks: what is white under the last one, and black under the others
    ends = dict(panel.pointers)
    places = [ends[words] for words in ("1", "2", "3", "4", "block 5, white top")]
    beneath = [int(image.values[round(y) + 8, round(x)]) for x, y in places]
    assert beneath[-1] > 150 > 25 > max(beneath[:-1])
    metres = run.arrays["positions"][0] * LENGTH_M
    gaps = np.diff([x for x, _ in places]) * recorded.PIXEL
    assert gaps == pytest.approx(np.diff(metres), abs=0.002)
    assert {"tape measure", "spring", "fixed point, zero of the tape"} <= set(ends)


def test_fig03_is_a_second_of_frames_with_the_track_on_the_white():
    figure = shown("fig03")
    strips, trace = figure.panels
    assert marked(figure)
    axes_are(strips, "$x_5$ (cm)", "$t$ (s)")
    axes_are(trace, "$t$ (s)", "$x_5$ (cm)")
    track = RECORDED["belt_028_track"]
    (span,) = trace.spans
    chosen = (track.time_s >= span[1] - 1e-9) & (track.time_s <= span[2] + 1e-9)
    assert chosen.sum() == 24
    (dots,) = [curve for curve in strips.curves if curve.marker]
    same(dots, 100 * track.x_m[chosen], np.arange(24) + 0.5)
    (image,) = strips.images
    assert set(np.unique(image.values)) == {0, 1}
    rows = np.array_split(image.values, 24)
    centres = (image.x_edges[:-1] + image.x_edges[1:]) / 2
    seen = [np.average(centres, weights=strip.sum(axis=0)) for strip in rows]
    # now and then the threshold also lets the support through, which is no block by its shape
    near = np.abs(seen - 100 * track.x_m[chosen]) < 0.2
    assert near.sum() >= 22
    early = track.time_s <= 10
    same(trace.curves[0], track.time_s[early], 100 * track.x_m[early])
    speed = np.diff(track.x_m[early])
    assert np.flatnonzero(early)[0] <= speed.argmin() and chosen[speed.argmin()]


def test_fig04_is_two_recordings_with_spectra_of_small_and_large_amplitudes():
    figure = shown("fig04")
    assert marked(figure)
    assert len(figure.panels) == 6
    for name, (trace, small, large) in (
        ("belt_028", figure.panels[:3]),
        ("belt_035", figure.panels[3:]),
    ):
        found = recording.analyse(RECORDED[f"{name}_track"].time_s, RECORDED[f"{name}_track"].x_m)
        same(trace.curves[0], found.time_s, 100 * found.x_m)
        assert f"$r$ = {found.disorder_parameter:.4f}" in trace.titles[2]
        for panel, part in ((small, "small"), (large, "large")):
            spectrum = found.spectra[part]
            kept = spectrum.frequency_hz <= 8
            same(panel.curves[0], spectrum.frequency_hz[kept], spectrum.power[kept])
            assert panel.titles[1].startswith(f"{part} amplitude, {spectrum.begin_s:.0f} s to")
        steps = [place for axis, place in small.guides if axis == "x"]
        assert steps == pytest.approx(recorded.FUNDAMENTAL * np.arange(1, 7), abs=0.01)
        assert "multiples of 0.6 Hz: p = 0.001" in " ".join(small.texts)
        assert not large.guides


def test_fig04_says_where_the_model_does_not_alternate():
    restless = recorded.track(recorded.run(0.28, 1.0, seed=2))
    _, small, *_ = shown("fig04", belt_028_track=restless).panels
    (words,) = small.texts
    assert "does not alternate here" in " ".join(words.split()) and not small.curves


def test_fig05_is_the_recording_with_the_spectrum_of_all_of_it():
    figure = shown("fig05")
    assert marked(figure)
    trace, below = figure.panels
    found = recording.analyse(RECORDED["belt_022_track"].time_s, RECORDED["belt_022_track"].x_m)
    same(trace.curves[0], found.time_s, 100 * found.x_m)
    spectrum = found.spectra["whole"]
    kept = spectrum.frequency_hz <= 8
    same(below.curves[0], spectrum.frequency_hz[kept], spectrum.power[kept])
    assert "slip at once for 1.2e+02 s at most" in " ".join(trace.texts)

"""Every figure draws, whole or from hardly any data, labelled, not blank, the same bytes twice."""

import dataclasses
import functools
import importlib
import subprocess
import sys

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from alternating import studies
from beltrepro.base.errors import InputError
from beltrepro.base.store import Dataset
from beltrepro.model import ChainParameters
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan import registry
from beltrepro.replication.studies.chaos import mean_lifetimes
from beltrepro.replication.studies.laws import fig07
from beltrepro.replication.studies.noise import fig18
from beltrepro.replication.studies.transition import fig12
from irregular import motion, separation, settling, survivals
from recorded import cut, recordings

FIGURES = registry.figures()
# The comparison of integrators is drawn in its own tests.
NAMES = [name for name, entry in FIGURES.items() if entry.category != "Integrators compared"]
SPEEDS = ("022", "028", "035")

EVENTS = [
    ("time", "f8"),
    ("block", "i8"),
    ("kind", "U5"),
    ("force", "f8"),
    ("position", "f8"),
    ("dissipated", "f8"),
]
SLIPS = [
    ("point", "i4"),
    ("block", "i4"),
    ("start_time", "f8"),
    ("stop_time", "f8"),
    ("start_position", "f8"),
    ("stop_position", "f8"),
    ("dissipated", "f8"),
]
AVALANCHES = [
    ("point", "i4"),
    ("start_time", "f8"),
    ("stop_time", "f8"),
    ("slips", "i4"),
    ("blocks", "i4"),
    ("dissipated", "f8"),
    ("spring_energy_drop", "f8"),
    ("last_block_displacement", "f8"),
]
HOW = {
    "preset": "smoke",
    "method": "verlet",
    "time_step": 0.001,
    "duration": 2000.0,
    "transient": 500.0,
    "seed": 1,
    "code_version": "0.0+gabc",
}
# Constants of the law, as a file of one chain has them among its attributes.
LAW = {
    each.name: each.default
    for each in dataclasses.fields(ChainParameters)
    if each.default is not dataclasses.MISSING
}


def module(name):
    return importlib.import_module(registry.figures()[name].module)


# --- datasets of the right form -------------------------------------------------------------------


def series(n_blocks, belt_velocity, noise, *, length=1500, interval=0.1, transient=0.0):
    """A sawtooth: each block sticks for 20 and slips for 4, one after the other."""
    time = transient + interval * np.arange(length)
    block = np.arange(1, n_blocks + 1)
    phase = (time[:, np.newaxis] + 3 * block) % 24
    slips = phase >= 20
    climb = np.where(slips, 20 * (24 - phase) / 4, phase)
    velocities = np.where(slips, -5 * np.sin((phase - 20) * np.pi / 4), 1.0) * belt_velocity
    positions = 60.0 * block + climb
    force = 70 * (1 - 2 * phase / 24)
    friction = np.where(slips, 32 + 0.45 * noise * np.cos(977 * phase), -force)
    events = []
    for index in range(n_blocks):
        for instant in np.flatnonzero(np.diff(slips[:, index].astype(int))) + 1:
            kind = "slip" if slips[instant, index] else "stick"
            events.append((time[instant], index + 1, kind, force[instant, index], 0.0, 0.0))
    arrays = {
        "time": time,
        "positions": positions,
        "velocities": velocities,
        "friction": friction,
        "events": np.sort(np.array(events, EVENTS), order="time"),
    }
    chain = {"n_blocks": n_blocks, "belt_velocity": belt_velocity, "noise": noise}
    attributes = HOW | LAW | chain | {"kind": "series", "transient": transient}
    return Dataset(arrays, attributes)


def scan(sizes, velocities, noises, *, crossings=30):
    """r that falls with u and rises with sigma; bands of velocities, periodic at every third u."""
    rng = np.random.default_rng(5)
    grid = np.array([(n, u, s) for n in sizes for u in velocities for s in noises], dtype=float)
    n_blocks, belt_velocity, noise = grid.reshape(-1, 3).T
    count = n_blocks.size
    disorder = 0.02 + 0.11 / (1 + np.exp((belt_velocity - 16 - noise) / 2))
    spread = np.where(np.arange(count) % 3, 30.0, 0.1 + noise)[:, np.newaxis]
    section = -40 + spread * rng.uniform(-1, 1, (count, crossings))
    section[:, crossings // 2 :: 2] = np.nan
    laminar = np.clip((belt_velocity - 10) / 20, 0, 1) * (noise > 1)
    arrays = {
        "n_blocks": n_blocks.astype(int),
        "belt_velocity": belt_velocity,
        "noise": noise,
        "replicate": np.zeros(count, dtype=int),
        "disorder_parameter": disorder,
        "section_position": 123 * n_blocks,
        "section_velocity": section.astype("f4"),
        "laminar_fraction": laminar,
        "laminar_count": (10 * laminar).astype(int),
        "last_stick_time": np.where(laminar > 0, np.nan, 1990.0),
    }
    return Dataset(arrays, HOW | {"kind": "scan", "laminar_time": 200.0})


def catalogue(count=400, section_points=300):
    rng = np.random.default_rng(6)
    start = np.cumsum(rng.uniform(10, 20, count))
    size = 50 * (1 - 0.95 * rng.random(count)) ** -0.7
    slips = np.zeros(count, SLIPS)
    slips["block"] = 5
    slips["start_time"], slips["stop_time"] = start, start + 3
    slips["start_position"], slips["dissipated"] = size, 30 * size
    avalanches = np.zeros(count, AVALANCHES)
    avalanches["start_time"], avalanches["stop_time"] = start - 1, start + 4
    avalanches["dissipated"] = 90 * size
    points = [("point", "i4"), ("time", "f8"), ("positions", "f8", 5), ("velocities", "f8", 5)]
    section = np.zeros(section_points, points)
    section["positions"][:, -1] = 600 + 50 * rng.standard_normal(section_points)
    section["velocities"][:, -1] = np.minimum(1, -40 * rng.standard_normal(section_points))
    chain = {"n_blocks": 5, "belt_velocity": 1.0, "noise": 0.0}
    where = {"section_block": 2, "section_position": 304.3}
    arrays = {"slips": slips, "avalanches": avalanches, "section": section}
    return Dataset(arrays, HOW | chain | where | {"kind": "catalogue"})


def of_blocks(n_blocks, **how):
    """The same catalogue under another number of blocks."""
    data = catalogue(**how)
    return Dataset(data.arrays, data.attributes | {"n_blocks": n_blocks})


def critical():
    """The table of critical velocities; r does not fall at the last point."""
    names = ("n5_replicates", "n5_replicates_check", "n5_replicates_wide", "size_replicates")
    rows = [
        (name, 5 + place, noise, 17.0 + place, 0.4, 16.0, 19.0)
        for place, name in enumerate(names)
        for noise in (0.0, 1.0)
    ]
    columns = ["dataset", "n_blocks", "noise", "critical", "error", "lower", "upper"]
    return pd.DataFrame(rows, columns=columns)


def escapes_of(velocities, members=20, *, escapes=True):
    rng = np.random.default_rng(7)
    belt_velocity = np.repeat(velocities, members)
    lifetime = rng.exponential(200 + 3e4 / belt_velocity)
    escaped = (lifetime < 2000) & escapes
    arrays = {"belt_velocity": belt_velocity, "lifetime": lifetime, "escaped": escaped}
    return Dataset(arrays, HOW | {"kind": "escapes", "n_blocks": 5, "noise": 0.0})


def study(ratios):
    """A scan with a column of friction ratios."""
    data = scan([5], np.arange(1.0, 50, 3), [0.0])
    count = data.arrays["noise"].size
    arrays = {
        name: np.concatenate([values] * len(ratios)) if len(ratios) else values[:0]
        for name, values in data.arrays.items()
    }
    column = {"friction_ratio": np.repeat(ratios, count)}
    return Dataset(arrays | column, data.attributes)


def falls(ratios):
    """The table of transitions for the same ratios."""
    rows = [(ratio, 20 + ratio, 0.5, 15.0, 25.0) for ratio in ratios]
    return pd.DataFrame(rows, columns=["friction_ratio", "critical", "error", "lower", "upper"])


def lasting(velocities=(3.0, 12.0, 33.0), *, runs=12):
    """The dataset and the table of the survival of irregular motion, and what goes beside them."""
    u = {"belt_velocity": np.array(velocities)}
    made = survivals(n_blocks=[4, 6, 10], **u, initial_spread=[1.0, 10.0])
    made["mean_lifetimes"] = mean_lifetimes.derive(made)
    levels, how = [0.0, 1e-7, 1e-3], {"n_blocks": [5], **u, "runs": runs}
    made["motion_map"] = motion(n_blocks=[2, 4, 6, 10], **u, runs=runs)
    made["kicked"] = settling(**how, method=["event"], kick=levels, errors="kick")
    made["steps"] = settling(**how, method=["verlet"], time_step=levels[1:], errors="time_step")
    made["weak_noise"] = settling(
        **how, kick=[0.0], time_step=[1e-3, 1e-5], noise=[0.01, 0.3], errors="noise"
    )
    made["growth"] = separation(n_blocks=[5], **u, runs=runs)
    return made


def needed(name):
    """Datasets of a figure without those that are drawn over others."""
    return [used for used in FIGURES[name].uses if not used.endswith(panels.CHECK)]


def usual(name):
    """Data of the size of a short run for each dataset that a figure uses."""
    u = np.arange(1.0, 50, 3)
    quiet, noisy = (0.0, 0.25, 0.5, 1.0, 2.2, 5.0, 10.0), np.arange(0.0, 10.1, 2)
    made = {
        "friction_event": lambda: series(5, 1.0, 1.0, length=4000, interval=0.01),
        "u1": lambda: series(5, 1.0, 0.0),
        "slips_u1": catalogue,
        "slips_u1_event": catalogue,
        "u20": lambda: series(5, 20.0, 0.0),
        "u17": lambda: series(5, 17.5, 2.2),
        "u19": lambda: series(5, 19.0, 2.2),
        "n5_rows": lambda: scan([5], u, quiet),
        "n5_map": lambda: scan([5], u, noisy),
        "n5_u7": lambda: scan([5], [7.0], np.arange(0.0, 2.1, 0.25)),
        "n5_columns": lambda: scan([5], [20.0, 30.0, 40.0], noisy),
        "n5_replicates": lambda: scan([5], u, quiet[:-1]),
        "size_replicates": lambda: scan([6, 7, 10], u, [0.0, 1.0]),
        "size_rows": lambda: scan([2, 3, 4, 6, 7, 10], u, [0.0, 1.0, 5.0]),
        "size_columns": lambda: scan([5, 7], [18.0], noisy),
        "lifetimes": lambda: escapes_of(np.arange(18.0, 36, 3)),
        "n5_replicates_wide": lambda: scan([5], u, [0.0]),
        "critical_velocities": critical,
        "slips_n3": lambda: of_blocks(3),
        "slips_n7": lambda: of_blocks(7),
        "slips_n10": lambda: of_blocks(10),
        "friction_ratio": lambda: study([0.2, 0.45]),
        "friction_falls": lambda: falls([0.2, 0.45]),
    } | {f"n10_u{v}": lambda v=v: series(10, float(v), 0.0) for v in (28, 31, 34, 38)}
    others = derived() | recorded()
    return {name: others[name] if name in others else made[name]() for name in needed(name)}


@functools.cache
def derived():
    return lasting() | studies()


@functools.cache
def hardly_derived():
    return lasting(()) | studies(noises=[0.5], ratios=[0.6], runs=1)


@functools.cache
def recorded():
    return recordings(seconds=120, calm=(40, 100))


def poor(name):
    """Hardly anything: a point or none, all NaN, nothing escapes, no events, no samples."""

    def point():
        data = scan([5], [7.0], [0.0])
        data.arrays["section_velocity"][:] = np.nan
        data.arrays["disorder_parameter"][:] = np.nan
        return data

    scans = ("n5_rows", "n5_u7", "n5_columns", "size_rows", "size_columns")
    scans += ("n5_replicates", "n5_replicates_wide", "size_replicates")
    made = dict.fromkeys(scans, point)
    made |= dict.fromkeys(("slips_n3", "slips_n7", "slips_n10"), lambda: of_blocks(3, count=0))
    made |= {
        "n5_map": lambda: scan([5], [], []),
        "lifetimes": lambda: escapes_of(np.array([18.0]), escapes=False),
        "slips_u1": lambda: catalogue(0, 0),
        "slips_u1_event": lambda: catalogue(0, 0),
        "critical_velocities": lambda: critical().assign(critical=np.nan),
        "friction_ratio": lambda: study([]),
        "friction_falls": lambda: falls([]),
    }
    made |= {dataset: lambda each=each: each for dataset, each in hardly_derived().items()}
    made |= {f"belt_{each}_track": lambda: cut(recorded()["belt_028_track"], 2) for each in SPEEDS}
    made |= {"belt_028_film": lambda: recorded()["belt_028_film"]}
    data = {}
    for dataset in needed(name):
        data[dataset] = made.get(dataset, lambda: series(10, 28.0, 0.0))()
        if "time" in getattr(data[dataset], "arrays", ()):
            short = {key: values[:0] for key, values in data[dataset].arrays.items()}
            data[dataset] = Dataset(short, data[dataset].attributes)
    return data


def draw(name, data) -> Figure:
    datasets = [each for each in data.values() if isinstance(each, Dataset)]
    return module(name).draw(data, style.small_print(datasets, "smoke"))


def quick(every):
    """Names of all figures; only one of so many is drawn in the quick tests."""
    return [
        pytest.param(name, marks=[] if index % every == 0 else pytest.mark.thorough)
        for index, name in enumerate(NAMES)
    ]


def written(figure, folder):
    paths = folder / "figure.png", folder / "figure.pdf"
    style.save(figure, *paths)
    return paths


# --- every figure ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", quick(6))
def test_draws(name, tmp_path):
    data = usual(name)
    figure = draw(name, data)
    png, pdf = written(figure, tmp_path)
    assert pdf.read_bytes().startswith(b"%PDF")
    assert imread(png)[..., :3].std() > 0.04
    assert figure.get_figwidth() > figure.get_figheight()
    # the insets of the paper are panels here, so that they cover no data
    assert not any(axes.child_axes for axes in figure.axes)
    for axes in figure.axes:
        assert axes.has_data(), "an empty panel"
        place = axes.get_subplotspec()
        if name not in ("fig01", "fig02") and place is not None:
            assert axes.get_xlabel() or not place.is_last_row()
            assert axes.get_ylabel() or not place.is_first_col()


@pytest.mark.parametrize("name", quick(30))
def test_drawn_again_it_has_the_same_bytes(name, tmp_path):
    data = usual(name)
    first, again = (written(draw(name, data), tmp_path / each) for each in ("first", "again"))
    for one, other in zip(first, again, strict=True):
        assert one.read_bytes() == other.read_bytes()


@pytest.mark.thorough
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.filterwarnings("error")
def test_says_what_is_missing(name, tmp_path):
    figure = draw(name, poor(name))
    figure.set_layout_engine("none")
    figure.savefig(tmp_path / "figure.png", dpi=50)
    for axes in figure.axes:
        assert axes.has_data() or axes.texts, "an empty panel without a word"
    if FIGURES[name].uses:
        inner = [child for axes in figure.axes for child in axes.child_axes]
        words = [text.get_text() for axes in [*figure.axes, *inner] for text in axes.texts]
        assert any(" " in text for text in words)


# --- the registry ---------------------------------------------------------------------------------


def test_every_module_that_draws_is_registered_as_it_says():
    drawing = {
        path.stem for path in registry.STUDIES.rglob("*.py") if "def draw(" in path.read_text()
    }
    assert set(FIGURES) == drawing
    for name, entry in FIGURES.items():
        assert entry == module(name).FIGURE
        if entry.number:
            assert name == f"fig{int(entry.number):02d}"
    for field in ("title", "words", "alt"):
        texts = [getattr(entry, field) for entry in FIGURES.values()]
        assert len(set(texts)) == len(texts)
        assert min(map(len, texts)) > 20


def test_the_figures_of_the_paper_come_first_in_its_order():
    numbers = [int(entry.number) for entry in FIGURES.values() if entry.number]
    assert numbers == [*range(1, 23)]
    order = [registry.CATEGORIES.index(entry.category) for entry in FIGURES.values()]
    assert order == sorted(order)


def test_the_registry_imports_no_figure():
    code = (
        "import sys; from beltrepro.replication.plan import registry; registry.figures(); "
        "print({'matplotlib', 'pandas', 'numba'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


GOOD = {
    "title": "'A title.'",
    "uses": "('a',)",
    "words": "'words'",
    "alt": "'alt'",
    "number": "'3'",
}


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"title": None}, "title is missing"),
        ({"uses": None}, "uses is missing"),
        ({"words": None}, "words is missing"),
        ({"alt": None}, "alt is missing"),
        ({"alt": "' '"}, "alt must be text"),
        ({"words": "3"}, "words must be text"),
        ({"title": "'No full stop'"}, "must be one sentence"),
        ({"title": "'Two.\\nLines.'"}, "must be one sentence"),
        ({"uses": "'a'"}, "uses = 'a': must be a tuple"),
        ({"uses": "('a', 'a')"}, "must be a tuple of different names"),
        ({"category": "'Others'"}, "category = 'Others': allowed are"),
        ({"number": None}, "number must be given"),
        ({"number": "3"}, "number = 3: must be text"),
        ({"category": "'Further studies'"}, "number must be given"),
        ({"titel": "'x'"}, "unknown field 'titel': allowed are title, uses"),
        ({"title": "NAME + '.'"}, "title = NAME + '.': must be a literal"),
    ],
)
def test_a_bad_entry_is_one_line(tmp_path, change, complaint):
    fields = {name: text for name, text in (GOOD | change).items() if text is not None}
    arguments = ", ".join(f"{name}={text}" for name, text in fields.items())
    (tmp_path / "fig03.py").write_text(f"FIGURE = Figure({arguments})\n")
    (tmp_path / "panels.py").write_text("def letter(axes): ...\n")
    with pytest.raises(InputError) as caught:
        registry.figures(tmp_path)
    message = str(caught.value)
    assert "/fig03.py: FIGURE: " in message and complaint in message and "\n" not in message


def test_a_good_entry_is_read(tmp_path):
    arguments = ", ".join(f"{name}={text}" for name, text in GOOD.items())
    (tmp_path / "one.py").write_text(f"FIGURE = Figure({arguments})\n")
    (entry,) = registry.figures(tmp_path).values()
    assert (entry.title, entry.uses, entry.number) == ("A title.", ("a",), "3")
    (tmp_path / "one.py").write_text("FIGURE = {}\n")
    registry.figures.cache_clear()
    with pytest.raises(InputError, match="must be Figure"):
        registry.figures(tmp_path)


# --- parts ----------------------------------------------------------------------------------------


def test_a_figure_can_be_written_again_in_any_format(tmp_path):
    figure = draw("fig06", {})
    png, _ = written(figure, tmp_path / "first")
    for name in ("again.pdf", "again.svg", "again.png"):
        style.write(figure, tmp_path / name, "figure")
    assert (tmp_path / "again.png").read_bytes() == png.read_bytes()


def test_own_style_whatever_the_settings(tmp_path):
    png, pdf = written(draw("fig06", {}), tmp_path / "plain")
    with matplotlib.rc_context({"font.size": 20, "savefig.dpi": 50, "lines.linewidth": 5}):
        other = written(draw("fig06", {}), tmp_path / "changed")
    assert [png.read_bytes(), pdf.read_bytes()] == [path.read_bytes() for path in other]


def test_small_print_tells_parameters_and_origin():
    words = style.small_print([scan([5], np.arange(1.0, 11), [0.0, 1.0])], "smoke")
    for part in ("0.0+gabc", "preset smoke", "seed 1", "N = 5", "u = 1 to 10 (10 values)"):
        assert part in words
    for part in ("σ = 0, 1", "method verlet", "dt = 0.001", "t = 2000", "t_trans = 500"):
        assert part in words
    assert "no simulation" in style.small_print([], "smoke")


def test_small_print_names_the_constants_that_differ_from_the_paper():
    usual = scan([5], np.arange(1.0, 4), [0.0])
    for name, value in (("friction_ratio", 0.45), ("rest_length", 50.0)):
        usual.arrays[name] = np.full(3, value)
    words = style.small_print([usual], "smoke")
    assert "f_s" not in words and "l = " not in words
    usual.arrays["friction_ratio"] = np.array([0.1, 0.45, 0.6])
    usual.arrays["rest_length"][:] = 40
    words = style.small_print([usual], "smoke")
    assert "f_s = 0.1, 0.45, 0.6, l = 40, method" in words


def test_small_print_joins_what_was_made_alike():
    every = [series(10, u, 0.0) for u in (28.0, 31.0)]
    assert "N = 10, u = 28, 31, σ = 0" in style.small_print(every, "smoke")
    assert style.small_print(every, "smoke").count("\n") == 1


def test_missing_dataset_is_named():
    with pytest.raises(InputError, match="lifetimes"):
        fig12.draw({"n5_rows": scan([5], [1.0], [0.0])}, "")


@pytest.mark.parametrize("name", ["fig12", "fig13", "fig15", "fig19", "fig21"])
def test_other_method_is_drawn_over(name):
    data = usual(name)
    plain = draw(name, data)
    first = next(used for used in ("size_rows", *needed(name)) if used in data)
    over = Dataset(data[first].arrays, data[first].attributes | {"method": "event"})
    both = draw(name, data | {first + panels.CHECK: over})
    lines = [sum(len(axes.lines) for axes in figure.axes) for figure in (plain, both)]
    assert lines[1] > lines[0]
    legends = [axes.get_legend() for axes in both.axes if axes.get_legend()]
    assert any(text.get_text() == "method event" for each in legends for text in each.get_texts())


def test_friction_event_is_the_first_complete_one_of_the_last_block():
    """The first slip of block 5 is at 5 = 20 - 3 * 5; it was stuck from the start."""
    event = fig07._choose_event(series(5, 1.0, 1.0, interval=0.01))
    assert event.block == 5
    assert (event.begin, event.start, event.stop) == pytest.approx((0, 5, 9))


def test_friction_event_falls_back_to_a_block_that_slips():
    data = series(5, 1.0, 1.0, length=3000, interval=0.01)
    data.arrays["events"] = data.arrays["events"][data.arrays["events"]["block"] == 2]
    assert fig07._choose_event(data).block == 2
    data.arrays["events"] = data.arrays["events"][:0]
    assert fig07._choose_event(data) is None


@pytest.mark.thorough
@pytest.mark.parametrize("count", [0, 10])
def test_map_keeps_its_size_without_an_intermittent_point(count):
    data = usual("fig18")
    data["n5_map"].arrays["laminar_count"][:] = count
    figure = draw("fig18", data)
    figure.draw_without_rendering()
    assert figure.axes[0].get_position().height > 0.3
    assert len(figure.axes[0].lines) == (count > 0)


def test_map_takes_medians_and_leaves_holes():
    points = {
        "belt_velocity": np.array([1.0, 1.0, 1.0, 2.0]),
        "noise": np.array([0.0, 0.0, 0.0, 1.0]),
        "disorder_parameter": np.array([0.1, 0.3, 0.2, 0.5]),
    }
    velocities, noises, disorder = fig18._table(points)
    assert velocities.tolist() == [1, 2]
    assert noises.tolist() == [0, 1]
    np.testing.assert_array_equal(disorder, [[0.2, np.nan], [np.nan, 0.5]])

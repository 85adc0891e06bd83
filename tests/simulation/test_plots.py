"""Pictures of one panel: what their artists hold, from results that are made up."""

import ast
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

import drawn
from beltrepro import (
    Catalogue,
    ChainParameters,
    Grid,
    LyapunovSpectrum,
    OrbitBranch,
    Results,
    Setup,
    scan,
)
from beltrepro.base.errors import InputError
from beltrepro.chaos.continuation import SpecialPoint
from beltrepro.simulation import artists
from beltrepro.simulation.setup import columns

RANDOM = np.random.default_rng(1)
U, NOISES, RUNS = np.array([5.0, 6.0, 8.0]), [0.0, 1.0], 16


@pytest.fixture
def axes():
    return Figure(figsize=(4, 3), dpi=100).subplots()


def made_up(**arrays):
    """A scan of 16 runs at three velocities and two noises."""
    table = columns(Setup(Grid(5, U, NOISES, replicates=RUNS), initial_spread=1.0))
    return Results(table | arrays, {})


@pytest.fixture(scope="module")
def results():
    size = U.size * len(NOISES) * RUNS
    velocity = -RANDOM.exponential(20.0, (size, 50))
    velocity[:, 40:] = np.nan
    disorder = RANDOM.random(size)
    disorder[3] = np.nan
    return made_up(
        disorder_parameter=disorder, mean_length=300 + disorder, section_velocity=velocity
    )


# --- envelopes, bands, densities ------------------------------------------------------------------


def test_an_envelope_has_the_least_and_greatest_value_of_each_pixel(axes):
    x = np.sort(RANDOM.uniform(10.0, 20.0, 40_000))
    y = np.sin(x) + RANDOM.standard_normal(x.size)
    place, low, high = drawn.corners(artists.envelope(axes, x, y))
    pixels = int(axes.bbox.width)
    assert place.size == pixels < 400
    edges = np.linspace(x[0], x[-1], pixels + 1)
    np.testing.assert_allclose(place, (edges[1:] + edges[:-1]) / 2)
    for column in (0, 7, pixels - 1):
        inside = y[(x >= edges[column]) & (x <= edges[column + 1])]
        assert (low[column], high[column]) == (inside.min(), inside.max())
    # all is there if there is room, and nothing where nothing is known
    assert np.array_equal(artists.envelope(axes, x[::200], y[::200]).get_ydata(), y[::200])
    y[(x > 14) & (x < 16)] = np.nan
    place, *_ = drawn.corners(artists.envelope(axes, x, y))
    assert 1.9 < np.diff(place).max() < 2.1


def test_a_band_is_ten_to_ninety_percent_about_the_mean(axes):
    values = RANDOM.standard_normal((3, 40))
    values[1, 5] = np.nan
    line = artists.band(axes, np.repeat(U, 40), values.ravel(), color="red")
    (shade,) = axes.collections
    np.testing.assert_allclose(line.get_xydata(), np.transpose([U, np.nanmean(values, axis=1)]))
    ends = np.nanquantile(values, [0.1, 0.9], axis=1)
    np.testing.assert_allclose(drawn.corners(shade), [U, *ends])
    artists.band(axes, U, values[:, 0])
    assert len(axes.collections) == 1  # one run has no band


def test_a_density_has_one_scale_and_integrates_to_one(results, axes):
    ax = results.plot_section(ax=axes, where={"noise": 1}, bins=70)
    (mesh,) = ax.collections
    corner, share = np.asarray(mesh.get_coordinates()), np.ma.filled(mesh.get_array(), 0.0)
    heights = np.diff(corner[:, 0, 1])
    np.testing.assert_allclose(heights @ share, 1.0)
    assert corner[0, :, 0].tolist() == [4.5, 5.5, 7.0, 9.0]
    here = results["section_velocity"][(results["noise"] == 1) & (results["belt_velocity"] == 6)]
    count, _ = np.histogram(here[np.isfinite(here)], corner[:, 0, 1])
    np.testing.assert_allclose(share[:, 1], count / count.sum() / heights)
    assert (mesh.norm.vmin, mesh.norm.vmax) == (share[share > 0].min(), share.max())
    assert artists.colour_limits(np.array([0.0, 1e-6, 0.5])) == {"vmin": 5e-4, "vmax": 0.5}
    assert mesh.colorbar.ax.get_ylabel() == "density (1 / model velocity)"
    assert ax.get_xlabel() == "$u$ (model velocity)"
    alone = results.plot_section(where={"noise": 0}, bar=False, vmax=1.0)
    assert alone.figure.axes == [alone] and alone.collections[0].norm.vmax == 1.0


def test_a_density_in_bins_of_the_scan_has_all_crossings(axes):
    lengths = {"duration": 300, "transient": 100, "section_values": 1}
    with warnings.catch_warnings(action="error"):
        few = scan(Grid(5, [8.0, 12.0]), **lengths, section_bins=[-100.0, -30.0, 0.0])
    (mesh,) = few.plot_section(ax=axes).collections
    counts = few["section_histogram"].T
    assert counts.sum() > 10
    share = counts / counts.sum(axis=0) / np.array([[70.0], [30.0]])
    np.testing.assert_allclose(np.ma.filled(mesh.get_array(), 0.0), share)
    with pytest.warns(match="^2 of 2 chains: of the crossings more than 5% lie outside"):
        none = scan(Grid(5, [8.0, 12.0]), **lengths, section_bins=[-1e4, -9e3])
    with pytest.raises(InputError, match="no crossing lies in them"):
        none.plot_section()


def test_sizes_are_a_density_by_the_logarithm(axes):
    slips = np.zeros(5000, [("point", "i4"), ("start_position", "f8"), ("stop_position", "f8"),
                            ("start_time", "f8"), ("stop_time", "f8")])  # fmt: skip
    slips["start_position"] = 10 ** RANDOM.normal(0.0, 1.0, 5000)
    slips["start_time"], slips["stop_time"] = np.arange(5000.0), np.arange(5000.0) + 0.5
    slips["point"][100:] = 1
    slips["start_position"][-1] = -3.0  # a slip forward has no size
    catalogue = Catalogue({"slips": slips, "avalanches": np.zeros(1, [("dissipated", "f8")])})
    catalogue.plot(ax=axes, kind="slips", size="displacement", bins_per_decade=5)
    (line,) = axes.lines
    place, density = line.get_data()
    half = 10**0.1
    assert np.sum(density * place * (half - 1 / half)) == pytest.approx(1)
    inside = (slips["start_position"] >= place[9] / half) & (
        slips["start_position"] < place[9] * half
    )
    assert density[9] * place[9] * (half - 1 / half) == pytest.approx(inside.sum() / 4999)
    assert axes.get_xlabel() == "displacement in a slip (model length)"
    axes.clear()
    catalogue.plot_slips(ax=axes)
    time, place = (values.reshape(100, 3) for values in axes.lines[0].get_data())
    for ends, what in ((time, "time"), (place, "position")):
        assert np.array_equal(ends[:, 0], slips[f"start_{what}"][:100])
        assert np.array_equal(ends[:, 1], slips[f"stop_{what}"][:100])
        assert np.isnan(ends[:, 2]).all()
    for call, words in (
        (catalogue.plot, "avalanches: none has a dissipated above 0"),
        (lambda: catalogue.plot_slips(point=7), "point = 7"),
        (lambda: catalogue.plot(kind="slip"), "did you mean 'slips'"),
        (lambda: catalogue.plot(size="disipated"), "did you mean 'dissipated'"),
    ):
        with pytest.raises(InputError, match=words):
            call()


# --- curves of several chains ---------------------------------------------------------------------


def test_a_curve_for_each_value_of_what_differs(results):
    ax = results.plot()
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$u$ (model velocity)", "$r$")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        r"$\sigma$ = 0", r"$\sigma$ = 1"]  # fmt: skip
    for noise, line in zip(NOISES, ax.lines, strict=True):
        runs = results["disorder_parameter"][results["noise"] == noise].reshape(-1, RUNS)
        runs = (
            runs if noise else results["disorder_parameter"][results["noise"] == 0].reshape(3, -1)
        )
        np.testing.assert_allclose(line.get_ydata(), np.nanmean(runs, axis=1))
    one = results.plot(where={"noise": 1.0}, y="mean_length", color="red", label="here")
    assert one.get_legend() is None and one.lines[0].get_color() == "red"
    assert one.get_ylabel() == r"$\langle x_{N} \rangle$ (model length)"
    assert one.get_legend_handles_labels()[1] == ["here"]
    assert results.plot(where={"noise": 1, "belt_velocity": 6}).lines[0].get_xdata() == [6.0]
    pooled = results.plot(by=())
    assert len(pooled.lines) == 1
    across = results.plot(x="noise", by="belt_velocity")
    assert across.get_xlabel() == r"$\sigma$ (model force)" and len(across.lines) == 3
    assert len({line.get_color() for line in across.lines}) == 3


@pytest.mark.parametrize(
    ("method", "given", "words"),
    [
        ("plot", {"y": "disorder"}, "y = 'disorder': .* did you mean 'disorder_parameter'"),
        ("plot", {"y": "method"}, "y = 'method': allowed are"),
        ("plot", {"x": "u"}, "did you mean 'belt_velocity'"),
        ("plot", {"by": ["noises"]}, "by = 'noises': .* did you mean 'noise'"),
        ("plot", {"where": {"noise": 3}}, "no chain has noise = 3"),
        ("plot", {"where": {"noize": 1}}, "did you mean 'noise'"),
        ("plot", {"where": "noise"}, "where = 'noise'"),
        ("plot", {"colour": "red"}, "no argument 'colour'; did you mean 'color'"),
        ("plot", {"whre": {}}, "Results.plot has no argument 'whre'; did you mean 'where'"),
        ("plot", {"color": "red"}, "color: each of several curves has its own"),
        ("plot_section", {"color": "red"}, "color: a density has many, which cmap names"),
        ("plot", {"ax": [1, 2]}, r"ax = \[1, 2\]: one Axes"),
        ("plot_section", {}, "noise has several values, a density is of one: where={'noise': 0}"),
        ("plot_section", {"where": {"noise": 0}, "bins": 0}, "bins"),
    ],
)
def test_a_wrong_name_is_one_line(results, method, given, words):
    with pytest.raises(InputError, match=words) as caught:
        getattr(results, method)(**given)
    assert "\n" not in str(caught.value) and len(str(caught.value)) <= 400


def test_chains_that_differ_in_blocks_method_or_time_step_are_no_replicates():
    sets = [(1, 3, 1), (3, 1, 1), (1, 1, 3.5)]
    chains = [ChainParameters(3, u, mass=mass) for u in (5.0, 6.0) for mass in sets]
    r, v = np.arange(6.0), -np.ones((6, 4))
    table = Results(columns(Setup(chains)) | {"disorder_parameter": r, "section_velocity": v}, {})
    for how in ({}, {"by": "mass"}):
        ax = table.plot(**how)
        assert ax.get_xlabel() == "$u$ (model velocity)"
        curves = {line.get_label(): line.get_ydata().tolist() for line in ax.lines}
        assert curves == {
            "$m$ = (1, 3, 1)": [0, 3],
            "$m$ = (3, 1, 1)": [1, 4],
            "$m$ = (1, 1, 3.5)": [2, 5],
        }
    one = table.plot(where={"mass": (3, 1, 1)}, lw=1)
    assert one.lines[0].get_ydata().tolist() == [1, 4] and one.get_legend() is None
    assert len(table.plot(where={"belt_velocity": 5}).lines) == 3
    with pytest.raises(InputError, match=r"mass has several values, .*'mass': '\(1, 3, 1\)'"):
        table.plot_section()
    table.plot_section(where={"mass": "(1, 3, 1)"})
    two = columns(Setup(Grid(3, [1.0, 2.0, 3.0], 1.0, replicates=2))) | {"disorder_parameter": r}
    means = {"method": ["event", "verlet"], "time_step": [0.1, 0.2], "initial_spread": [0.0, 1.0]}
    for name, values in (means | {"tolerance": [1e-10, 1e-9]}).items():
        drawn_lines = Results(two | {name: np.array(values * 3)}, {}).plot().lines
        assert [line.get_ydata().tolist() for line in drawn_lines] == [[0, 2, 4], [1, 3, 5]]
    methods = {
        "method": np.array(["event", "verlet"] * 3),
        "tolerance": np.array([1e-10, np.nan] * 3),
    }
    both = Results(two | methods, {})
    for by in (None, "tolerance", "method"):
        assert [line.get_ydata().tolist() for line in both.plot(by=by).lines] in (
            [[0, 2, 4], [1, 3, 5]],
            [[1, 3, 5], [0, 2, 4]],
        )
    masses = columns(Setup([ChainParameters(2, 5.0, mass=mass) for mass in ((1, 2), 1)]))
    some = Results(masses | {"disorder_parameter": np.arange(2.0)}, {})
    assert some.plot(where={"mass": 1}).lines[0].get_ydata().tolist() == [1]


def test_crossings_of_several_sections_are_no_one_density():
    chains = [ChainParameters(3, 10.0, 1.0)] * 2
    how = {"duration": 400, "transient": 100, "replicate": [1, 2]}
    both = scan(chains, section_position=[300.0, 305.0], **how)
    with pytest.raises(InputError, match=r"where=\{'section_position': 300\}"):
        both.plot_section()
    both.plot_section(where={"section_position": 300.0})
    scan(chains, **how).plot_section()


def test_the_value_that_a_refused_density_names_is_one_of_the_table():
    table = scan(Grid(3, [9.0, 10.0 / 0.8317], noise=[1.0, 2.0]), duration=300, transient=100)
    with pytest.raises(InputError, match="a density is of one") as caught:
        table.plot_section(x="noise")
    where = ast.literal_eval(str(caught.value).rpartition("where=")[2])
    table.plot_section(x="noise", where=where)


def test_chains_that_failed_and_places_at_infinity_are_not_drawn():
    grid = columns(Setup(Grid(2, [5.0, 6.0], 0, replicates=2, linear_limit=[10.0, np.inf])))
    error = np.array(["", "meet", *[""] * 4, "meet", "meet"])
    table = Results(grid | {"slip_count": np.where(error == "", 4, 0), "error": error}, {})
    curves = table.plot(y="slip_count").lines
    drawn_places = [np.isfinite(line.get_ydata()).tolist() for line in curves]
    assert {value for line in curves for value in line.get_ydata() if value == value} == {4.0}
    assert sum(map(sum, drawn_places)) == 3  # of four places, at one of which both have failed
    with pytest.warns(UserWarning, match="linear_limit is infinite in 4 of 8 chains: they are not"):
        table.plot(y="slip_count", x="linear_limit")


def test_a_small_value_is_no_other_one():
    table = Results(
        columns(Setup(Grid(2, [1e-9, 5e-9]))) | {"disorder_parameter": np.arange(2.0)}, {}
    )
    assert table.plot(where={"belt_velocity": 1e-9}).lines[0].get_ydata().tolist() == [0]
    assert table.plot(where={"noise": 0}).lines[0].get_ydata().tolist() == [0, 1]


def test_values_that_are_near_or_infinite_have_their_own_names():
    near, weakening = [17.1, 17.10001, 17.2], [np.inf, 300.0]
    table = Results(
        columns(Setup(Grid(2, near, weakening_velocity=weakening, viscosity=[0.1, 0.2])))
        | {"disorder_parameter": np.arange(12.0)},
        {},
    )
    one = table.plot(where={"weakening_velocity": np.inf}, x="viscosity")
    texts = [text.get_text() for text in one.get_legend().get_texts()]
    assert texts == ["$u$ = 17.1", "$u$ = 17.10001", "$u$ = 17.2"]
    with pytest.raises(InputError, match="where: noise = nan: a finite number is needed"):
        table.plot(where={"noise": np.nan})


def test_without_a_section_there_is_no_diagram(results):
    with pytest.raises(InputError, match="no section_velocity"):
        made_up().plot_section()
    nothing = made_up(section_velocity=np.full_like(results["section_velocity"], np.nan))
    with pytest.raises(InputError, match="no chain crosses"):
        nothing.plot_section(where={"noise": 0})


# --- exponents and branches -----------------------------------------------------------------------


def test_exponents_that_sticks_erase_are_at_the_foot(axes):
    values, errors = np.array([0.02, 0.0, -0.3, -np.inf]), np.array([0.003, 1e-4, 0.01, 0.0])
    none = np.zeros((1, 1))
    spectrum = LyapunovSpectrum(ChainParameters(2, 5.0), values, errors, none, none, 20.0, none[0])
    spectrum.plot(ax=axes)
    (bars,) = axes.containers
    assert np.array_equal(bars.lines[0].get_xydata(), np.transpose([[1, 2, 3], values[:3]]))
    ends = np.array(bars.lines[2][0].get_segments())[:, :, 1]
    np.testing.assert_allclose(ends, np.transpose([values - errors, values + errors])[:3])
    foot = axes.lines[-1]
    assert foot.get_xydata().tolist() == [[4.0, 0.0]]
    assert foot.get_transform() == axes.get_xaxis_transform()
    assert axes.get_ylabel() == r"$\lambda$ (1 / model time)"


def test_a_branch_is_dashed_where_it_does_not_attract(axes):
    orbits = [
        SimpleNamespace(
            parameters=ChainParameters(2, u), disorder_parameter=0.1 * u, mean_length=100.0,
            period_time=9.0, period_events=4, largest_multiplier=0.4 * u,
        )
        for u in (1.0, 2.0, 3.0)
    ]  # fmt: skip
    ends = [SpecialPoint(u, kind, 0, kind) for u, kind in ((1.0, "grazing"), (3.0, "edge"))]
    OrbitBranch("belt_velocity", tuple(orbits), "1- 1|", *ends, ()).plot(ax=axes)
    full, dashed, *marks = axes.lines
    assert (full.get_linestyle(), dashed.get_linestyle()) == ("-", "--")
    np.testing.assert_allclose(full.get_ydata(), [0.1, 0.2, np.nan])
    np.testing.assert_allclose(dashed.get_ydata(), [np.nan, np.nan, 0.3])
    assert [mark.get_xdata()[0] for mark in marks] == [1.0, 3.0]
    assert [text.get_text() for text in axes.texts] == ["grazing", "edge"]


# --- words ----------------------------------------------------------------------------------------


def test_a_short_name_of_a_property_is_known(results):
    assert results.plot(lw=3.0).lines[0].get_linewidth() == 3.0

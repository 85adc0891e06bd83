"""Which numbers the figures of the paper draw: in which panel, at which axes and scale.

The data are those of `figure_data`, where each number tells its dataset, N, u and sigma. What a
panel must show follows here from their formulas, without the functions that cut rows out of files.
"""

import itertools

import numpy as np
import pytest
from matplotlib.contour import QuadContourSet

import drawn
import figure_data as made
import naive
from beltrepro.replication.drawing import style
from beltrepro.replication.studies.avalanches import measure
from beltrepro.replication.studies.noise.figures import _without_crumbs
from beltrepro.replication.studies.sizes.figures import _trend
from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.stats import spectra, states
from beltrepro.stats.densities import density
from figure_data import SCANS, SCATTER, U, dataset


def shown(name, *, also=(), **changed):
    """Panels of a figure, drawn from all that it uses."""
    return drawn.panels_of(made.draw(name, made.data_of(name, also=also, **changed)))


# --- what scans must look like --------------------------------------------------------------------


def row(name, n, s):
    """(u, median r) of a row."""
    return SCANS[name][1], np.array([made.r(name, n, u, s) for u in SCANS[name][1]])


def column(name, n, u):
    return SCANS[name][2], np.array([made.r(name, n, u, s) for s in SCANS[name][2]])


def mean(x, r, above=-1.0):
    """Mean over the replicates, where `r` is their median, at places beyond one."""
    return x[x > above], r[x > above] + SCATTER.mean()


def runs(x, r):
    """One point for each replicate."""
    return np.repeat(x, 3), (r[:, np.newaxis] + SCATTER).ravel()


def together(name, n, s):
    """(place, mean) of r of all runs at neighbouring u, eight together."""
    u, r = mean(*row(name, n, s))
    width = 8 * (U[1] - U[0])
    places = np.unique(np.ceil(u / width) - 0.5) * width
    return places, np.array([r[np.abs(u - place - 1e-9) <= width / 2].mean() for place in places])


def is_density(panel, name, n, s):
    """The share of crossings in each cell at each u, over the height of the cell."""
    (image,) = panel.images
    assert {*image.y_edges} <= {*made.V_BINS}  # neighbours are joined in a low panel
    np.testing.assert_allclose(image.x_edges, np.append(U - 1.5, U[-1] + 1.5))
    for place, u in enumerate(U):
        values = made.crossings(name, n, u, s)[:-2]
        expected, _ = np.histogram(values, image.y_edges, density=True)
        np.testing.assert_allclose(np.nan_to_num(image.values[:, place]), expected)
    assert image.scale == "log"


# --- the model ------------------------------------------------------------------------------------


def test_fig06_is_the_force_of_the_spring():
    (panel,) = shown("fig06")
    x = panel.curve("spring of the model").x
    force = [naive.spring_force(length) for length in x]
    ideal = (x, -x, r"ideal spring, $-\Delta l$")
    panel.draws(
        r"$\Delta l$ (model length)",
        "$F_e$ (model force)",
        ideal,
        (x, force, "spring of the model"),
        ([-20, 20], [20, -20]),
    )
    assert (x.min(), x.max()) == (-36, 100) and panel.spans == [("x", -20, 20)]


def test_fig07_is_the_friction_of_one_event_of_the_last_block():
    (panel,) = shown("fig07")
    arrays = dataset("friction_event").arrays
    time, friction = arrays["time"], arrays["friction"][:, 4]
    gap = arrays["positions"][:, 4] - arrays["positions"][:, 3]
    external = np.array([naive.spring_force(dx - 55, 18, 0.21, 0.012) for dx in gap])
    stuck, slips = (time > 5) & (time < 9), (time > 9) & (time < 14)
    panel.draws(
        "$F_{ex}$ (model force)",
        "$F_f$ (model force)",
        (external[stuck], friction[stuck], "stuck: $F_f = -F_{ex}$"),
        (external[slips], friction[slips], "slipping: $F_f = f_s F_{st}$"),
    )
    assert panel.guides == [("y", 0), ("x", 0), ("y", 80), ("y", 0.4 * 80)]
    assert rf"{friction[slips].std():.2f} ($f_s \sigma$ = 0.40)" in panel.title


# --- series ---------------------------------------------------------------------------------------


def is_spectrum(panel, data, prefactor, exponent):
    """The amplitude of x_N after the transient, with a fitted and a printed law."""
    time = data.arrays["time"]
    interval = time[1] - time[0]
    position = data.arrays["positions"][time >= data.attributes["transient"], -1]
    frequency, power = spectra.power_spectrum(position, interval)
    shown = frequency, np.sqrt(2 * power / 1e6)
    panel.draws(r"$\nu$", r"amplitude $A(\nu)$", shown, scales="log log", more=4)
    means = next(curve for curve in panel.curves if not curve.line)
    tenth = power[np.abs(np.log10(frequency / means.x[9])) < 0.05].mean()
    assert means.y[9] == pytest.approx(np.sqrt(2 * tenth / 1e6), rel=0.01)
    median = panel.curve("median")
    near = np.abs(np.log10(frequency / median.x[-5])) < 0.025
    assert median.y[-5] == pytest.approx(np.median(shown[1][near]), rel=0.05)
    # of the mean of the spectra of stretches of ten cycles of the lowest frequency
    count = int(position.size * interval * 0.003 / 10)
    stretches = np.split(position[: position.size // count * count], count)
    powers = [spectra.power_spectrum(part, interval) for part in stretches]
    law = spectra.fit_power_law(*np.mean(powers, axis=0), low=0.003, high=0.3)
    assert 6 <= count <= 20
    ends = np.array([0.003, 0.3])
    fitted, paper = panel.curve("fit: "), panel.curve(f"paper: ${prefactor}")
    assert f"{law.exponent / 2:.2f}" in fitted.label
    np.testing.assert_allclose(fitted.y, np.sqrt(2 * law(ends) / 1e6))
    np.testing.assert_allclose(paper.y, prefactor * ends**exponent)
    assert paper.line == "--"


def is_zoom(panel, inner, x, y, begin, end):
    assert panel.spans == [("x", pytest.approx(begin), pytest.approx(end))]
    inside = (x >= begin) & (x <= end)
    inner.draws(inner.xlabel, inner.ylabel, (x[inside], y[inside]))


def test_fig08_is_the_last_part_of_the_series_and_the_spectrum_of_all():
    upper, lower, spectrum, enlarged = shown("fig08")
    arrays = dataset("u1").arrays
    last = arrays["time"] >= arrays["time"][-1] - 3000
    time, relative = arrays["time"][last], arrays["velocities"][last, 4] - 1.0
    time = time - time[0]
    upper.is_trace("", "$x_N$", time, arrays["positions"][last, 4])
    lower.is_trace("$t$", "$v_{rN}$", time, relative)
    is_spectrum(spectrum, dataset("u1"), 0.0016, -1.21)  # caption of Fig. 8
    middle = time[np.argmin(relative)]
    is_zoom(lower, enlarged, time, relative, middle - 15, middle + 15)


# --- the catalogue --------------------------------------------------------------------------------


def test_fig09_is_sizes_of_the_last_block_and_energies_of_avalanches_with_it():
    *panels, sizes, energies = shown("fig09")
    arrays = dataset("slips_u1").arrays
    last = arrays["slips"]["block"] == 5  # each avalanche is one slip here
    slips, reaching = arrays["slips"][last], arrays["avalanches"]["dissipated"][last]
    lengths = slips["start_position"] - slips["stop_position"]
    for panel, below, quantity, values, what, printed in (
        (panels[0], sizes, r"\Delta x_s", lengths, "slips", -1.47),
        (panels[1], energies, r"\Delta E", reaching, "avalanches", -0.87),
    ):
        panel.draws("", f"$P({quantity})$", scales="log log", more=4)
        assert f"600 {what}" in panel.title
        fine, coarse = panel.curves[:2]
        for curve, bins in ((fine, 40), (coarse, 5)):
            half, filled = 10 ** (0.5 / bins), np.isfinite(curve.y)
            count = [np.sum((values >= x / half) & (values < x * half)) for x in curve.x]
            expected = count / (values.size * curve.x * (half - 1 / half))
            np.testing.assert_allclose(curve.y[filled], expected[filled])
            assert np.sum(count) == values.size
        sizes_of_runs = np.bincount(slips["point"])  # two, each in eight stretches
        place = np.empty(values.size, dtype=int)
        place[np.argsort(slips["point"], kind="stable")] = np.concatenate(
            [8 * run + np.arange(size) * 8 // size for run, size in enumerate(sizes_of_runs)]
        )
        without = [_density(values[place != one], coarse.x) for one in range(16)]
        error = np.sqrt(15 * np.var(without, axis=0))
        np.testing.assert_allclose(coarse.points.T[2:], drawn.ends(coarse.y, error), atol=1e-12)
        law = panel.curve("here: ")
        exponent = np.diff(np.log(law.y)) / np.diff(np.log(law.x))
        assert f"${exponent[0]:.2f}$" in law.label
        # dashed, of the printed slope, through the middle of the law
        paper = panel.curve(f"paper: {printed:g}".replace("-", "\N{MINUS SIGN}"))
        np.testing.assert_allclose(paper.x, law.x)
        assert np.diff(np.log(paper.y)) / np.diff(np.log(paper.x)) == pytest.approx(printed)
        assert np.prod(paper.y) == pytest.approx(np.prod(law.y)) and paper.line == "--"
        assert (below.xlabel, below.ylabel) == (f"${quantity}$", "local exponent")
        assert below.guides == [("y", printed)]


def _density(values, centre):
    half = 10**0.1
    count = [np.sum((values >= x / half) & (values < x * half)) for x in centre]
    return count / (values.size * centre * (half - 1 / half))


def test_the_local_exponent_of_a_power_law_is_its_exponent():
    values = (1 - np.arange(0.5, 1e5) / 1e5) ** (-1 / 1.5)  # P = 1.5 x^-2.5 from 1 on
    place, slope = measure.local_exponents(density(values, 40), 9, 5)
    known = np.isfinite(slope)
    assert known[0] and not known[-1]
    np.testing.assert_allclose(slope[known & (place < 20)], -2.5, atol=0.1)


def test_fig10_is_the_density_of_the_points_at_which_the_last_block_slips_by_both_integrators():
    scheme, exact, part = shown("fig10")
    for panel, name, words in (
        (scheme, "section_u1", "paper's scheme"),
        (exact, "section_u1_event", "exact motion"),
        (part, "section_u1", ""),
    ):
        points = dataset(name).arrays["crossings"]
        points = points[points["velocity"] < 1.5 - 1e-6]
        total = points.size
        if panel is part:
            points = points[(points["position"] > 560) & (points["position"] < 600)]
        else:
            assert f"{words},\n{points.size} points" in panel.title
        (image,) = panel.images
        expected, *_ = np.histogram2d(
            points["velocity"] - 1.5, points["position"], (image.y_edges, image.x_edges)
        )
        area = np.outer(np.diff(image.y_edges), np.diff(image.x_edges))
        shares = np.nan_to_num(image.values) * area
        np.testing.assert_allclose(shares, expected / total, atol=1e-9)
        assert expected.sum() == points.size and panel.xlabel == "$x_N$ at $x_{3} = 271.5$"


def test_fig11_is_a_run_that_slips_on_the_run_from_rest_and_when_runs_end():
    above, relative, rest, enlarged, ends = shown("fig11")
    last = 2.0 * 1500  # sample 1500 of two time units is the last stick
    for panel in (above, relative):
        assert panel.guides == [("x", last), ("x", 4000.0)]
    assert f"last stick at $t$ = {last:.0f}" in above.title
    assert "start at rest" in rest.title and enlarged.xlabel == "$t$"
    lasts = 120.0 + 10 * np.arange(1, 16, 3)  # of five of six runs
    (curve,) = ends.curves
    assert list(curve.x) == [0, *lasts, 2000] and "5 of 6 starts" in ends.title
    np.testing.assert_allclose(curve.y, [0, *np.arange(1, 6) / 6, 5 / 6])


# --- scans ----------------------------------------------------------------------------------------


def test_fig12_is_the_density_and_r_without_noise_with_exact_runs_and_other_starts_over_it():
    top, disorder, _ = shown("fig12")
    is_density(top, "n5_density", 5, 0.0)
    assert (top.ylabel, disorder.ylabel) == ("$v_N$", "$r$")
    single = (*runs(*row("n5_density", 5, 0.0)), "as in the paper")
    starts = (*runs(*row("n5_replicates_check", 5, 0.0)), "other starts")
    exact = (*runs(*row("n5_rows_check", 5, 0.0)), "exact motion")
    disorder.draws("", "$r$", single, exact, starts, more=0)
    assert disorder.spans[-1] == ("x", 15, 18)  # Sec. IV.A
    data = made.data_of("fig12")
    del data["n5_replicates_check"], data["n5_rows_check"]
    drawn.panels_of(made.draw("fig12", data))[1].draws("", "$r$", single)


def test_fig13_is_the_mean_of_runs_at_neighbouring_velocities():
    panel, falls = shown("fig13")
    curves = [(*together("n5_density", 5, s), rf"$\sigma = {s:g}$") for s in made.LEVELS]
    panel.draws("$u$", "$r$", *curves)
    for place, low, high in map(drawn.corners, panel.axes.collections):
        assert np.all((high - low > 1e-6) == (place < 40))
    assert bars(falls) == [(17, 19), (18, 19.2)]
    diamonds = [line for line in falls.axes.lines if line.get_marker() == "D"]
    assert [line.get_xdata() for line in diamonds] == [[16.5], [19]]
    assert falls.texts == ["16.5", "19"]


def bars(panel):
    """Ends of the bars that can be seen."""
    seen = [one for one in panel.axes.patches if one.get_width()]
    ends = [(one.get_x(), one.get_x() + one.get_width()) for one in seen]
    return [pytest.approx(pair) for pair in ends if np.isfinite(pair).all()]


def test_fig14_is_a_strip_for_each_noise_and_the_column_at_u_7():
    *strips, below = shown("fig14")
    for panel, s in zip(strips, made.LEVELS, strict=True):
        is_density(panel, "n5_density", 5, s)
        assert rf"$\sigma = {s:g}$" in panel.texts
    points = column("n5_u7", 5, 7.0)
    assert below.xlabel == r"$\sigma$"
    assert any(drawn._same(curve, *runs(*points)) for curve in below.curves)


@pytest.mark.parametrize(
    ("figure", "name", "places"),
    [
        ("fig15", "n5_columns", itertools.product([5], [20.0, 30.0, 40.0])),
        ("fig21", "size_columns", itertools.product([5, 7, 10], [18.0, 32.0])),
    ],
)
def test_fig15_and_fig21_are_means_over_bands_of_runs(figure, name, places):
    (panel,) = shown(figure)
    columns = [column(name, *place) for place in places]
    panel.draws(r"$\sigma$", "$r$", *(mean(*one, above=0) for one in columns))
    rings = [one.get_offsets() for one in panel.axes.collections if len(one.get_offsets()) == 3]
    quiet = [[(x, y) for x, y in zip(*runs(*one), strict=True) if x == 0] for one in columns]
    np.testing.assert_allclose(rings, quiet)
    assert ("$N = 5$: $u$ within its fall" in panel.texts) == (figure == "fig21")


def test_fig19_is_means_of_runs_at_sigma_1_over_the_printed_regions():
    panel, falls = shown("fig19")
    curves = [
        (*mean(*row(name, n, 1.0)), f"$N = {n}$")
        for name in ("n5_replicates", "size_replicates")
        for n in SCANS[name][0]
    ]
    panel.draws("", "$r$", *curves)
    ends = Cut.of(dataset("n5_replicates"), n_blocks=5, noise=1.0).fall
    reach = ends["lower"].low, ends["upper"].high
    assert bars(falls) == [reach, (18, 19.2), (15, 18), (23, 32), (27, 40)]
    for last, words in (((2.0, 5.0), "undecided"), ((3.1, 5.0), "grows"), ((0.5, 0.9), "shrinks")):
        assert _trend([(1.0, 3.0), last]) == words


def test_fig17_is_the_density_of_the_crossings_at_four_noises():
    grid = shown("fig17")
    for panel, s in zip(grid, (0.0, 1.0, 5.0, 10.0), strict=True):
        assert rf"$\sigma = {s:g}$" in panel.title
        is_density(panel, "n5_density", 5, s)
        # at the foot of each u: whether the last block slips on, or both motions take turns
        share = made.laminar(U, s)
        for colour, chosen in ((style.BLUE, share > 0.95), (style.ORANGE, share == 0.5)):
            marks = [line for line in panel.axes.lines if line.get_color() == colour]
            assert [list(line.get_xdata()) for line in marks] == [list(U[chosen])] * bool(
                chosen.any()
            )
    densities = [panel.images[0].values for panel in grid]
    highest, least = np.nanmax(densities), np.nanmin(densities)
    limits = pytest.approx((max(least, highest / 1000), highest))
    assert all(panel.images[0].limits == limits for panel in grid)


def test_fig22_is_a_density_for_each_number_of_blocks_and_noise():
    panels = iter(shown("fig22"))
    for n in made.SIZES:
        for s in (0.0, 1.0, 5.0):
            panel = next(panels)
            is_density(panel, "size_density", n, s)
            assert panel.ylabel == (f"$N = {n}$\n$v_N$" if s == 0 else "")
            irregular = dataset("motions").query(f"n_blocks == {n}")["chaotic"] / 3
            heights = np.array([patch.get_height() for patch in panel.axes.patches])
            assert list(heights / 0.09) == pytest.approx([1, 1, 1, *irregular] if s == 0 else [])


def test_fig18_is_the_map_of_r_with_the_range_of_intermittency_and_the_shares():
    above, below = shown("fig18")
    (image,) = above.images
    noises = SCANS["n5_map"][2]
    np.testing.assert_allclose(image.x_edges, np.append(U - 1.5, U[-1] + 1.5))
    np.testing.assert_allclose(image.y_edges, np.append(noises - 1.25, noises[-1] + 1.25))
    expected = np.array([[made.r("n5_map", 5, u, s) for u in U] for s in noises])
    np.testing.assert_allclose(image.values, expected + SCATTER.mean())
    assert (image.scale, image.label, image.limits[0]) == ("linear", "$r$", 0)
    contours = [one for one in above.axes.collections if isinstance(one, QuadContourSet)]
    assert [one.levels[0] for one in contours] == [pytest.approx(1 / 3)] * 2
    assert [one.filled for one in contours] == [True, False]
    mixed = np.zeros((9, 20))
    mixed[:, 12:] = mixed[[2, 2, 4, 4], [4, 6, 4, 6]] = 1  # the point among four has four of nine
    assert np.argwhere(_without_crumbs(mixed) > 1 / 3)[:, 1].min() == 12
    low, high = states.LAMINAR_SHARE
    u = SCANS["n5_replicates"][1]
    shares = [(u, made.laminar(u, s), rf"$\sigma = {s:g}$") for s in (0.0, 1.0, 2.2, 5.0)]
    all_runs = [np.repeat((u, made.laminar(u, s)), 3, axis=1) for s in (0.0, 1.0, 2.2, 5.0)]
    below.draws("$u$", "laminar share", *shares, *all_runs)
    assert below.guides == [("y", low), ("y", high)]

"""Which numbers the figures of the paper draw: in which panel, at which axes and scale.

The data are those of `figure_data`, where each number tells its dataset, N, u and sigma. What a
panel must show follows here from their formulas, without the functions that cut rows out of files.
"""

import itertools

import numpy as np
import pytest

import drawn
import figure_data as made
import naive
from beltrepro.replication.drawing import style
from beltrepro.stats import spectra, states
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


def mean(x, r):
    """Mean over the replicates, where `r` is their median."""
    return x, r + SCATTER.mean()


def runs(x, r):
    """One point for each replicate."""
    return np.repeat(x, 3), (r[:, np.newaxis] + SCATTER).ravel()


def is_diagram(panel, name, s, lowest, bins):
    """The density of the crossings of five blocks at each u."""
    (image,) = panel.images
    np.testing.assert_allclose(image.y_edges, np.linspace(lowest, 0, bins + 1))
    np.testing.assert_allclose(image.x_edges, np.append(U - 1.5, U[-1] + 1.5))
    for place, u in enumerate(U):
        values = made.crossings(name, 5, u, s)[:-2]
        expected, _ = np.histogram(values, image.y_edges, density=True)
        np.testing.assert_allclose(np.nan_to_num(image.values[:, place]), expected)
    return image


# --- the model ------------------------------------------------------------------------------------


def test_fig06_is_the_force_of_the_spring():
    (panel,) = shown("fig06")
    x = panel.curve("spring of the model").x
    force = [naive.spring_force(length) for length in x]
    ideal = (x, -x, r"ideal spring, $-\Delta l$")
    panel.draws(
        r"$\Delta l$", "$F_e$", ideal, (x, force, "spring of the model"), ([-20, 20], [20, -20])
    )
    assert (x.min(), x.max()) == (-36, 100) and panel.spans == [("x", -20, 20)]


def test_fig07_is_the_friction_of_one_event_of_the_last_block():
    panel, enlarged = shown("fig07")
    arrays = dataset("friction_event").arrays
    time, friction = arrays["time"], arrays["friction"][:, 4]
    gap = arrays["positions"][:, 4] - arrays["positions"][:, 3]
    external = np.array([naive.spring_force(dx - 55, 18, 0.21, 0.012) for dx in gap])
    stuck, slips = (time > 5) & (time < 9), (time > 9) & (time < 14)
    panel.draws(
        "$F_{ex}$",
        "$F_f$",
        (external[stuck], friction[stuck], "stuck: $F_f = -F_{ex}$"),
        (external[slips], friction[slips], "slipping: $F_f = f_s F_{st}$"),
    )
    assert panel.guides == [("y", 0), ("x", 0), ("y", 80), ("y", 0.4 * 80)]
    enlarged.draws("$F_{ex}$", "$F_f$", (external[slips], friction[slips]))
    assert enlarged.guides == [("y", 0.4 * 80)]


# --- series ---------------------------------------------------------------------------------------


def is_spectrum(panel, data, prefactor, exponent):
    """The amplitude of x_N after the transient, with a fitted and a printed law."""
    time = data.arrays["time"]
    interval = time[1] - time[0]
    position = data.arrays["positions"][time >= data.attributes["transient"], -1]
    frequency, power = spectra.power_spectrum(position, interval)
    shown = frequency, np.sqrt(2 * power / 1e6)
    panel.draws(r"$\nu$", r"amplitude $A(\nu)$", shown, scales="log log", more=2)
    # of the mean of the spectra of stretches of ten cycles of the lowest frequency
    count = int(position.size * interval * 0.003 / 10)
    stretches = np.split(position[: position.size // count * count], count)
    powers = [spectra.power_spectrum(part, interval) for part in stretches]
    law = spectra.fit_power_law(*np.mean(powers, axis=0), low=0.003, high=0.3)
    assert 4 <= count <= 20
    ends = np.array([0.003, 0.3])
    fitted, paper = panel.curve("fit: "), panel.curve(f"paper: ${prefactor}")
    assert f"{law.exponent / 2:.2f}" in fitted.label
    np.testing.assert_allclose(fitted.y, np.sqrt(2 * law(ends) / 1e6))
    np.testing.assert_allclose(paper.y, prefactor * ends**exponent)
    assert paper.line == "--"


def is_envelope(panel, x, y):
    """The least and greatest of more samples than the panel has pixels."""
    (shade,) = panel.axes.collections
    place, low, high = drawn.corners(shade)
    nearest = np.abs(place[:, np.newaxis] - x).argmin(axis=0)
    assert place.size < x.size and np.isin([*low, *high], y).all()
    assert np.all((low[nearest] <= y) & (y <= high[nearest]))


def is_zoom(panel, inner, x, y, begin, end):
    assert panel.spans == [("x", pytest.approx(begin), pytest.approx(end))]
    inside = (x >= begin) & (x <= end)
    inner.draws(inner.xlabel, inner.ylabel, (x[inside], y[inside]))


def test_fig08_is_the_last_part_of_the_series_and_the_spectrum_of_all():
    upper, lower, spectrum, enlarged = shown("fig08")
    arrays = dataset("u1").arrays
    last = arrays["time"] >= arrays["time"][-1] - 3000
    time, relative = arrays["time"][last], arrays["velocities"][last, 4] - 1.0
    is_envelope(upper, time, arrays["positions"][last, 4])
    is_envelope(lower, time, relative)
    assert (upper.ylabel, lower.xlabel, lower.ylabel) == ("$x_N$", "$t$", "$v_{rN}$")
    is_spectrum(spectrum, dataset("u1"), 0.0016, -1.21)  # caption of Fig. 8
    middle = time[np.argmin(relative)]
    is_zoom(lower, enlarged, time, relative, middle - 15, middle + 15)


# --- the catalogue --------------------------------------------------------------------------------


def is_density(panel, values, label, *, bins, run=None):
    """Of values in so many bins a decade; with error bars if two runs are told apart."""
    curve = panel.curve(label)
    half = 10 ** (0.5 / bins)

    def density(sample):
        count = [np.sum((sample >= x / half) & (sample < x * half)) for x in curve.x]
        return count / (sample.size * curve.x * (half - 1 / half))

    np.testing.assert_allclose(curve.y, density(values))
    assert np.sum(curve.y * curve.x) * (half - 1 / half) == pytest.approx(1)
    assert curve.points.shape[1] == (2 if run is None else 4)
    if run is not None:
        error = np.abs(density(values[run == 0]) - density(values[run == 1])) / 2
        np.testing.assert_allclose(curve.points.T[2:], drawn.ends(curve.y, error), atol=1e-12)


def test_fig09_is_sizes_of_the_last_block_and_energies_of_avalanches_with_it():
    left, right = shown("fig09")
    arrays = dataset("slips_u1").arrays
    last = arrays["slips"]["block"] == 5  # each avalanche is one slip here
    slips, reaching = arrays["slips"][last], arrays["avalanches"]["dissipated"][last]
    laboratory = slips["start_position"] - slips["stop_position"]
    belt = laboratory + 1.5 * (slips["stop_time"] - slips["start_time"])
    for panel, quantity, values, label, others, other_label, printed in (
        (left, r"\Delta x_s", laboratory, "laboratory frame, 600 slips", belt,
         "frame of the belt", -1.47),
        (right, r"\Delta E", reaching, "whole chain, 600 avalanches", slips["dissipated"],
         "last block only", -0.87),
    ):  # fmt: skip
        panel.draws(f"${quantity}$", f"$P({quantity})$", scales="log log", more=4)
        is_density(panel, values, label, bins=5, run=slips["point"])
        is_density(panel, others, other_label, bins=5)
        law = panel.curve(r"$\alpha")
        exponent = np.diff(np.log(law.y)) / np.diff(np.log(law.x))
        assert f"= {exponent[0]:.2f}$" in law.label
        # dashed, of the printed slope, through the middle of the law
        paper = panel.curve(f"paper: {printed:g}".replace("-", "\N{MINUS SIGN}"))
        np.testing.assert_allclose(paper.x, law.x)
        assert np.diff(np.log(paper.y)) / np.diff(np.log(paper.x)) == pytest.approx(printed)
        assert np.prod(paper.y) == pytest.approx(np.prod(law.y)) and paper.line == "--"


def section(name):
    points = dataset(name).arrays["section"]
    return points["positions"][:, 4], points["velocities"][:, 4] - 1.5


def test_fig10_is_the_points_at_which_the_last_block_slips_by_both_integrators():
    first, second = shown("fig10")
    for panel, name, repeats in ((first, "slips_u1", 0), (second, "slips_u1_event", 40)):
        position, relative = section(name)
        slips, new = relative < 0, np.arange(900) < 900 - repeats
        curves = [(position[slips & part], relative[slips & part]) for part in (~new, new)]
        panel.draws("$x_N$ at $x_{3} = 271.5$", panel.ylabel, *curves[not repeats :])
        assert f"{(slips & new).sum()} of {slips.sum()} points are new" in panel.title


# --- scans ----------------------------------------------------------------------------------------


def test_fig12_is_the_row_without_noise_with_the_other_method_over_it():
    top, disorder, _ = shown("fig12")
    lowest = np.floor(min(made.crossings("n5_rows", 5, U[-1], 0.0)[:-2]))
    image = is_diagram(top, "n5_rows", 0.0, lowest, 150)
    assert (top.ylabel, image.scale) == ("$v_N$", "log")
    assert image.label == "density (1 / model velocity)"
    single = row("n5_rows", 5, 0.0)
    starts = (*runs(*row("n5_replicates_check", 5, 0.0)), "other starts")
    disorder.draws("", "$r$", single, row("n5_rows_check", 5, 0.0), starts, more=0)
    assert disorder.spans[-1] == ("x", 15, 18)  # Sec. IV.A
    data = made.data_of("fig12")
    del data["n5_replicates_check"], data["n5_rows_check"]
    drawn.panels_of(made.draw("fig12", data))[1].draws("", "$r$", single)


@pytest.mark.parametrize(
    ("figure", "name", "places", "across"),
    [
        ("fig15", "n5_columns", itertools.product([5], [20.0, 30.0, 40.0]), 3),
        ("fig21", "size_columns", itertools.product([5, 7, 10], [18.0, 32.0]), 2),
    ],
)
def test_fig15_and_fig21_are_a_run_each_and_a_panel_of_runs_for_each_point(
    figure, name, places, across
):
    """Runs and their means against noise; crosses where there are runs by the other method."""
    sizes, velocities, _ = SCANS[f"{name}_check"]
    places = list(places)
    above, *grid = shown(figure, also=[f"{name}_check"])
    columns = [column(name, *place) for place in places]
    above.draws(r"$\sigma$", "$r$", *((noise, r + SCATTER[0]) for noise, r in columns))
    for index, (panel, (n, u)) in enumerate(zip(grid, places, strict=True)):
        points, over = column(name, n, u), []
        if n in sizes and u in velocities:
            over = [(*runs(*column(f"{name}_check", n, u)), "exact motion")]
        xlabel = r"$\sigma$" if index >= len(grid) - across else panel.xlabel
        ylabel = "" if index % across else "$r$"
        panel.draws(xlabel, ylabel, runs(*points), mean(*points), *over)
        assert f"$u = {u:g}$" in panel.title


def test_fig17_is_the_density_of_the_crossings_at_four_noises():
    grid = shown("fig17")
    lowest = np.floor(min(made.crossings("n5_rows", 5, U[-1], 10.0)[:-2]))
    for panel, s in zip(grid, (0.0, 1.0, 5.0, 10.0), strict=True):
        assert rf"$\sigma = {s:g}$" in panel.title
        is_diagram(panel, "n5_rows", s, lowest, 120)
        # at the foot of each u: whether the last block slips on, or both motions take turns
        share = made.laminar(U, s)
        for colour, chosen in ((style.BLUE, share > 0.95), (style.ORANGE, share == 0.5)):
            marks = [curve for curve in panel.curves if curve.colour == colour]
            assert [list(curve.x) for curve in marks] == [list(U[chosen])] * bool(chosen.any())
            assert all(np.all(curve.y < lowest) for curve in marks)
    densities = [panel.images[0].values for panel in grid]
    highest, least = np.nanmax(densities), np.nanmin(densities)
    limits = pytest.approx((max(least, highest / 1000), highest))
    assert all((panel.images[0].limits, panel.images[0].scale) == (limits, "log") for panel in grid)


def test_fig18_is_the_map_of_r_with_a_dot_at_each_intermittent_point_and_the_shares():
    above, below = shown("fig18")
    (image,) = above.images
    noises = SCANS["n5_map"][2]
    np.testing.assert_allclose(image.x_edges, np.append(U - 1.5, U[-1] + 1.5))
    np.testing.assert_allclose(image.y_edges, np.append(noises - 1.25, noises[-1] + 1.25))
    expected = np.array([[made.r("n5_map", 5, u, s) for u in U] for s in noises])
    np.testing.assert_allclose(image.values, expected)
    assert (image.scale, image.label, image.limits[0]) == ("linear", "$r$", 0)
    assert expected.max() <= image.limits[1] < expected.max() + 0.02
    inside = [(u, s) for s in noises for u in U if made.laminar(u, s) == 0.5]
    above.draws("$u$", r"$\sigma$", np.repeat(inside, 3, axis=0).T)
    low, high = states.LAMINAR_SHARE
    u = SCANS["n5_replicates"][1]
    shares = [(u, made.laminar(u, s), rf"$\sigma = {s:g}$") for s in (0.0, 1.0, 2.2, 5.0)]
    below.draws("$u$", "laminar share", *shares)
    assert below.guides == [("y", low), ("y", high)]

"""Which numbers the figures of the paper draw: in which panel, at which axes and scale.

The data are those of `figure_data`, where each number tells its dataset, N, u and sigma. What a
panel must show follows here from their formulas, without the functions that cut rows out of files.
"""

import itertools

import numpy as np
import pytest
from matplotlib.patches import FancyArrowPatch
from scipy import stats

import drawn
import figure_data as made
import irregular
import naive
import recorded
from beltrepro.base.store import Dataset
from beltrepro.model.units import LENGTH_M
from beltrepro.replication.camera import recording
from beltrepro.replication.drawing import motion_panels, style
from beltrepro.replication.studies.laws import figures as laws
from beltrepro.stats import intermittency, spectra
from figure_data import SCANS, SCATTER, U, dataset


def shown(name, *, also=(), **changed):
    """Panels of a figure, drawn from all that it uses."""
    return drawn.panels_of(made.draw(name, made.data_of(name, also=also, **changed)))


def changed(data, **arrays):
    return Dataset(data.arrays | arrays, data.attributes)


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


def crossings(name, n, s):
    """A dot for each crossing of a row, in all three replicates."""
    points = [(u, v) for u in SCANS[name][1] for v in made.crossings(name, n, u, s)[:-2]]
    return np.repeat(points, 3, axis=0).T


# --- the model ------------------------------------------------------------------------------------


def test_fig01_draws_five_blocks_joined_by_springs():
    (panel,) = shown("fig01")
    assert sorted(panel.texts) == sorted(["$k$", *["$m$"] * 5, "$u$", "$x_N$"])
    springs = [curve.x for curve in panel.curves if curve.colour == style.BLUE]
    assert len(springs) == 5 and springs[0][0] == 0
    assert all(left[-1] < right[0] for left, right in itertools.pairwise(springs))


def test_fig06_is_the_force_of_the_spring():
    (panel,) = shown("fig06")
    x = panel.curve("spring of the model").x
    force = [naive.spring_force(length) for length in x]
    ideal = (x, -x, r"ideal spring, $-\Delta l$")
    panel.draws(
        r"$\Delta l$", "$F_e$", ideal, (x, force, "spring of the model"), ([-20, 20], [20, -20])
    )
    assert (x.min(), x.max()) == (-36, 100) and panel.spans == [("x", -20, 20)]
    assert set(panel.texts) == {"linear", "$b_1 = 0.2$", "$b_2 = 0.01$"}


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
    assert "block 5 of 5, slip at $t$ = 9.00" in panel.title
    assert panel.guides == [("y", 0), ("x", 0), ("y", 80), ("y", 0.4 * 80)]
    begin, end = external[slips][[0, -1]]
    jumps = [(begin, friction[stuck][-1]), (begin, friction[slips].mean())]
    jumps += [(end, friction[slips].mean()), (end, -end)]
    arrows = [patch for patch in panel.axes.patches if isinstance(patch, FancyArrowPatch)]
    np.testing.assert_allclose(np.reshape([arrow._posA_posB for arrow in arrows], (4, 2)), jumps)
    enlarged.draws("$F_{ex}$", "$F_f$", (external[slips], friction[slips]))
    assert enlarged.guides == [("y", 0.4 * 80)]
    assert enlarged.spans == [("y", pytest.approx(31.6), pytest.approx(32.4))]  # noise 1 on F_st
    assert rf"measured {friction[slips].std():.2f}, $f_s \sigma$ = 0.40" in enlarged.title


def test_fig07_takes_another_block_where_the_last_does_not_slip():
    data = dataset("friction_event")
    events = data.arrays["events"].copy()
    events["block"][events["block"] == 5] = 3
    assert "block 4 of 5" in shown("fig07", friction_event=changed(data, events=events))[0].title
    panels = shown("fig07", friction_event=changed(data, events=events[:0]))
    assert all("no complete" in " ".join(panel.texts) for panel in panels)


@pytest.mark.parametrize(("samples", "enough"), [(8, False), (10, True), (12, True)])
@pytest.mark.parametrize("first", [0, 30])
def test_fig07_takes_a_stretch_with_ten_samples(samples, enough, first):
    time = 0.5 * np.arange(60)
    end = time[first] + 0.5 * samples
    assert laws._sampled(time, time[first], end) == enough


# --- series ---------------------------------------------------------------------------------------


def is_spectrum(panel, data, *, printed=None):
    """Of x_N after the transient: the power, or the amplitude with a fitted and a printed law."""
    time = data.arrays["time"]
    after = time >= data.attributes["transient"]
    position = data.arrays["positions"][after, -1]
    frequency, power = spectra.power_spectrum(position, time[1] - time[0])
    lines = 0 if printed is None else 2
    shown = power if printed is None else np.sqrt(2 * power / 1e6)
    quantity = r"power $S(\nu)$" if printed is None else r"amplitude $A(\nu)$"
    panel.draws(r"$\nu$", quantity, (frequency, shown), scales="log log", more=lines)
    if printed is not None:
        # of the mean of the spectra of stretches of ten cycles of the lowest frequency
        count = int(position.size * (time[1] - time[0]) * 0.003 / 10)
        stretches = np.split(position[: position.size // count * count], count)
        powers = [spectra.power_spectrum(part, time[1] - time[0]) for part in stretches]
        law = spectra.fit_power_law(*np.mean(powers, axis=0), low=0.003, high=0.3)
        assert 4 <= count <= 20
        ends = np.array([0.003, 0.3])
        fitted, paper = panel.curve("fit: "), panel.curve("paper: $0.0016")
        assert f"{law.exponent / 2:.2f}" in fitted.label
        np.testing.assert_allclose(fitted.y, np.sqrt(2 * law(ends) / 1e6))
        np.testing.assert_allclose(paper.y, printed[0] * ends ** printed[1])
        assert paper.line == "--"


def is_slope(panel, printed, ends, law):
    """A dashed line of the printed slope through the middle of a law."""
    paper = panel.curve(f"paper: {printed:g}".replace("-", "\N{MINUS SIGN}"))
    np.testing.assert_allclose(paper.x, ends)
    assert np.diff(np.log(paper.y)) / np.diff(np.log(paper.x)) == pytest.approx(printed)
    assert np.prod(paper.y) == pytest.approx(np.prod(law(ends))) and paper.line == "--"


def is_zoom(panel, inner, x, y, begin, end):
    assert panel.spans == [("x", pytest.approx(begin), pytest.approx(end))]
    inside = (x >= begin) & (x <= end)
    inner.draws(inner.xlabel, inner.ylabel, (x[inside], y[inside]))


def test_fig08_is_the_last_part_of_the_series_and_the_spectrum_of_all():
    upper, lower, spectrum, enlarged = shown("fig08")
    arrays = dataset("u1").arrays
    last = arrays["time"] >= arrays["time"][-1] - 3000
    time, relative = arrays["time"][last], arrays["velocities"][last, 4] - 1.0
    upper.draws("", "$x_N$", (time, arrays["positions"][last, 4]))
    lower.draws("$t$", "$v_{rN}$", (time, relative))
    is_spectrum(spectrum, dataset("u1"), printed=(0.0016, -1.21))  # caption of Fig. 8
    middle = time[np.argmin(relative)]
    is_zoom(lower, enlarged, time, relative, middle - 15, middle + 15)


@pytest.mark.parametrize("sticks", [False, True])
def test_fig11_marks_the_end_of_the_transient_and_enlarges_three_periods(sticks):
    data = made.series(5, 20.0, 0.0, length=25_000, interval=0.2, transient=0.0)
    time = data.arrays["time"]
    phase = 2 * np.pi * (time[:, np.newaxis] + 3 * np.arange(5)) / 50
    regular = time[:, np.newaxis] >= 2000
    positions = np.where(regular, 600 + 40 * np.sin(phase), data.arrays["positions"])
    velocities = np.where(regular, 10 * np.cos(phase), data.arrays["velocities"])
    if sticks:
        velocities[(time >= 2000) & (np.arange(time.size) % 50 == 0), 4] = 20
    data = changed(data, positions=positions, velocities=velocities)
    upper, lower, end_above, end_below = shown("fig11", u20=data)
    (_, printed), (axis, since) = upper.guides
    assert printed == 4000  # Sec. IV.A
    assert lower.guides == upper.guides and axis == "x"
    assert 2000 <= since <= 2050  # the first crossing of the settled motion
    assert f"periodic from $t$ = {since:.0f} on, period 50.0" in upper.title
    assert ("goes on sticking" if sticks else "only slips, as in the paper") in lower.title
    early = time <= 1.6 * since + 150
    time = time[early]
    for panel, inner, values, xlabel, ylabel in (
        (upper, end_above, positions[early, 4], "", "$x_N$"),
        (lower, end_below, velocities[early, 4] - 20, "$t$", "$v_{rN}$"),
    ):
        panel.draws(xlabel, ylabel, (time, values))
        is_zoom(panel, inner, time, values, time[-1] - 150, time[-1])


def test_fig11_where_the_motion_does_not_repeat_itself():
    assert shown("fig11")[0].guides == [("x", 4000)]
    velocities = dataset("u20").arrays["velocities"].copy()
    velocities[1001:] -= 1.0  # the last stick is at sample 1000, t = 2000
    upper, *_ = shown("fig11", u20=changed(dataset("u20"), velocities=velocities))
    assert upper.guides == [("x", 4000), ("x", 2000.0)] and upper.curves[0].x[-1] == pytest.approx(
        3260
    )


def are_laminar(panel, data, window, *, zero=0.0):
    """Long slips of the last block after the transient are shaded and counted; no others are."""
    about = data.attributes
    slips = made.long_slips(about["duration"], about["n_blocks"])[1:3]
    inside = [np.clip(slip, *window) - zero for slip in slips if slip[1] > window[0]]
    inside = [(begin, end) for begin, end in inside if end > begin]
    np.testing.assert_allclose([span[1:] for span in panel.spans], inside)
    length = about["duration"] - about["transient"]
    point = rf"$u = {about['belt_velocity']:g}$, $\sigma = {about['noise']:g}$"
    assert f"{point}: 2 laminar phases, {1400 / length:.0%} of $t$ = {length:g}" in panel.title


def test_fig16_is_a_part_with_both_motions_of_two_series_with_their_spectra_and_laminar_shares():
    data = {"u17": made.series(5, 17.5, 2.2, length=39400)}
    data |= {"u19": made.series(5, 19.0, 2.2, length=42400)}
    above, below, first, second, shares = shown("fig16", **data)
    # the first part of 60000, in steps of a tenth from the transient on, with both long slips
    for panel, spectrum, name, begin in (
        (above, first, "u17", 18500),
        (below, second, "u19", 24500),
    ):
        arrays, end = data[name].arrays, begin + 60000
        part = (arrays["time"] >= begin) & (arrays["time"] <= end)
        panel.draws("$t$", "$x_N$", (arrays["time"][part], arrays["positions"][part, 4]))
        are_laminar(panel, data[name], (begin, end))
        is_spectrum(spectrum, data[name])
    assert shares.guides == [("x", 17.5), ("x", 19.0)]
    u = SCANS["n5_replicates"][1]
    share = made.laminar(u, 2.2)
    shares.draws("$u$", "laminar share", (np.repeat(u, 3), np.repeat(share, 3)), (u, share))


def test_fig20_is_a_panel_for_each_belt_velocity_and_the_last_sticks_of_runs():
    *stack, last = shown("fig20")
    for panel, u in zip(stack, (28, 31, 34, 38), strict=True):
        arrays = dataset(f"n10_u{u}").arrays
        part = (arrays["time"] >= 1500) & (arrays["time"] <= 11500)
        xlabel = "$t$ since the left edge of the panel" if u == 38 else ""
        curve = arrays["time"][part] - 1500, arrays["positions"][part, 9]
        panel.draws(xlabel, "$x_N$", curve)
        are_laminar(panel, dataset(f"n10_u{u}"), (1500, 11500), zero=1500)
    u = SCANS["size_replicates"][1]
    stick = np.where(u > 30, [[0.25], [0.88], [0.92]], 0.92)
    share = (u, np.where(u > 30, 1 / 3, 1), "share that sticks to the end")
    last.draws("$u$", "last stick / length of run", (np.tile(u, 3), stick.ravel(), "a run"), share)
    assert last.guides == [("y", 0.25)]


def test_a_slip_that_never_ends_is_one_laminar_phase():
    data = dataset("n10_u34")
    events, velocities = data.arrays["events"], data.arrays["velocities"].copy()
    velocities[..., -1] = 1.0
    data = changed(data, events=events[events["block"] != 10], velocities=velocities)
    panel = shown("fig20", n10_u34=data)[2]
    assert ": 1 laminar phase, 100% of" in panel.title and len(panel.spans) == 1


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
        is_slope(panel, printed, law.x, lambda x, law=law: law.y)


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


def test_fig10_is_a_density_where_points_are_many():
    data = made.catalogue(points=30_000)
    points = data.arrays["section"]
    position, relative = points["positions"][:, 4], points["velocities"][:, 4] - 1.5
    (image,) = shown("fig10", slips_u1=data)[0].images
    slips = relative < 0
    expected = np.histogram2d(position[slips], relative[slips], (240, 240))
    seen = np.nan_to_num(image.values).T, image.x_edges, image.y_edges
    for values, wanted in zip(seen, expected, strict=True):
        np.testing.assert_allclose(values, wanted)
    assert image.scale == "log"


# --- scans ----------------------------------------------------------------------------------------


def test_fig12_is_the_row_without_noise_with_the_other_method_over_it():
    top, disorder, _, exponents = shown("fig12")
    top.draws("", "$v_N$", crossings("n5_rows", 5, 0.0))
    assert "section $x_N = 555$" in top.title
    is_exponents(exponents, 5)
    single = row("n5_rows", 5, 0.0)
    starts = (*runs(*row("n5_replicates_check", 5, 0.0)), "other starts")
    disorder.draws("", "$r$", single, row("n5_rows_check", 5, 0.0), starts, more=0)
    assert disorder.legend == ["other starts", "as in the paper", "exact motion"]
    assert disorder.spans[-1] == ("x", 15, 18)  # Sec. IV.A
    data = made.data_of("fig12")
    del data["n5_replicates_check"], data["n5_rows_check"]
    drawn.panels_of(made.draw("fig12", data))[1].draws("", "$r$", single)


def is_exponents(panel, n_blocks):
    """A mark for each run, coloured and named by its motion."""
    arrays = dataset("motion_map").arrays
    for state in np.unique(arrays["state"][arrays["n_blocks"] == n_blocks]):
        here = (arrays["n_blocks"] == n_blocks) & (arrays["state"] == state)
        names = ("belt_velocity", "largest_exponent", "standard_error")
        u, value, error = (arrays[name][here] for name in names)
        curve = panel.curve(state)
        np.testing.assert_allclose(curve.points.T, [u, value, *drawn.ends(value, error)])
        assert curve.colour == motion_panels.COLOURS[state]


def test_fig12_tells_irregular_motion_from_the_time_to_the_last_stick():
    """Means over all five-block runs from starts spread by 10; by the scheme, of those that end."""
    runs = irregular.settling(
        n_blocks=[4, 5], belt_velocity=[1, 20, 32], initial_spread=[1, 10.0],
        lasts=lambda n, u: np.where(u > 1, 2e4 * n / 5 + 100 * u, 1e12),
    )  # fmt: skip
    _, _, panel, _ = shown("fig12", survival=runs)
    assert (panel.xlabel, panel.ylabel) == ("", r"$\tau$")
    arrays, means = runs.arrays, []
    for u in (20, 32):
        here = (arrays["n_blocks"] == 5) & (arrays["initial_spread"] == 10)
        time = arrays["lifetime"][here & (arrays["belt_velocity"] == u)]
        means.append(np.minimum(time, 5e5).sum() / np.sum(time <= 5e5))
    curve = panel.curve("irregular, exact")
    assert curve.x.tolist() == [20, 32] and curve.y == pytest.approx(means)
    # nothing ends at u = 1 in the 5e5 of 16 runs: as much comes in 2.5 % of all cases at the limit
    limit = next(curve for curve in panel.curves if curve.x.tolist() == [1])
    assert stats.poisson.cdf(0, 16 * 5e5 / limit.y[0]) == pytest.approx(0.025)
    ended = panel.curve("to the last stick, paper's scheme")
    assert ended.x.size and set(ended.x) <= {18.0, 24.0}  # of 30 two runs end
    arrays = dataset("lifetimes_wide").arrays
    for u, mean in zip(ended.x, ended.y, strict=True):
        here = (arrays["belt_velocity"] == u) & arrays["escaped"]
        assert np.median(arrays["lifetime"][here]) / 2 < mean < 1500


NOISES = (0.0, 1.0, 2.2, 5.0, 10.0)  # of Fig. 13


def test_fig13_is_single_runs_and_independent_ones_for_each_noise():
    above, below = shown("fig13")
    # the scans by the scheme are crosses here, and those by exact motion have the noise's marks
    curves = [row("n5_rows", 5, s) for s in NOISES]
    exact = [(*row("n5_rows_check", 5, s), rf"$\sigma = {s:g}$") for s in (0.0, 1.0)]
    above.draws("$u$", "$r$", *curves, *exact)
    assert "paper's scheme" in above.legend
    markers = {curve.marker for curve in above.curves if not curve.label}
    assert markers == {"x"} and above.curve(r"$\sigma = 0$").marker != "x"
    assert above.guides == [("x", 16.5), ("x", 19)]  # critical velocities, Sec. IV
    rows = {s: row("n5_replicates", 5, s) for s in NOISES[:4]}
    curves = [(*mean(*points), rf"$\sigma = {s:g}$") for s, points in rows.items()]
    # without noise branches coexist: no means
    curves[0] = curves[0][0], np.full(curves[0][0].size, np.nan), curves[0][2]
    check = runs(*row("n5_replicates_check", 5, 0.0))
    dots = [runs(*points) for points in rows.values()]
    below.draws("$u$", "$r$", *curves, *dots, (*check, "paper's scheme"))
    assert below.curve("paper's scheme").marker == "x"


def test_means_are_drawn_only_where_all_runs_lie_on_one_branch():
    data = dataset("n5_replicates")
    disorder = data.arrays["disorder_parameter"].copy()
    apart = (data.arrays["belt_velocity"] == 20) & (data.arrays["replicate"] == 1)
    disorder[apart] *= 0.4
    _, below = shown("fig13", n5_replicates=changed(data, disorder_parameter=disorder))
    curve = below.curve(r"$\sigma = 1$")
    assert curve.x[np.isnan(curve.y)].tolist() == [20]


def test_fig14_is_a_diagram_of_all_noises_and_a_column():
    *strips, below = shown("fig14")
    for strip, noise in zip(strips, made.LEVELS, strict=True):
        assert strip.title.endswith(rf"$\sigma = {noise:g}$")
        xlabel = "$u$" if strip is strips[-1] else ""
        strip.draws(xlabel, "$v_N$", crossings("n5_rows", 5, noise))
    points = column("n5_u7", 5, 7.0)
    below.draws(r"$\sigma$", "$r$", runs(*points), mean(*points))
    assert ("x", 0.75) in below.guides  # Sec. IV.B


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
        (image,) = panel.images
        np.testing.assert_allclose(image.y_edges, np.linspace(lowest, 0, 121))
        np.testing.assert_allclose(image.x_edges, np.append(U - 1.5, U[-1] + 1.5))
        for place, u in enumerate(U):
            values = made.crossings("n5_rows", 5, u, s)[:-2]
            expected, _ = np.histogram(values, image.y_edges, density=True)
            np.testing.assert_allclose(np.nan_to_num(image.values[:, place]), expected)
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
    rows = [[u for u, noise in inside if noise == s] for s in noises]
    ends = {(u, s) for s, row in zip(noises, rows, strict=True) if row for u in (row[0], row[-1])}
    between = [point for point in inside if point not in ends]
    dots = [np.repeat(points, 3, axis=0).T for points in (sorted(ends), between)]
    above.draws("$u$", r"$\sigma$", *dots)
    low, high = intermittency.LAMINAR_SHARE
    u = SCANS["n5_replicates"][1]
    shares = [(u, made.laminar(u, s), rf"$\sigma = {s:g}$") for s in (0.0, 1.0, 2.2, 5.0)]
    all_runs = [np.repeat((u, made.laminar(u, s)), 3, axis=1) for s in (0.0, 1.0, 2.2, 5.0)]
    below.draws("$u$", "laminar share", *shares, *all_runs)
    assert below.guides == [("y", low), ("y", high)]


@pytest.mark.parametrize(("apart", "joined"), [(0.4, True), (0.6, False)])
def test_fig18_joins_no_means_of_runs_that_keep_to_one_motion(apart, joined):
    data = dataset("n5_replicates")
    differing = (data.arrays["noise"] == 1) & (data.arrays["belt_velocity"] == 17)
    share = data.arrays["laminar_fraction"].copy()
    share[differing] = 0.3
    share[np.flatnonzero(differing)[0]] += apart
    changed = Dataset(data.arrays | {"laminar_fraction": share}, data.attributes)
    _, below = shown("fig18", n5_replicates=changed)
    line = below.curve(r"$\sigma = 1$").points[:, 1]
    assert np.isfinite(line).all() == joined and np.isfinite(line).any() == joined
    assert np.isfinite(below.curve(r"$\sigma = 2.2$").points).all()


def test_fig18_leaves_holes_and_has_no_dot_where_nothing_is_intermittent():
    data = dataset("n5_map")
    hole = (data.arrays["belt_velocity"] == U[1]) & (data.arrays["noise"] == 2.5)
    arrays = {name: values[~hole] for name, values in data.arrays.items()}
    arrays["laminar_count"] = np.zeros(arrays["noise"].size, dtype=int)
    panel, _ = shown("fig18", n5_map=Dataset(arrays, data.attributes))
    assert np.argwhere(np.isnan(panel.images[0].values)).tolist() == [[1, 1]]
    assert not panel.curves and "no point is intermittent" in panel.title


def test_fig19_is_replicates_of_three_sizes_and_single_runs_of_all():
    above, below = shown("fig19")
    names = {5: "n5_replicates", 7: "size_replicates", 10: "size_replicates"}
    rows = {n: row(name, n, 1.0) for n, name in names.items()}
    curves = [(*mean(*points), f"$N = {n}$") for n, points in rows.items()]
    curves += [runs(*points) for points in rows.values()]
    above.draws("", "$r$", *curves)
    # u_c and its ends; the made-up table has none for seven and ten blocks
    assert sorted(above.guides) == [("x", u) for u in (18.2, 18.5, 18.8)]
    marks = {curve.marker for curve in above.curves if curve.label == "" and len(curve.x) > 1}
    assert len(marks) == 3  # which tell the runs of the three apart in grey
    assert above.spans == [("x", 15, 18), ("x", 23, 32), ("x", 27, 40)]  # caption of Fig. 19
    curves = [(*row("n5_rows", n, 1.0), f"$N = {n}$") for n in (4, 5)]
    curves += [(*row("size_rows", n, 1.0), f"$N = {n}$") for n in made.SIZES]
    curves += [(*row("n5_rows_check", n, 1.0), "") for n in (5, 6)]
    curves += [(*row("size_rows_check", n, 1.0), "") for n in (2, 6)]
    below.draws("$u$", "$r$", *curves)
    assert above.texts == ["paper: $N = 5$", "$N = 7$", "$N = 10$"]
    assert "$N = 5$, exact motion" in below.legend  # with the colour of its crosses


def test_fig22_is_a_diagram_of_all_noises_for_each_number_of_blocks():
    for panel, n in zip(shown("fig22"), made.SIZES, strict=True):
        assert f"$N = {n}$, $x_N = {111 * n}$" in panel.title
        noises = (0.0, 1.0, 5.0)
        diagrams = []
        for s, aside in zip(noises, (-0.32, 0, 0.32), strict=True):  # side by side in a column
            u, velocity = crossings("size_rows", n, s)
            diagrams.append((u + aside, velocity, rf"$\sigma = {s:g}$"))
        panel.draws("$u$" if n > 6 else "", "" if n in (3, 6, 10) else "$v_N$", *diagrams)


# --- the virtual experiment -----------------------------------------------------------------------


def filmed(name, **replaced):
    """Panels of a figure of the virtual experiment, and its data."""
    data = made.data_of(name, **replaced)
    figure = made.draw(name, data)
    assert "virtual experiment" in figure.get_suptitle()
    return data, drawn.panels_of(figure)


def test_fig02_is_the_first_frame_with_a_line_to_each_part():
    data, (panel,) = filmed("fig02")
    (image,) = panel.images
    np.testing.assert_array_equal(image.values, next(data["belt_028_film"]()).picture)
    # lines end at the blocks: what is white under the last one, and black under the others
    ends = {words: getattr(text, "xy", None)
            for words, text in zip(panel.texts, panel.axes.texts, strict=True)}  # fmt: skip
    places = [ends[words] for words in ("block 1", "2", "3", "4", "5, white")]
    beneath = [int(image.values[round(y) + 8, round(x)]) for x, y in places]
    assert beneath[-1] > 150 > 25 > max(beneath[:-1])
    x, y = ends["fixed point"]  # at the side of the support, which is grey, at the wall
    assert 40 < image.values[round(y), round(x) - 6] < 100 and places[0][0] - x > 50
    metres = data["belt_028"].arrays["positions"][0] * LENGTH_M
    gaps = np.diff([x for x, _ in places]) * recorded.PIXEL
    assert gaps == pytest.approx(np.diff(metres), abs=0.002)


def test_fig03_is_a_second_of_frames_with_the_track_on_the_white():
    data, (strips, trace) = filmed("fig03")
    track = data["belt_028_track"]
    early, ((_, begin, end),) = track.time_s <= 10, trace.spans
    trace.draws("$t$ (s)", "$x_5$ (cm)", (track.time_s[early], 100 * track.x_m[early]))
    chosen = (track.time_s >= begin - 1e-9) & (track.time_s <= end + 1e-9)
    assert chosen[np.diff(track.x_m[early]).argmin()]  # the fastest move back is in it
    (dots,) = [curve for curve in strips.curves if curve.marker]
    np.testing.assert_allclose(dots.points.T, [100 * track.x_m[chosen], np.arange(24) + 0.5])
    (image,) = strips.images
    centres = (image.x_edges[:-1] + image.x_edges[1:]) / 2
    rows = np.array_split(image.values, 24)
    seen = [np.average(centres, weights=strip.sum(axis=0)) for strip in rows]
    # now and then the threshold also lets the support through, which is no block by its shape
    assert np.sum(np.abs(seen - 100 * track.x_m[chosen]) < 0.2) >= 22


def is_part(panel, spectrum):
    """The spectrum of a part of a recording, up to 8 Hz."""
    kept = spectrum.frequency_hz <= 8
    expected = spectrum.frequency_hz[kept], spectrum.power[kept]
    np.testing.assert_allclose(panel.curves[0].points.T, expected)


def test_fig04_is_two_recordings_with_spectra_of_small_and_large_amplitudes():
    data, panels = filmed("fig04")
    for name, (trace, small, large) in (("belt_028", panels[:3]), ("belt_035", panels[3:])):
        track = data[f"{name}_track"]
        analysis = recording.analyse(track.time_s, track.x_m)
        np.testing.assert_allclose(trace.curves[0].points.T, [analysis.time_s, 100 * analysis.x_m])
        assert f"$r$ = {analysis.disorder_parameter:.3g} (" in trace.title
        assert ("(paper, recorded: 0.052)" in trace.title) == (name == "belt_028")  # Sec. II
        for panel, part in ((small, "small"), (large, "large")):
            is_part(panel, analysis.spectra[part])
        steps = [place for axis, place in small.guides if axis == "x"]
        assert steps == pytest.approx(recorded.FUNDAMENTAL * np.arange(1, 7), abs=0.01)
        assert "multiples of 0.6 Hz: p = 0.001" in " ".join(small.texts) and not large.guides
    restless = recorded.track(recorded.run(0.28, 1.0, seed=2))
    _, (_, small, *_) = filmed("fig04", belt_028_track=restless)
    assert "does not alternate here" in small.texts[0] and not small.curves


def test_fig05_is_the_recording_with_the_spectrum_of_all_of_it():
    data, (trace, below, enlarged) = filmed("fig05")
    time, x = data["belt_022_track"].time_s, 100 * data["belt_022_track"].x_m
    analysis = recording.analyse(time, x / 100)
    minute = np.abs(time - (time[0] + time[-1]) / 2) <= 30
    np.testing.assert_allclose(enlarged.curves[0].points.T, [time[minute], x[minute]])
    np.testing.assert_allclose(trace.curves[0].points.T, [analysis.time_s, 100 * analysis.x_m])
    is_part(below, analysis.spectra["whole"])
    assert "slip at once for 1.2e+02 s at most" in trace.title
    assert "(paper, recorded: 0.072)" in trace.title  # Sec. II

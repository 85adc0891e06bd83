"""Which numbers the figures draw that the paper does not have: further studies, integrators."""

import itertools

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from scipy import stats
from test_figure_content import is_density, shown

import drawn
import figure_data as made
from beltrepro.replication.drawing import replicate_panels, style
from beltrepro.replication.studies.chaos import figures as chaos
from beltrepro.replication.studies.chaos import words as chaos_words
from beltrepro.stats import survival
from figure_data import ENDS, dataset


def near(panel, label, x, y, ends=None, *, within=0.3):
    """A curve of these values, whose places are moved aside a little, by less than `within`."""
    curve = panel.curve(label)
    np.testing.assert_allclose(curve.y, y)
    assert np.abs(curve.x - x).max() < within
    if ends is not None:
        np.testing.assert_allclose(curve.points.T[2:], ends)


# --- transition, friction ratio, avalanches -------------------------------------------------------


def test_critical_velocity_is_the_middles_of_the_falls_with_their_regions():
    left, right = shown("critical_velocity")
    assert (left.xlabel, left.ylabel) == (r"$\sigma$", "$u_c$")
    assert (right.xlabel, right.ylabel) == ("$N$", "$u_c$")
    near(left, "exact motion", [0, 1], [18, 18.5], [[17.5, 18.2], [18.6, 18.8]], within=0.2)
    near(left, "scheme of the paper", [0], [19.5], [[19.1], [20.1]], within=0.2)
    near(left, "scheme, wide starts", [0], [17.5], [[17.5], [17.5]], within=0.2)
    paper = left.curve("paper")
    assert (paper.x.tolist(), paper.y.tolist()) == ([0, 2.2], [16.5, 19])  # Sec. IV.A and IV.B
    regions = {(low, high) for _, low, high in left.bars}
    assert regions >= {(17, 19), (18, 19.2), (17.5, 21.5), (16.5, 18.5)}
    assert r"no fall by half at $\sigma$ = 2.2" in left.texts
    near(right, r"$\sigma = 0$", [5, 7], [18, 28], [[17.5, 27], [18.6, 29]])
    near(right, r"$\sigma = 1$", [5], [18.5], [[18.2], [18.8]])
    strips = [tuple(curve.y) for curve in right.curves if curve.line]
    assert strips == [(15, 18), (23, 32), (27, 40)]  # caption of Fig. 19
    assert "no fall by half at $N$ = 10" in right.texts


def test_avalanches_are_a_density_for_each_number_of_blocks_and_where_it_ends():
    left, right = shown("avalanches")
    sizes = (3, 5, 7, 10)
    ends = []
    for n, name in zip(sizes, ("slips_n3", "slips_u1", "slips_n7", "slips_n10"), strict=True):
        events = dataset(name).arrays["avalanches"]
        energy = events["dissipated"]
        label = f"$N = {n}$, {energy.size} avalanches"
        is_density(left, energy, label, bins=8, run=events["point"])
        ends.append((np.quantile(energy, 0.99), energy.max()))
    left.draws(r"$\Delta E$", r"$P(\Delta E)$", scales="log log", more=4)
    quantiles, largest = np.transpose(ends)
    right.draws("$N$", r"$\Delta E$", (sizes, quantiles), (sizes, largest, "largest"),
                scales="log log", more=1)  # fmt: skip
    law, bars = right.curve(r"$\propto N"), right.curve("99% quantile").points[:, 2:]
    # without N = 3, whose motion is another; weighted by the intervals, in logarithms
    weights = 1 / np.log(bars[:, 1] / bars[:, 0])
    slope, _ = np.polyfit(np.log(sizes[1:]), np.log(quantiles[1:]), 1, w=weights[1:])
    np.testing.assert_allclose(np.diff(np.log(law.y)) / np.diff(np.log(law.x)), slope)
    assert f"{slope:.2f}" in law.label


# --- irregular motion -----------------------------------------------------------------------------


def runs_at(data, **point):
    return np.all([data.arrays[name] == value for name, value in point.items()], axis=0)


def share_left(data, times, **point):
    """Share of the runs that are still irregular: all are given up at once, so a plain share."""
    lifetime = data.arrays["lifetime"][runs_at(data, **point)]
    return [np.mean(lifetime > time) for time in times]


def test_survival_is_the_share_still_irregular():
    one_each, many, *_ = shown("survival")
    runs = dataset("survival")
    assert one_each.xlabel == many.xlabel == "$t$"
    assert (one_each.axes.get_xscale(), many.axes.get_yscale()) == ("log", "log")
    assert len(one_each.legend) == 4
    for label in one_each.legend:
        size, velocity = (float(part.split("=")[1].strip(" $")) for part in label.split(","))
        curve = one_each.curve(label)
        point = {"n_blocks": size, "belt_velocity": velocity, "initial_spread": 1.0}
        np.testing.assert_allclose(curve.y, share_left(runs, curve.x, **point), atol=1e-12)
        # the belt velocity at which about half of the runs end, in half of the duration
        left = [abs(share_left(runs, [5e5], **(point | {"belt_velocity": u}))[0] - 0.5)
                for u in ENDS]  # fmt: skip
        assert left[ENDS.index(velocity)] == min(left)
        assert curve.x[-1] == min(5e5, runs.arrays["lifetime"][runs_at(runs, **point)].max())
    assert many.legend == [f"$N = 5$, $u = {u:g}$, 150 runs" for u in ENDS[:2]]
    for u, label in zip(ENDS, many.legend, strict=False):
        curve = many.curve(label)
        shares = share_left(dataset("survival_many"), curve.x, belt_velocity=u)
        np.testing.assert_allclose(curve.y, shares, atol=1e-12)
    table = dataset("mean_lifetimes")
    for panel, name, least in ((one_each, "survival", 3), (many, "survival_many", 2)):
        lines = [curve for curve in panel.curves if curve.line == "--"]
        means = [-1 / np.polyfit(curve.x, np.log(curve.y), 1)[0] for curve in lines]
        lifetimes = table.loc[table["dataset"] == name, "lifetime"].to_numpy()
        assert len(means) >= least  # all but those of which no run ended
        assert all(np.isclose(value, lifetimes, rtol=1e-6).any() for value in means)


def test_mean_lifetimes_have_their_intervals_and_limits_arrows():
    *_, by_velocity, by_size = shown("survival")
    table = dataset("mean_lifetimes")
    for panel, xlabel in ((by_velocity, "$u$"), (by_size, "$N$")):
        assert (panel.xlabel, panel.axes.get_yscale()) == (xlabel, "log")
        assert panel.guides == [("y", 5e5)]
    rows = table[(table["initial_spread"] == 1) & (table["dataset"] == "survival")]
    unlabelled = np.concatenate([curve.y for curve in by_velocity.curves if not curve.label])
    assert np.isinf(rows["lifetime"]).any()
    for n, points in rows.groupby("n_blocks"):
        ended = points[np.isfinite(points["lifetime"])]
        bars = [ended["lifetime_lower"], ended["lifetime_upper"]]
        if len(ended):
            u = ended["belt_velocity"]
            near(by_velocity, f"$N = {n}$", u, ended["lifetime"], bars, within=1.5)
        assert set(points["lifetime_lower"][np.isinf(points["lifetime"])]) <= set(unlabelled)
    assert set(table.loc[table["dataset"] == "survival_long", "lifetime"]) <= set(unlabelled)
    for spread in (1, 10):
        points = table[(table["initial_spread"] == spread) & np.isfinite(table["lifetime"])]
        near(by_size, f"spread {spread}", points["n_blocks"], points["lifetime"])


def shares_are(panel, data, ways):
    """Each cell (u, N) is filled by the shares of the ways that its runs move."""
    sizes, expected, cells = np.unique(data.arrays["n_blocks"]), {}, {}
    for (line, size), (place, u) in itertools.product(enumerate(sizes), enumerate(ENDS)):
        here = ways[runs_at(data, belt_velocity=u, n_blocks=size)]
        for way, count in zip(*np.unique(here, return_counts=True), strict=True):
            colour = to_rgba(chaos._LOOKS[way][0])
            expected[place, line, colour] = pytest.approx(count / here.size)
    for bar in panel.axes.patches:
        x, y = bar.get_x() + bar.get_width() / 2, bar.get_y() + bar.get_height() / 2
        if bar.get_height() > 0:
            cells[round(x), round(y), bar.get_facecolor()] = bar.get_height() / chaos._FILL
    assert cells == expected
    assert drawn.plain(panel.axes.get_xticklabels()) == [f"{u:g}" for u in ENDS]
    assert drawn.plain(panel.axes.get_yticklabels()) == [f"${size}$" for size in sizes]


def test_motion_map_is_the_shares_of_the_ways_to_move():
    sizes, exponents = shown("motion_map")
    points = dataset("motion_map")
    numbers = np.unique(points.arrays["n_blocks"])
    shares_are(sizes, points, points.arrays["state"])
    dots = [curve for curve in exponents.curves if curve.marker == "."]
    assert sum(curve.x.size for curve in dots) == points.arrays["state"].size
    for n in numbers:
        here = [runs_at(points, n_blocks=n, belt_velocity=u) for u in ENDS]
        median = [np.median(points.arrays["largest_exponent"][runs]) for runs in here]
        np.testing.assert_allclose(exponents.curve(str(n)).points.T, [ENDS, median])


def test_motion_map_marks_what_longer_runs_do():
    panel = shown("motion_map")[0]
    table = dataset("mean_lifetimes").copy()
    table["observed"] = table["counted"] * table["horizon"]
    most = table.groupby(["n_blocks", "belt_velocity"])["observed"].transform("max")
    table = table[(table["observed"] == most) & table["n_blocks"].isin(made.SIZES)]
    table = table.drop_duplicates(["n_blocks", "belt_velocity"], keep="last")
    sizes = [*made.SIZES[:3], 5, *made.SIZES[3:]]
    for verdict, words in (
        (survival.LASTING, "irregular motion lasts in longer runs"),
        (survival.TRANSIENT, "irregular motion ends in longer runs"),
    ):
        rows = table[table["verdict"] == verdict]
        points = zip(rows["belt_velocity"], rows["n_blocks"], strict=True)
        expected = {(ENDS.index(u), sizes.index(n)) for u, n in points}
        marks = set(map(tuple, panel.curve(words).points.astype(int)))
        assert expected and expected <= marks
        assert all(sizes[line] == 5 for _, line in marks - expected)  # many runs of five


# --- trials of the experiment ---------------------------------------------------------------------


def test_trials_of_the_experiment():
    disorder, share = shown("experiment_noise")
    levels = np.array([0.5, 1, 2, 4])
    curves = []
    for label, shift in (("0.22 m/s", 0.96), ("0.28 m/s", 1.04)):
        curves += [(shift * levels, np.full(4, 0.1375), label), (shift * levels, np.full(4, 0.13))]
    disorder.draws(r"$\sigma$", "$r$", *curves, scales="log linear")
    assert sorted(disorder.guides) == [("y", 0.052), ("y", 0.072)]
    velocities = 12.01756 * (14 / 11) ** np.arange(-1.0, 3)
    # 0, 2, 4 and 1 of the four trials of each recording alternate at the four noises, and f_s = 0.6
    of_all = np.array([0, 7, 7, 0]) / 16
    lines = [(velocities, 0 * of_all, "0.45"), (velocities, of_all, "0.6")]
    share.draws("$u$", "share with both regimes", *lines)


# --- comparison of integrators --------------------------------------------------------------------


def test_disorder_of_two_integrators():
    left, middle, right = shown("agreement_disorder")
    u = np.array(made.PAIRED_U)
    curves, differences, ks, welch = [], [], [], []
    for s in made.PAIRED_NOISES:
        ours, theirs = ([made.noisy_r(side, v, s) for v in u] for side in (1, 2))
        errors = [np.std(values, axis=1, ddof=1) / 3 for values in (ours, theirs)]
        curves.append((u, np.mean(theirs, axis=1)))
        curves.append((u, np.mean(ours, axis=1), rf"$\sigma = {s:g}$", errors[0]))
        difference = np.mean(ours, axis=1) - np.mean(theirs, axis=1)
        differences.append((u, difference / np.hypot(*errors)))
        for one, other in zip(ours, theirs, strict=True):
            ks.append(stats.ks_2samp(one, other).pvalue)
            welch.append(stats.ttest_ind(one, other, equal_var=False).pvalue)
    left.draws("$u$", "$r$", *curves)
    middle.draws("$u$", "difference / standard error", *differences)
    # the largest of six normal deviates exceeds this in 5 of 100 cases
    limit = stats.norm.ppf((1 + 0.95 ** (1 / 6)) / 2)
    assert middle.spans == [("y", -2, 2)]
    assert [guide[1] for guide in middle.guides] == pytest.approx([-limit, limit], rel=0.01)
    share = (np.arange(6) + 0.5) / 6
    p_values = ((share, np.sort(ks), "distributions"), (share, np.sort(welch), "means"))
    right.draws("expected in order", "p-value", ([0, 1], [0, 1]), *p_values)


def test_attractors_of_two_integrators():
    figure = made.draw("agreement_attractors", made.data_of("agreement_attractors"))
    looks = [
        ("verlet, $dt = 0.001$", style.COLOURS[0], 1, 0.001),
        ("verlet, $dt = 0.002$", style.COLOURS[1], 1, 0.002),
        ("event", style.BLACK, 2, 0.001),
    ]
    assert drawn.plain(figure.legends[0].get_texts()) == [look[0] for look in looks]
    panels = drawn.panels_of(figure)
    for row, spread in enumerate(made.SPREADS):
        left, right = panels[2 * row : 2 * row + 2]
        assert f"initial spread {spread:g}" in left.title
        assert (left.ylabel, right.ylabel) == ("share still sticking", "$r$ at the end")
        for index, (label, colour, side, step) in enumerate(looks):
            ends = [made.settled_r(side, u, spread, step) for u in made.PAIRED_U]
            sticks = np.array([stuck for stuck, _ in ends], dtype=float)
            shares, error = left.curve(label), sticks.std(axis=1, ddof=1) / made.RUNS**0.5
            assert shares.colour == colour and np.abs(shares.x - np.arange(3)).max() < 0.5
            np.testing.assert_allclose(shares.y, sticks.mean(axis=1))
            np.testing.assert_allclose(shares.points[:, 2], shares.y - error)
            for place, (_, r) in enumerate(ends):
                dots = right.curves[3 * index + place]
                np.testing.assert_allclose(dots.y, np.sort(r))
                assert np.abs(dots.x - place).max() < 0.5 and dots.colour == colour
    for panel in panels[-2:]:
        assert panel.xlabel == "$u$ (not to scale)"
        assert drawn.plain(panel.axes.get_xticklabels()) == ["10", "30", "50"]


# --- what is drawn of replicates, and said of numbers ---------------------------------------------


def test_means_are_joined_where_runs_lie_within_half_of_each_other():
    axes = Figure().subplots()
    places, values = [1.0, 1.0, 2.0, 2.0, 3.0, 3.0], [1.0, 1.4, 1.0, 1.6, 2.0, 2.0]
    replicate_panels.draw_runs(axes, np.array(places), np.array(values), 0)
    runs, means = axes.lines
    assert (list(runs.get_xdata()), list(runs.get_ydata())) == (places, values)
    np.testing.assert_allclose(means.get_ydata(), [1.2, np.nan, 2.0])


@pytest.mark.parametrize(
    ("values", "words"),
    [([], ""), ([7.0, 5.0, 7.0], "5, 7"), ([1.0, 4.0, 2.0, 3.0, 4.0], "1, 2, 3, 4"),
     ([5.0, 1.0, 2.0, 3.0, 4.0], "1 to 5")],
)  # fmt: skip
def test_a_few_numbers_or_the_ends_of_a_range(values, words):
    assert chaos_words._span(pd.Series(values, dtype=float)) == words

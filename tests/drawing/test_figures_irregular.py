"""What the figures of irregular motion show: the right numbers in the right panel."""

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from beltrepro.base.errors import InputError
from beltrepro.replication.drawing.content import content
from beltrepro.replication.studies.chaos import mean_lifetimes, motion_map, survival
from irregular import motion, settling, survivals

U = [3.0, 12.0, 33.0]
STARTS = [1.0, 10.0]


def with_table(runs):
    return runs | {"mean_lifetimes": mean_lifetimes.derive(runs)}


@pytest.fixture(scope="module")
def lasting():
    return with_table(survivals(n_blocks=[4, 6, 7, 10], belt_velocity=U, initial_spread=STARTS))


@pytest.fixture(scope="module")
def mapped(lasting):
    kicked = settling(
        n_blocks=[5], belt_velocity=U, method=["event"], kick=[0, 1e-7, 2e-3], errors="kick"
    )
    steps = settling(
        n_blocks=[5], belt_velocity=U, method=["verlet"], time_step=[2e-5, 1e-3], errors="time_step"
    )
    steps.arrays["irregular_exponent"][:] = np.nan  # verlet has none
    return {
        "motion_map": motion(n_blocks=[2, 4, 6, 7, 10], belt_velocity=U),
        "mean_lifetimes": lasting["mean_lifetimes"],
        "kicked": kicked,
        "steps": steps,
    }


def runs_at(data, **point):
    arrays = data.arrays
    return np.all([arrays[name] == value for name, value in point.items()], axis=0)


@pytest.mark.thorough
def test_alternative_texts_count_the_panels(lasting, mapped):
    assert survival.FIGURE.alt.startswith("Four panels")
    assert len(content(survival.draw(lasting, "")).panels) == 4
    assert motion_map.FIGURE.alt.startswith("Four panels")
    assert len(content(motion_map.draw(mapped, "")).panels) == 4


# --- survival -------------------------------------------------------------------------------------


@pytest.mark.thorough
def test_survival_is_the_share_still_irregular(lasting):
    """All runs are given up at once, so the curve is a plain share, to half of the duration."""
    panel, *_ = content(survival.draw(lasting, "")).panels
    assert (panel.titles[0], panel.xlabel, panel.xscale) == ("a.", "$t$", "log")
    curves = {curve.label: curve for curve in panel.curves if curve.label}
    assert tuple(curves) == panel.legend and len(curves) == 4
    runs = lasting["survival"]
    for label, curve in curves.items():
        size, velocity = (float(part.split("=")[1].strip(" $")) for part in label.split(","))
        lifetime = {
            u: runs.arrays["lifetime"][
                runs_at(runs, n_blocks=size, belt_velocity=u, initial_spread=1.0)
            ]
            for u in U
        }
        left = {u: abs(np.mean(each > 5e5) - 0.5) for u, each in lifetime.items()}
        assert left[velocity] == min(left.values())
        equal = [lifetime[u].mean() for u in U if left[u] == left[velocity]]
        assert lifetime[velocity].mean() == max(equal)
        share = [np.mean(lifetime[velocity] > time) for time in curve.x]
        np.testing.assert_allclose(curve.y, share, atol=1e-12)
        assert curve.x[0] == 0 and curve.x[-1] == min(5e5, lifetime[velocity].max())


def test_survival_of_many_runs_is_on_a_logarithmic_scale(lasting):
    _, panel, *_ = content(survival.draw(lasting, "")).panels
    runs = lasting["survival_many"]
    assert (panel.titles[0], panel.xlabel, panel.yscale) == ("b.", "$t$", "log")
    assert panel.legend == tuple(f"$N = 5$, $u = {u:g}$, 150 runs" for u in U[:2])
    curves = [curve for curve in panel.curves if curve.label]
    for u, curve in zip(U, curves, strict=False):
        lifetime = runs.arrays["lifetime"][runs_at(runs, belt_velocity=u)]
        share = [np.mean(lifetime > time) for time in curve.x]
        np.testing.assert_allclose(curve.y, share, atol=1e-12)


def test_an_exponential_with_the_mean_lifetime_lies_beside_each_curve(lasting):
    table = lasting["mean_lifetimes"]
    each, many, *_ = content(survival.draw(lasting, "")).panels
    for panel, name, least in ((each, "survival", 3), (many, "survival_many", 2)):
        dashed = [curve for curve in panel.curves if curve.line == "--"]
        means = [-1 / np.polyfit(curve.x, np.log(curve.y), 1)[0] for curve in dashed]
        assert len(means) >= least  # all but those of which no run ended
        known = table.loc[table["dataset"] == name, "lifetime"].to_numpy()
        assert all(np.isclose(mean, known, rtol=1e-6).any() for mean in means)


def test_mean_lifetimes_have_their_intervals_and_limits_arrows(lasting):
    figure = content(survival.draw(lasting, ""))
    *_, by_velocity, by_size = figure.panels
    assert by_velocity.xlabel == "$u$" and by_size.xlabel == "$N$"
    for panel in (by_size, by_velocity):
        assert panel.yscale == "log" and panel.guides == (("y", 5e5),)
    assert figure.legend == tuple(f"$N = {n}$" for n in (4, 6, 7, 10))
    table = lasting["mean_lifetimes"]
    rows = table[(table["initial_spread"] == 1) & (table["dataset"] == "survival")]
    ended, lasts = (rows[np.isfinite(rows["lifetime"]) == finite] for finite in (True, False))
    assert len(ended) and len(lasts)
    curves = [curve for curve in by_velocity.curves if curve.label]
    np.testing.assert_allclose(np.concatenate([curve.y for curve in curves]), ended["lifetime"])
    half = (ended["lifetime_upper"] - ended["lifetime_lower"]) / 2
    np.testing.assert_allclose(np.concatenate([curve.error for curve in curves]), half)
    others = np.concatenate([curve.y for curve in by_velocity.curves if not curve.label])
    assert set(lasts["lifetime_lower"]) <= set(others)
    longer = table[table["dataset"] == "survival_long"]
    assert set(longer["lifetime"]) <= set(others)


def test_lifetimes_against_size_are_of_all_datasets(lasting):
    panel = content(survival.draw(lasting, "")).panels[-1]
    table = lasting["mean_lifetimes"]
    dots = {curve.label: curve for curve in panel.curves if curve.label}
    assert tuple(dots) == ("initial spread 1", "initial spread 10")
    for spread, curve in zip(STARTS, dots.values(), strict=True):
        rows = table[(table["initial_spread"] == spread) & np.isfinite(table["lifetime"])]
        np.testing.assert_allclose(curve.y, rows["lifetime"])
        assert np.abs(curve.x - rows["n_blocks"]).max() < 0.3


# --- motion map -----------------------------------------------------------------------------------


def cells(axes):
    """Filled part of each cell by (column, row, colour)."""
    filled = {}
    for bar in axes.patches:
        if bar.get_height() > 0:
            column = round(bar.get_x() + bar.get_width() / 2)
            row = round(bar.get_y() + bar.get_height() / 2)
            filled[column, row, bar.get_facecolor()] = bar.get_height() / motion_map._FILL
    return filled


def colour(way):
    return to_rgba(motion_map._LOOKS[way][0])


def shares_are(axes, data, row, ways):
    """Each cell is filled by the shares of the ways that the runs of its point move."""
    levels, expected = np.unique(data.arrays[row]), {}
    for line, level in enumerate(levels):
        for column, u in enumerate(U):
            here = runs_at(data, belt_velocity=u, **{row: level})
            for way in np.unique(ways[here]):
                expected[column, line, colour(way)] = np.mean(ways[here] == way)
    found = cells(axes)
    assert found.keys() == expected.keys()
    for place, share in expected.items():
        assert found[place] == pytest.approx(share)
    assert [text.get_text() for text in axes.get_xticklabels()] == [f"{u:g}" for u in U]


def test_cells_are_shares_of_the_ways_to_move(mapped):
    figure = motion_map.draw(mapped, "")
    sizes, _, kicks, steps = figure.axes
    shares_are(sizes, mapped["motion_map"], "n_blocks", mapped["motion_map"].arrays["state"])
    # By the method event the exponent says which irregular motion is chaotic.
    arrays = mapped["kicked"].arrays
    value, error = arrays["irregular_exponent"], arrays["irregular_error"]
    chaotic = (value > 3 * error) & (value > 5 / arrays["irregular_time"])
    way = np.where(chaotic, "chaotic", "transient")
    ways = np.where(arrays["state"] == "irregular", way, arrays["state"])
    assert {"chaotic", "periodic", "equilibrium slip"} <= set(ways)
    shares_are(kicks, mapped["kicked"], "kick", ways)
    # Verlet has no exponent: its irregular motion is not told apart.
    ways = np.where(mapped["steps"].arrays["state"] == "irregular", "transient", "")
    ways = np.where(ways == "", mapped["steps"].arrays["state"], ways)
    shares_are(steps, mapped["steps"], "time_step", ways)


def test_axes_and_legend_have_words(mapped):
    figure = motion_map.draw(mapped, "")
    *_, kicks, steps = figure.axes
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["$N$", r"largest exponent $\lambda_1$", "size of kicks", "time step $dt$"]
    words = [[text.get_text() for text in axes.get_yticklabels()] for axes in (kicks, steps)]
    assert words[0] == ["$0$", "$10^{-7}$", "$0.002$"]
    assert words[1] == [r"$2 \times 10^{-5}$", "$0.001$"]
    assert kicks.get_title(loc="right") == "$N = 5$, method event"
    assert steps.get_title(loc="right") == "$N = 5$, method verlet"
    (legend,) = figure.legends
    shown = {text.get_text() for text in legend.get_texts()}
    assert "periodic" in shown and "quasi-periodic" not in shown


def test_marks_say_what_longer_runs_do(mapped):
    sizes = motion_map.draw(mapped, "").axes[0]
    table = mapped["mean_lifetimes"].copy()
    table["observed"] = table["counted"] * table["horizon"]
    most = table.groupby(["n_blocks", "belt_velocity"])["observed"].transform("max")
    table = table[(table["observed"] == most) & (table["n_blocks"] != 5)]
    table = table.drop_duplicates(["n_blocks", "belt_velocity"], keep="last")
    for verdict, (_, words) in motion_map._MARKS.items():
        (line,) = [line for line in sizes.lines if line.get_label() == words]
        rows = table[table["verdict"] == verdict]
        assert len(rows)
        found = sorted(zip(*line.get_data(), strict=True))
        columns = [U.index(u) for u in rows["belt_velocity"]]
        lines = [[2, 4, 6, 7, 10].index(n) for n in rows["n_blocks"]]
        assert found == sorted(zip(columns, lines, strict=True))


def test_exponents_are_medians_over_the_runs(mapped):
    panel = content(motion_map.draw(mapped, "")).panels[1]
    arrays = mapped["motion_map"].arrays
    dots = [curve for curve in panel.curves if curve.marker == "."]
    assert sum(curve.x.size for curve in dots) == arrays["state"].size
    lines = {curve.label: curve for curve in panel.curves if curve.label}
    assert list(map(int, lines)) == np.unique(arrays["n_blocks"]).tolist()
    for label, line in lines.items():
        for u, value in zip(line.x, line.y, strict=True):
            here = runs_at(mapped["motion_map"], n_blocks=int(label), belt_velocity=u)
            assert value == np.median(arrays["largest_exponent"][here])


def test_what_is_missing_is_noted(mapped):
    only = {"motion_map": mapped["motion_map"]}
    notes = [text for panel in content(motion_map.draw(only, "")).panels for text in panel.texts]
    assert len(notes) == 3
    for name, note in zip(("mean_lifetimes", "kicked", "steps"), notes, strict=True):
        assert f"{name} is not there" in note
    with pytest.raises(InputError, match="figure needs the dataset motion_map"):
        motion_map.draw({}, "")


def test_runs_that_all_last_are_drawn():
    lasts = {"lasts": lambda n, u: np.full(n.size, np.inf), "initial_spread": [1.0]}
    runs = settling(**lasts, n_blocks=[10], belt_velocity=[7.0])
    data = with_table(dict.fromkeys(mean_lifetimes.TABLE.uses, runs))
    each, many, by_velocity, by_size = content(survival.draw(data, "")).panels
    for panel in (each, many):
        assert [curve.y.tolist() for curve in panel.curves] == [[1, 1]]
    for panel in (by_size, by_velocity):
        assert any(data["mean_lifetimes"]["lifetime_lower"][0] in curve.y for curve in panel.curves)

"""The catalogue of attractors, and the tables of attractors and mean lifetimes."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.chaos import measure
from beltrepro.replication.studies.chaos.measure import catalogue
from beltrepro.stats import survival
from beltrepro.stats.estimates import share
from irregular import exponent, settling

# state, period, slips in it, returns in it, r
ENDS = [
    ("periodic", 41.047, 18, 2, 0.05),
    ("periodic", 41.047 * (1 + 3e-7), 18, 2, 0.055),
    ("periodic", 41.047 * (1 - 3e-7), 18, 2, 0.045),
    ("periodic", 41.047, 18, 2, 0.08),  # another orbit of the same period
    ("periodic", 41.047 * (1 + 1e-5), 18, 2, 0.05),  # and of nearly the same
    ("periodic", 41.047, 19, 2, 0.05),
    ("irregular", np.nan, 0, 0, 0.13),
    ("irregular", np.nan, 0, 0, 0.12),
    ("equilibrium slip", np.nan, 0, 0, 0.002),
    ("equilibrium slip", np.nan, 0, 0, 0.02),
]


def ends(rows):
    names = ("state", "period_time", "period_events", "period_returns", "disorder_parameter")
    columns = dict(zip(names, map(np.array, zip(*rows, strict=True)), strict=True))
    return columns | {"mean_length": 300 + np.arange(len(rows))}


def test_runs_are_grouped_by_orbit():
    attractors = catalogue(ends(ENDS))
    assert [(one.state, one.runs, one.period_events) for one in attractors] == [
        ("periodic", 3, 18),
        ("equilibrium slip", 2, 0),
        ("irregular", 2, 0),
        ("periodic", 1, 19),
        ("periodic", 1, 18),
        ("periodic", 1, 18),
    ]
    assert [one.disorder_parameter for one in attractors[3:]] == [0.05, 0.08, 0.05]
    first = attractors[0]
    assert first.period_time == pytest.approx(41.047, rel=1e-9) and first.period_returns == 2
    assert first.disorder_parameter == 0.05 and first.mean_length == 301
    assert first.basin == share(3, 10)
    assert np.isnan(attractors[1].period_time) and attractors[
        1
    ].disorder_parameter == pytest.approx(0.011)


def test_a_multiple_of_a_period_is_the_same_orbit():
    rows = [
        ("periodic", 2 * 23.585351 * (1 + 2e-8), 18, 2, 0.0639),
        ("periodic", 23.585351, 9, 1, 0.0638),
        ("periodic", 3 * 23.585351, 27, 3, 0.0637),
        ("periodic", 2 * 23.585351 * (1 + 1e-5), 18, 2, 0.0638),  # a doubled period
        ("periodic", 2 * 23.585351, 19, 2, 0.0638),
    ]
    attractors = catalogue(ends(rows))
    assert [(one.runs, one.period_events) for one in attractors] == [(3, 9), (1, 19), (1, 18)]
    assert attractors[0].period_time == pytest.approx(23.585351, rel=1e-7)
    assert attractors[0].period_returns == 1


def test_the_order_of_the_runs_does_not_matter():
    rng = np.random.default_rng(0)
    expected = repr(catalogue(ends(ENDS)))
    for _ in range(20):
        order = rng.permutation(len(ENDS))
        assert repr(catalogue({name: one[order] for name, one in ends(ENDS).items()})) == expected


def test_a_catalogue_needs_runs():
    with pytest.raises(NotEnoughDataError, match="no runs, 1 is needed"):
        catalogue({name: column[:0] for name, column in ends(ENDS).items()})


# --- tables ---------------------------------------------------------------------------------------

NONE = settling(n_blocks=[], belt_velocity=[], initial_spread=[])


def table_of(name, runs):
    """The table of one dataset, the others without runs; with all the columns it explains."""
    entry = measure.TABLES[name]
    table = getattr(measure, name)(dict.fromkeys(entry.uses, NONE) | {"survival": runs})
    assert set(entry.columns) <= set(table)
    return table


LEVELS = {"n_blocks": [4, 6, 10], "belt_velocity": [7.0, 12.0], "initial_spread": [1.0, 10.0]}


def test_the_table_of_attractors_counts_every_run_once():
    data = settling(**LEVELS, runs=20)
    table = table_of("attractors", data)
    points = table.groupby(["n_blocks", "belt_velocity", "initial_spread"], sort=False)
    assert len(points) == 12
    for (n, u, spread), rows in points:
        assert rows["number"].tolist() == list(range(1, len(rows) + 1))
        assert rows["reached"].sum() == 20 and rows["share"].sum() == pytest.approx(1)
        assert rows["reached"].is_monotonic_decreasing
        here = (data.arrays["n_blocks"] == n) & (data.arrays["belt_velocity"] == u)
        here &= data.arrays["initial_spread"] == spread
        for _, row in rows[rows["state"] == "periodic"].iterrows():
            same = here & (data.arrays["period_events"] == row["period_events"])
            assert row["reached"] == same.sum()
            period = np.median(data.arrays["period_time"][same])
            assert row["period_time"] == pytest.approx(period, rel=1e-12)


def test_the_table_of_mean_lifetimes_finds_what_was_put_in():
    """Lifetimes of mean 5e4, and a third of the runs that settle before they have spread."""
    point = {"n_blocks": [7, 8], "belt_velocity": [12.0], "initial_spread": [1.0]}
    data = settling(lasts=lambda n, u: np.full(n.size, 5e4), duration=1e5, runs=200, **point)
    early = data.arrays["replicate"] % 3 == 0
    data.arrays["lifetime"][early] = 100.0
    data.arrays["settled"][early] = True
    table = table_of("mean_lifetimes", data)
    assert table["n_blocks"].tolist() == [7, 8] and table["runs"].tolist() == [200, 200]
    for _, row in table.iterrows():
        time = data.arrays["irregular_time"][data.arrays["n_blocks"] == row["n_blocks"]]
        error = 0.02 / np.sqrt(time[time > 2000].sum())
        assert row["exponent_error"] == pytest.approx(error, rel=0.3)
        assert row["exponent"] == pytest.approx(exponent(row["n_blocks"], 12.0), abs=4 * error)
        assert row["start"] == pytest.approx(5 / row["exponent"])
        assert row["start"] > 100 and row["counted"] < 140
        assert row["lifetime_lower"] < 5e4 < row["lifetime_upper"]
        assert row["share_lower"] < np.exp(-2) * 2 / 3 < row["share_upper"]
        assert row["verdict"] == survival.TRANSIENT
        assert row["share"] == pytest.approx(1 - row["settled"] / row["runs"])


def test_lasting_and_regular_points_have_rows_too():
    def lasts(n, u):
        return np.where(n == 10, np.inf, 10.0)

    data = settling(lasts=lasts, n_blocks=[4, 10], belt_velocity=[12.0], initial_spread=[1.0])
    regular, row = (table_of("mean_lifetimes", data).set_index("n_blocks").loc[n] for n in (4, 10))
    assert (row["verdict"], row["horizon"]) == (survival.LASTING, 5e5)
    assert row["lifetime"] == row["lifetime_upper"] == np.inf
    assert row["lifetime_lower"] == pytest.approx(16 * (5e5 - row["start"]) / np.log(40))
    assert (row["attractor"], row["share"]) == ("irregular", 1)
    # Nothing irregular was long enough for an exponent: all lifetimes count.
    assert np.isnan(regular["exponent"]) and regular["start"] == 0
    assert regular["lifetime"] == pytest.approx(10, rel=1) and regular["ended"] == 16
    assert regular["verdict"] == survival.REGULAR


def test_each_dataset_has_rows_with_its_own_horizon():
    point = {"n_blocks": [5], "belt_velocity": [7.0], "initial_spread": [10.0]}
    names = measure.TABLES["mean_lifetimes"].uses
    lengths = zip(names, (1e5, 2e5, 1e7), strict=True)
    runs = {name: settling(**point, duration=duration) for name, duration in lengths}
    lifetimes, orbits = measure.mean_lifetimes(runs), measure.attractors(runs)
    assert lifetimes["dataset"].tolist() == list(runs)
    assert lifetimes["horizon"].tolist() == [5e4, 1e5, 5e6]
    assert orbits.groupby("dataset")["reached"].sum().tolist() == [16, 16, 16]
    for table in (lifetimes, orbits):
        assert list(table.columns[:4]) == ["dataset", "n_blocks", "belt_velocity", "initial_spread"]


def test_datasets_without_runs_make_empty_tables():
    assert all(table_of(name, NONE).empty for name in ("attractors", "mean_lifetimes"))


# --- motions --------------------------------------------------------------------------------------


def test_motions_and_exponents_under_noise_by_a_plain_loop():
    """Points with unequal numbers of runs, in any order."""
    rng = np.random.default_rng(4)
    points = [(4, 7.0)] * 3 + [(4, 9.0)] * 7 + [(6, 7.0)] * 5
    n_blocks, u = (np.array(column) for column in zip(*rng.permutation(points), strict=True))
    names = np.array(["periodic", "chaotic", "transient", "equilibrium slip"])
    arrays = {
        "n_blocks": n_blocks.astype(int),
        "belt_velocity": u,
        "noise": n_blocks / 10,
        "state": rng.choice(names, u.size),
        "largest_exponent": rng.normal(size=u.size),
        "period_events": rng.integers(0, 30, u.size),
        "disorder_parameter": rng.random(u.size),
    }
    data = {name: Dataset(arrays, {}) for name in ("motion_map", "noisy_motion")}
    table = measure.motions(data).set_index(["n_blocks", "belt_velocity"])
    noisy = measure.noisy_motions(data).set_index(["noise", "belt_velocity"])
    assert len(table) == len(noisy) == 3
    for (n, velocity), row in table.iterrows():
        runs = [k for k in range(u.size) if (n_blocks[k], u[k]) == (n, velocity)]
        exponents = arrays["largest_exponent"][runs]
        mean = [exponents.mean(), exponents.std(ddof=1) / np.sqrt(len(runs))]
        np.testing.assert_allclose(row[["exponent", "error"]].astype(float), mean)
        under_noise = noisy.loc[(n / 10, velocity)]
        np.testing.assert_allclose(under_noise[["exponent", "error"]].astype(float), mean)
        assert row["runs"] == under_noise["runs"] == len(runs)
        r = arrays["disorder_parameter"][runs]
        assert under_noise["r"] == pytest.approx(r.mean())
        assert row["longest_period"] == max(arrays["period_events"][runs])
        states = list(arrays["state"][runs])
        assert all(row[name] == states.count(name) for name in names)
        for column, group in (("r_periodic", names[:1]), ("r_irregular", names[1:3])):
            of_group = [value for value, state in zip(r, states, strict=True) if state in group]
            expected = np.mean(of_group) if of_group else np.nan
            assert row[column] == pytest.approx(expected, nan_ok=True)

"""Tables of motions that are named, and of how long they are irregular."""

import numpy as np
import pytest

from beltrepro.base.store import Dataset
from beltrepro.replication.studies.chaos import measure
from beltrepro.stats import survival
from irregular import exponent, settling

NAMES = measure.TABLES["mean_lifetimes"].uses
NONE = settling(n_blocks=[], belt_velocity=[], initial_spread=[])


def lifetimes(runs):
    """The table of one dataset, the others without runs; with all the columns it explains."""
    table = measure.mean_lifetimes(dict.fromkeys(NAMES, NONE) | {"survival": runs})
    assert set(measure.TABLES["mean_lifetimes"].columns) <= set(table)
    return table


def test_the_table_of_mean_lifetimes_finds_what_was_put_in():
    """Lifetimes of mean 5e4, and a third of the runs that settle before they have spread."""
    point = {"n_blocks": [7, 8], "belt_velocity": [12.0], "initial_spread": [1.0]}
    data = settling(lasts=lambda n, u: np.full(n.size, 5e4), duration=1e5, runs=200, **point)
    early = data.arrays["replicate"] % 3 == 0
    data.arrays["lifetime"][early] = 100.0
    data.arrays["settled"][early] = True
    table = lifetimes(data)
    assert table["n_blocks"].tolist() == [7, 8] and table["runs"].tolist() == [200, 200]
    for _, row in table.iterrows():
        time = data.arrays["irregular_time"][data.arrays["n_blocks"] == row["n_blocks"]]
        error = 0.02 / np.sqrt(time[time > 2000].sum())
        assert row["exponent_error"] == pytest.approx(error, rel=0.3)
        assert row["exponent"] == pytest.approx(exponent(row["n_blocks"], 12.0), abs=4 * error)
        assert row["start"] == pytest.approx(5 / row["exponent"])
        assert row["start"] > 100 and row["counted"] < 140
        assert row["lifetime_lower"] < 5e4 < row["lifetime_upper"]
        assert row["verdict"] == survival.TRANSIENT


def test_lasting_and_regular_points_have_rows_too():
    def lasts(n, u):
        return np.where(n == 10, np.inf, 10.0)

    data = settling(lasts=lasts, n_blocks=[4, 10], belt_velocity=[12.0], initial_spread=[1.0])
    regular, row = (lifetimes(data).set_index("n_blocks").loc[n] for n in (4, 10))
    assert (row["verdict"], row["horizon"]) == (survival.LASTING, 5e5)
    assert row["lifetime"] == row["lifetime_upper"] == np.inf
    assert row["lifetime_lower"] == pytest.approx(16 * (5e5 - row["start"]) / np.log(40))
    assert (row["attractor"], row["settled"]) == ("irregular", 0)
    # Nothing irregular was long enough for an exponent: all lifetimes count.
    assert np.isnan(regular["exponent"]) and regular["start"] == 0
    assert regular["lifetime"] == pytest.approx(10, rel=1) and regular["settled"] == 16
    assert regular["verdict"] == survival.REGULAR


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
    table = measure.motions({"motion_map": Dataset(arrays, {})}).set_index(
        ["n_blocks", "belt_velocity"]
    )
    assert len(table) == 3
    for (n, velocity), row in table.iterrows():
        runs = [k for k in range(u.size) if (n_blocks[k], u[k]) == (n, velocity)]
        exponents = arrays["largest_exponent"][runs]
        mean = [exponents.mean(), exponents.std(ddof=1) / np.sqrt(len(runs))]
        np.testing.assert_allclose(row[["exponent", "error"]].astype(float), mean)
        assert row["runs"] == len(runs)
        r = arrays["disorder_parameter"][runs]
        assert row["longest_period"] == max(arrays["period_events"][runs])
        states = list(arrays["state"][runs])
        assert all(row[name] == states.count(name) for name in names)
        for column, group in (("r_periodic", names[:1]), ("r_irregular", names[1:3])):
            of_group = [value for value, state in zip(r, states, strict=True) if state in group]
            expected = np.mean(of_group) if of_group else np.nan
            assert row[column] == pytest.approx(expected, nan_ok=True)

"""Tables: which there are, and what is in them."""

import numpy as np
import pytest

import figure_data as made
from beltrepro.base.errors import InputError
from beltrepro.base.store import Dataset
from beltrepro.replication.plan import registry
from beltrepro.replication.plan.registry import check_uses
from beltrepro.replication.studies.transition import measure
from beltrepro.stats import transition

TABLES = registry.tables()
POINTS = ("belt_velocity", "disorder_parameter")


# made from data of other tests: of films, series and pairs
ELSEWHERE = {"agreement"}


@pytest.mark.parametrize("name", sorted(set(TABLES) - ELSEWHERE))
def test_a_table_is_made_from_made_up_data(name):
    table = made.table(name, made.every(TABLES[name].uses))
    assert len(table) > 2 and set(TABLES[name].columns) <= set(table)


def replicates(n_blocks, noises, falls):
    """r that falls from 0.12 to 0.01 at falls(N, sigma, replicate), at 40 belt velocities."""
    grid = [(n, s, k, u) for n in n_blocks for s in noises for k in range(4) for u in range(1, 41)]
    n, noise, replicate, u = np.array(grid, dtype=float).T
    place = np.array([falls(*point[:3]) for point in grid])
    arrays = {"n_blocks": n.astype(int), "noise": noise, "replicate": replicate.astype(int)}
    arrays |= {"belt_velocity": u, "disorder_parameter": np.where(u < place, 0.12, 0.01)}
    arrays["last_stick_time"] = np.full(u.size, 2e4)
    return Dataset(arrays, {"transient": 1e4, "duration": 2e4})


def test_critical_velocities_are_the_falls_of_every_row():
    """Without noise all fall at 18; with it at 16, 19, 22 or 25; ten blocks never do."""
    five = replicates([5], [0.0, 1.0], lambda n, s, k: 18 if s == 0 else 16 + 3 * k)
    sizes = replicates([6, 10], [0.0], lambda n, s, k: 26 if n == 6 else 99)
    names = TABLES["critical_velocities"].uses
    table = measure.critical_velocities(dict.fromkeys(names, five) | {"size_replicates": sizes})
    assert set(TABLES["critical_velocities"].columns) <= set(table)
    assert table["dataset"].tolist() == [name for name in names for _ in "01"]
    assert table["runs"].tolist() == [4] * 8
    quiet, noisy, *_, six, ten = (table.iloc[row] for row in range(len(table)))
    for row, place in ((quiet, 17.5), (six, 25.5)):
        assert row["low"] <= place <= row["high"] and row["high"] - row["low"] < 1.7
    assert 15 < noisy["lower"] <= noisy["critical"] <= noisy["upper"] < 26
    assert noisy["high"] - noisy["low"] > 2
    assert np.isnan(ten[["critical", "low", "high", "lower", "upper"]].astype(float)).all()
    numbers = transition.fall(*(five.arrays[name][five.arrays["noise"] == 1] for name in POINTS))
    critical = numbers["critical"]
    assert (noisy["critical"], noisy["low"]) == (critical.value, critical.low)


def test_a_table_that_uses_what_is_not_there_is_one_line():
    with pytest.raises(InputError) as caught:
        check_uses(TABLES, [*TABLES, "friction_rato", "pairs_r_verlet"], "preset own")
    assert str(caught.value).startswith("agreement uses 'pairs_r_event', which preset own")
    with pytest.raises(InputError, match="agreement has the name of a table"):
        registry.check_names(["u1", "agreement"])

"""Tables: which there are, and that of the study of the friction ratio."""

import importlib

import numpy as np
import pytest

from beltrepro.entries import check_uses
from beltrepro.errors import InputError
from beltrepro.store import Dataset
from beltrepro.tables import friction_falls, registry

TABLES = registry.entries()


def falling(ratios, velocities, place):
    """r that falls from 0.3 to 0.05 at u = place * f_s, twice at every u."""
    grid = np.array([(f, u) for f in ratios for u in velocities for _ in range(2)])
    ratio, velocity = grid.T
    disorder = np.where(velocity < place * ratio, 0.3, 0.05)
    arrays = {"friction_ratio": ratio, "belt_velocity": velocity, "disorder_parameter": disorder}
    return {"friction_ratio": Dataset(arrays, {})}


def test_every_table_is_a_module_with_a_function():
    of_integrators = {"agreement", "families", "partings", "convergence"}
    of_chaos = {"motions", "noisy_motions", "mean_lifetimes", "attractors"}
    assert of_integrators | of_chaos | {"friction_falls", "audit"} == set(TABLES)
    for name, entry in TABLES.items():
        module = importlib.import_module(f"beltrepro.tables.{name}")
        assert entry == module.ENTRY and callable(module.derive)
        assert entry.file(name) == (name if name == "agreement" else f"tables/{name}")


def test_falls_are_found_for_each_friction_ratio():
    table = friction_falls.derive(falling([0.2, 0.4], np.arange(1.0, 41), 50.0))
    assert table["friction_ratio"].tolist() == [0.2, 0.4]
    assert table["points"].tolist() == [80, 80]
    np.testing.assert_allclose(table["critical"], [10, 20], atol=1.5)
    assert (table["lower"] <= table["critical"]).all() and (table["error"] > 0).all()
    assert table["r_high"].tolist() == [0.3, 0.3] and table["r_low"].tolist() == [0.05, 0.05]
    assert set(TABLES["friction_falls"].columns) <= set(table)


def test_too_few_points_leave_the_row_empty():
    table = friction_falls.derive(falling([0.2], [1.0, 2.0], 50.0))
    assert table["points"].tolist() == [4] and table["critical"].isna().all()


def test_a_table_that_uses_what_is_not_there_is_one_line():
    with pytest.raises(InputError) as caught:
        check_uses("tables", TABLES, [*TABLES, "friction_rato", "pairs_r_verlet"], "preset own")
    assert str(caught.value).startswith(
        "tables/agreement.py uses 'pairs_r_event', which preset own"
    )
    with pytest.raises(InputError, match="agreement has the name of a table"):
        registry.check_names(["u1", "agreement"])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("ENTRY = Entry(uses=())", "title is missing"),
        ("ENTRY = Entry(title='A.', uses=(), colums={})", "unknown field 'colums'"),
        ("ENTRY = Entry(title='A', uses=())", "must be one sentence"),
        ("ENTRY = Entry(title='A.', uses=('a', 'a'))", "must be a tuple of different names"),
        ("ENTRY = Entry(title='A.', uses=NAMES)", "must be a literal"),
    ],
)
def test_a_bad_entry_is_one_line(tmp_path, text, words):
    (tmp_path / "some.py").write_text(text)
    with pytest.raises(InputError) as caught:
        registry.entries(tmp_path)
    assert "some.py: ENTRY: " in str(caught.value) and words in str(caught.value)

"""Figures drawn from excerpts are, byte for byte, those drawn from the datasets."""

from pathlib import Path

import numpy as np
import pytest

import figure_data as made
from beltrepro.base.errors import InputError, NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan import registry
from beltrepro.replication.plan.kinds import KINDS
from beltrepro.replication.report import excerpts

PUBLISHED = Path(__file__).parents[2] / excerpts.PUBLISHED


def finished(data):
    """A made-up dataset with attributes as a job writes them, or what else a figure uses."""
    if not isinstance(data, Dataset):
        return data
    kind = max(KINDS, key=lambda kind: len(data.arrays.keys() & KINDS[kind].arrays))
    kind = "density" if "section_bins" in data.arrays else kind
    others = excerpts.WHOLE - KINDS[kind].arrays.keys()
    arrays = {name: array for name, array in data.arrays.items() if name not in others}
    config = f'{{"points": {{"count": {len(next(iter(arrays.values())))}}}}}'
    about = {name: data.attributes[name] for name in data.attributes.keys() - arrays}
    about |= {"dataset": "one", "run": "smoke", "digest": "0", "kind": kind, "config": config}
    return Dataset(arrays, about | {"method": data.attributes["method"]})


@pytest.fixture
def given(monkeypatch):
    """Datasets, tables and tracks by name, in place of those in files; excerpts are read."""
    data, load = {}, excerpts.io.load

    def loaded(paths):
        written = {name: path for name, path in paths.items() if f"/{excerpts.FOLDER}/" in path}
        return {name: data[name] for name in paths} | load(written)[0], {}

    monkeypatch.setattr(excerpts.io, "load", loaded)
    return data


def published(folder, name):
    """The folder of a run with a figure, whose excerpts are written."""
    for part in ("figures", excerpts.FOLDER):
        (folder / part).mkdir(parents=True)
    (folder / f"figures/{name}.png").touch()
    excerpts.write(excerpts.excerpts(folder), folder)
    return folder


QUICK = ("fig03", "fig07", "fig11", "fig16", "fig18")


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if name in QUICK else pytest.mark.thorough)
        for name in registry.figures()
    ],
)
def test_redrawn_it_has_the_same_bytes(name, given, tmp_path):
    given |= {used: finished(one) for used, one in made.data_of(name).items()}
    whole = [tmp_path / f"whole/{name}.{ending}" for ending in ("png", "pdf")]
    style.save(made.draw(name, given), *whole, {})
    run = published(tmp_path / "paper", name)
    for used, one in given.items():  # nothing but excerpts is left of datasets
        given[used] = None if callable(one) or isinstance(one, Dataset) else one
    excerpts.redraw(folder=run, target=tmp_path / "again")
    for path in whole:
        assert (tmp_path / "again" / path.name).read_bytes() == path.read_bytes()


def test_what_a_dataset_is_too_small_for_is_published(given, tmp_path):
    empty = made.catalogue()
    empty = Dataset({name: rows[:0] for name, rows in empty.arrays.items()}, empty.attributes)
    given["slips_u1"] = finished(empty)
    excerpts.redraw(folder=published(tmp_path / "paper", "fig09"), target=tmp_path / "again")
    assert (tmp_path / "again/fig09.png").exists()


def test_a_reduction_is_kept_by_its_arguments_and_asks_for_the_dataset():
    @panels.reduced
    def _last(dataset, count):
        if count > 3:
            raise NotEnoughDataError("too few")
        return {"time": dataset.arrays["time"][-count:]}

    whole = panels.Excerpt({"time": np.arange(3)}, {"kind": "series"})
    published = panels.Excerpt({}, {"kind": panels.EXCERPT, "dataset": "u1"}, whole.drawn)
    assert [_last(whole, n)["time"].size for n in (1, 2)] == [1, 2]
    assert _last(published, 2)["time"].tolist() == [1, 2]
    for dataset in (whole, published, published):
        with pytest.raises(NotEnoughDataError, match=r"^too few$"):
            _last(dataset, 4)
    assert _last(published, np.int64(1))["time"].tolist() == [2]  # a number as any other
    with pytest.raises(InputError, match="u1: its excerpt has no 'last 3'"):
        _last(published, 3)
    _last.__wrapped__.__module__ = "another"
    with pytest.raises(ValueError, match="last of another would be taken"):
        panels.reduced(_last.__wrapped__)


def test_an_array_that_is_not_published_is_one_line():
    excerpt = excerpts._excerpt(Dataset({}, {"config": '{"points": {"count": 2}}', "noise": 1.0}))
    assert excerpt.arrays["noise"].tolist() == [1.0, 1.0] and "positions" not in excerpt.arrays
    with pytest.raises(InputError, match="'positions' is not published"):
        excerpt.arrays["positions"]


def test_a_thinned_curve_has_its_ends_and_the_extremes_of_narrow_columns():
    x, y = np.arange(1e5), np.random.default_rng(1).normal(size=100_000)
    thin, values = panels.thinned(x, y)
    assert (thin[0], thin[-1]) == (0, 99_999) and thin.size <= 10_002
    assert np.array_equal(values, y[thin.astype(int)]) and np.all(np.diff(thin) > 0)
    parts = np.split(values, np.searchsorted(thin, x[1000::1000]))
    for extreme in (np.min, np.max):  # but of a column that is cut in two
        assert np.mean([*map(extreme, parts)] == extreme(y.reshape(-1, 1000), axis=1)) > 0.9


def test_one_line_says_what_is_missing(tmp_path):
    with pytest.raises(InputError, match="drawn: no such folder; `make publish RUN=paper` writes"):
        excerpts.redraw("fig12", folder=tmp_path / "paper")
    (tmp_path / excerpts.FOLDER).mkdir()
    with pytest.raises(InputError, match=r"n5_density\.h5: no such file"):
        excerpts.redraw("fig12", folder=tmp_path)
    with pytest.raises(InputError, match=r"figure = 'fig1'.*did you mean"):
        excerpts.redraw("fig1", folder=tmp_path)


def test_what_is_published_is_small():
    sizes = [path.stat().st_size for path in PUBLISHED.glob(f"{excerpts.FOLDER}/*")]
    sizes += [path.stat().st_size for path in PUBLISHED.glob("experiment/*")]
    assert max(sizes, default=0) <= 2e6 and sum(sizes) <= 10e6

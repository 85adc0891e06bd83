"""Every figure draws, whole or from hardly any data, labelled, not blank, the same bytes twice."""

import dataclasses

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.image import imread

import drawn
import figure_data as made
from beltrepro.base.errors import InputError
from beltrepro.base.store import Dataset
from beltrepro.replication.camera.track import Track
from beltrepro.replication.drawing import style
from beltrepro.replication.plan import registry

FIGURES = registry.figures()


def written(figure, folder):
    paths = folder / "figure.png", folder / "figure.pdf"
    style.save(figure, *paths, sources={})
    return paths


# --- every figure ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FIGURES)
def test_draws(name):
    figure = made.draw(name, made.data_of(name))
    assert figure.get_figheight() < 2 * figure.get_figwidth()  # with its caption it fits a page
    # the insets of the paper are panels here, so that they cover no data
    assert not any(axes.child_axes for axes in figure.axes)
    for panel in drawn.panels_of(figure):
        assert panel.axes.has_data(), "an empty panel"
        looks = {curve.label: curve.look for curve in panel.curves if curve.label}
        assert len(set(looks.values())) == len(looks), "two curves of a legend look alike"
        place = panel.axes.get_subplotspec()
        if name not in ("fig01", "fig02") and place is not None:
            assert panel.xlabel or not place.is_last_row()
            assert panel.ylabel or not place.is_first_col()


def test_drawn_again_it_has_the_same_bytes_in_one_style_and_any_format(tmp_path):
    figure = made.draw("fig06", {})
    png, pdf = written(figure, tmp_path / "plain")
    assert pdf.read_bytes().startswith(b"%PDF") and imread(png)[..., :3].std() > 0.04
    for name in ("again.pdf", "again.svg", "again.png"):
        style.write(figure, tmp_path / name, "figure")
    with matplotlib.rc_context({"font.size": 20, "savefig.dpi": 50, "lines.linewidth": 5}):
        other = written(made.draw("fig06", {}), tmp_path / "changed")
    assert (tmp_path / "again.png").read_bytes() == png.read_bytes() == other[0].read_bytes()
    assert pdf.read_bytes() == other[1].read_bytes()


def hardly(name):
    """One run or two samples in which nothing was measured, without an event."""
    data = made.dataset(name)
    if isinstance(data, Track):
        return dataclasses.replace(data, time_s=data.time_s[:2], x_m=data.x_m[:2])
    if isinstance(data, pd.DataFrame):
        found = {"critical", "low", "high", "lower", "upper"} & {*data.columns}
        found |= {name for name in data if name.startswith("lifetime")}
        return data.assign(**dict.fromkeys(found, np.nan))
    by_run = data.arrays.get("n_blocks", data.arrays.get("belt_velocity"))
    few = {"time": 2, "positions": 2, "velocities": 2, "friction": 2} if by_run is None else {}
    arrays = {
        key: values[: few.get(key, 0)] if by_run is None else values[:1]
        for key, values in data.arrays.items()
        if values.ndim and key != "section_bins"
    }
    for key in {"disorder_parameter", "section_histogram"} & set(arrays):
        arrays[key] = np.full_like(arrays[key], 0 if "histogram" in key else np.nan)
    if "section_bins" in data.arrays:
        arrays["section_bins"] = data.arrays["section_bins"]
    return Dataset(arrays, data.attributes)


# not those whose datasets have something at every point: both integrators, trials and films
ALWAYS_FULL = ("agreement", "experiment", "fig02", "fig03", "fig05")


@pytest.mark.thorough
@pytest.mark.parametrize(
    "name", [name for name in FIGURES if FIGURES[name].uses and not name.startswith(ALWAYS_FULL)]
)
@pytest.mark.filterwarnings("error")
def test_says_what_is_missing(name, tmp_path):
    with pytest.raises(InputError, match="needs the dataset"):
        made.draw(name, {})
    uses = [used for used in FIGURES[name].uses if not used.endswith("_check")]
    figure = made.draw(name, {used: hardly(used) for used in uses})
    written(figure, tmp_path)
    assert all(axes.has_data() or axes.texts for axes in figure.axes), "an empty panel, no word"


# --- the registry ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("entry", "complaint"),
    [
        ("Figure(title='A.')", "missing 1 required keyword-only argument: 'uses'"),
        ("Figure(uses=(), category='Further study')", "did you mean 'Further studies'?"),
    ],
)
def test_a_bad_entry_is_one_line(tmp_path, entry, complaint):
    (tmp_path / "figures.py").write_text(f"NAME = 3\nFIGURES = {{'fig03': {entry}}}\n")
    with pytest.raises(InputError) as caught:
        registry.figures(tmp_path)
    assert complaint in str(caught.value) and "\n" not in str(caught.value)

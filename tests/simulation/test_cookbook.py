"""The cookbook: each of its answers runs, shortened, and draws; it needs public names only."""

import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples"
# what takes long, and what shows the same in a moment
SHORT = [
    (r"(\d+)_000\b", r"\g<1>00"),
    (r"range\(1000\)", "range(8)"),
    (r"law\(0\.005", "law(0.05"),
    (r"replicates=\d+", "replicates=2"),
    (r"\[14, 15, 16, 17, 18\]", "[16]"),
    (r"np\.arange\((\d+), (\d+)", r"np.arange(\1, \1 + 5"),
    (r"workers=None", "workers=2"),
]


@pytest.mark.filterwarnings("ignore:.*loading is measured:UserWarning")
@pytest.mark.parametrize("recipe", sorted(FOLDER.glob("*.py")), ids=lambda path: path.stem)
def test_a_recipe_runs_and_draws(recipe, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("agg")
    code = recipe.read_text(encoding="utf-8")
    assert re.findall(r"^from beltrepro(\S*) import", code, re.MULTILINE) == [""]
    for pattern, short in SHORT:
        code = re.sub(pattern, short, code)
    try:
        exec(compile(code, recipe.name, "exec"), {})
        figures = [plt.figure(number) for number in plt.get_fignums()]
    finally:
        plt.close("all")
    assert len(figures) == 1 and all(axes.has_data() for axes in figures[0].axes)

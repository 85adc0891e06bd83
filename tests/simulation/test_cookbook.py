"""The cookbook: each of its answers runs, shortened, and draws or prints."""

import re
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "cookbook.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
HEAD, *QUESTIONS = re.split(r"^## ", PAGE, flags=re.MULTILINE)
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
@pytest.mark.parametrize("question", QUESTIONS, ids=lambda text: text.split("\n")[0])
def test_an_answer_of_the_cookbook_runs(question, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("agg")
    names: dict = {}
    (imports,), (code,) = BLOCK.findall(HEAD), BLOCK.findall(question)
    for pattern, short in SHORT:
        code = re.sub(pattern, short, code)
    try:
        exec(compile(imports + code, "cookbook.md", "exec"), names)
        drawn = [axes for number in plt.get_fignums() for axes in plt.figure(number).axes]
    finally:
        plt.close("all")
    assert (
        any(axes.has_data() for axes in drawn)
        or capsys.readouterr().out
        or list(tmp_path.iterdir())
    )

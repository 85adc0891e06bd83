"""What a newcomer tries first: the README, the command, the names."""

import re
import runpy
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

import beltrepro

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    """A folder of its own, without a display."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    yield
    plt.close("all")


def check_picture(path: Path) -> None:
    """That something is drawn."""
    pixels = imread(path)[..., :3]
    assert min(pixels.shape[:2]) > 300
    assert 0.02 < np.mean(pixels.min(axis=-1) < 0.9) < 0.98


def test_python_of_the_readme_runs(tmp_path):
    names: dict = {}
    (block,) = PYTHON.findall(README)
    exec(compile(block, "README.md", "exec"), names)
    check_picture(tmp_path / "r.png")
    # less kinetic friction, longer slips
    means = names["results"]["disorder_parameter"].reshape(-1, 8).mean(axis=1)
    assert means[0] > 2 * means[-1]


def test_the_module_is_the_command(capsys, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["beltrepro", "--version"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_module("beltrepro", run_name="__main__")
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"beltrepro {beltrepro.__version__}\n"
    cited = (Path(__file__).parents[2] / "CITATION.cff").read_text()
    assert f"\nversion: {beltrepro.__version__}\n" in cited


def test_dir_and_the_stub_show_the_public_names_and_nothing_else():
    shown = [name for name in dir(beltrepro) if not name.startswith("__")]
    assert shown == beltrepro.__all__
    stub = Path(beltrepro.__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    assert sorted(re.findall(r" import (\w+) as \1$", stub, re.MULTILINE)) == shown
    for home, name in re.findall(r"^from (\S+) import (\w+)", stub, re.MULTILINE):
        assert getattr(beltrepro, name) is getattr(import_module(home), name)


def test_the_package_alone_loads_no_library():
    script = "import beltrepro, sys; assert not {'numpy', 'numba', 'h5py'} & sys.modules.keys()"
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0

"""The documentation: its links lead somewhere, its code runs, and the reference is complete."""

import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

import beltrepro
from beltrepro.replication.camera.scene import camera_settings
from beltrepro.replication.plan import kinds, registry
from beltrepro.replication.plan.config import Config
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.verdicts.ledger import load_ledger
from extensions import claims_and_figures, configuration

ROOT = Path(__file__).parents[2]
PAGES = [*(ROOT / "docs").glob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
GENERATED = ROOT / "docs" / "reference"
COOKBOOK = ROOT / "docs" / "cookbook"  # of each file of examples a page, by Sphinx-Gallery


def blocks(page: Path, language: str = "python") -> list[str]:
    """Fenced code of a page."""
    text = page.read_text(encoding="utf-8")
    found = re.findall(rf"^( *)```{language}\n(.*?)^\1```$", text, re.M | re.S)
    return [textwrap.dedent(code) for _, code in found]


def anchors(page: Path) -> set[str]:
    """Places of a page that a link can lead to: its headings, as GitHub and MyST name them."""
    text = page.read_text(encoding="utf-8")
    for included in re.findall(r"{include} (\S+)", text):
        text += (page.parent / included).read_text(encoding="utf-8")
    heads = re.findall(r"^#+ (.*)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        address, _, place = link.partition("#")
        target = (page.parent / address).resolve() if address else page
        if "://" in address or target.is_relative_to(GENERATED):
            continue
        if target.parent == COOKBOOK:
            target = ROOT / "examples" / target.name.replace("index.rst", "README.rst")
            target = target if target.exists() else target.with_suffix(".py")
        assert target.exists(), link
        assert not place or target.suffix != ".md" or place in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_names_of_the_package_are_public(page):
    imports = re.findall(
        r"from beltrepro import (?:\(([^)]*)\)|(.*))", page.read_text(encoding="utf-8")
    )
    names = set(re.findall(r"\w+", " ".join(map("".join, imports))))
    assert names <= set(beltrepro.__all__)


@pytest.mark.thorough
def test_the_tutorial_draws_its_figure(tmp_path):
    """And its answer holds: at all speeds the mean pull is the kinetic friction."""
    code = "\n".join(blocks(ROOT / "docs" / "tutorial.md"))
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path, env=os.environ | {"MPLBACKEND": "agg"}, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "pull.png").stat().st_size > 10_000
    means = [float(one) for one in re.findall(r"mean from ([\d.]+) to ([\d.]+)", done.stdout)[0]]
    assert np.allclose(means, 0.45, atol=0.005)


def test_the_study_of_the_guide_is_planned_and_drawn(tmp_path):
    page = ROOT / "CONTRIBUTING.md"
    (entry,), (question, figures) = blocks(page, "yaml"), blocks(page)
    assert len((entry + question + figures).splitlines()) <= 50
    config = yaml.safe_load((ROOT / "config.yaml").read_text()) | {"preset": "standard"}
    config["datasets"] |= yaml.safe_load(entry)
    assert len(make_plan(config).datasets["linear_limits"].points) == 3 * 9 * 4
    (tmp_path / "figures.py").write_text(figures, encoding="utf-8")
    assert registry.figures(tmp_path)["linear_limits"].uses == ("linear_limits",)
    names: dict = {}
    exec(compile(figures, "figures.py", "exec"), names)
    u, limit = np.tile([10.0, 20.0], 2), np.repeat([10.0, 20.0], 2)
    arrays = {"belt_velocity": u, "linear_limit": limit, "disorder_parameter": 0.1 + u / 1000}
    drawn = names["linear_limits"]({"linear_limits": SimpleNamespace(arrays=arrays)})
    assert drawn.axes[0].lines
    assert arrays.keys() <= kinds.KINDS["scan"].arrays.keys()


def test_configuration_has_every_key_and_array():
    page = configuration.page()
    schema = Config.model_json_schema()
    parts = schema, *schema["$defs"].values()
    keys = {name for part in parts for name in part.get("properties", {})}
    arrays = {name for kind in kinds.KINDS.values() for name in kind.recorded}
    forms = {"start", "stop", "step", "offset", "count", "without_noise", "with_noise"}
    for name in (keys | arrays | camera_settings().keys()) - forms:
        assert f"| `{name}` |" in page, name


def test_results_have_every_figure_table_and_claim():
    page = claims_and_figures.page()
    assert all(f"\n({name})=\n" in page for name in registry.figures())
    assert all(f"\n### tables/{name}.csv\n" in page for name in registry.tables())
    assert all(f"\n### {name}\n" in page for name in load_ledger())

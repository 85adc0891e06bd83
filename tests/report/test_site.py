"""The site of the documentation: it builds without a warning, is complete and needs no network."""

import functools
import html
import http.server
import json
import re
import subprocess
import sys
import threading
from pathlib import Path
from urllib.parse import unquote, urldefrag, urljoin

import numpy as np
import pytest
import yaml

import beltrepro
import browser
import figure_data
from beltrepro.cli import app as cli
from beltrepro.replication.plan import kinds, registry
from beltrepro.replication.plan.config import Config
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.verdicts.ledger import load_ledger
from extensions import api, claims_and_figures, configuration, markdown, rule_graph, tutorial
from made_up import data

DOCS = Path(__file__).parents[2] / "docs"


# --- without building -----------------------------------------------------------------------------


@pytest.mark.slow
def test_the_tutorial_draws_its_figure(tmp_path):
    """And its answer holds: at all speeds the mean pull is the kinetic friction."""
    printed = tutorial.run(DOCS / "tutorial.md", tmp_path)
    assert (tmp_path / "pull.png").read_bytes().startswith(b"\x89PNG")
    means = [float(one) for one in re.findall(r"mean from ([\d.]+) to ([\d.]+)", printed)[0]]
    assert np.allclose(means, 0.45, atol=0.005)


def test_code_of_a_page_that_fails_is_an_error(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("```python\nx = 1\n```\n\ntext\n\n```python\nassert x == 2, 'no'\n```\n")
    with pytest.raises(RuntimeError, match=r"page\.md fails: AssertionError: no"):
        tutorial.run(page, tmp_path)


def test_the_figure_of_the_guide_registers_itself_and_is_drawn(tmp_path):
    text = (DOCS / "how_to" / "figure.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^ *```python\n(.*?)^ *```$", text, re.M | re.S)
    code = re.sub(r"^ {3}", "", code, flags=re.M)
    (tmp_path / "example.py").write_text(code, encoding="utf-8")
    (entry,) = registry.figures(tmp_path).values()
    names: dict = {}
    exec(compile(code, "example.py", "exec"), names)
    scan = data({"belt_velocity": [1.0, 2.0], "mean_length": [5.0, 4.0]})
    drawn = names["draw"](dict.fromkeys(entry.uses, scan))
    assert np.allclose(drawn.axes[0].lines[0].get_ydata(), [5.0, 4.0])
    assert "mean_length" in {array.name for array in kinds.KINDS["scan"].recorded}
    config = yaml.safe_load((DOCS.parent / "config.yaml").read_text())
    assert config["datasets"]["n5_rows"]["kind"] == "scan"


def test_the_study_of_the_guide_is_planned_measured_and_drawn(tmp_path):
    text = (DOCS / "how_to" / "study.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^ *```(?:yaml|python)\n(.*?)^ *```$", text, re.M | re.S)
    entry, _, measure, figure, made_up, _ = (re.sub("^ {3}", "", one, flags=re.M) for one in blocks)
    config = yaml.safe_load((DOCS.parent / "config.yaml").read_text()) | {"preset": "smoke"}
    config["datasets"] |= yaml.safe_load(entry)
    assert len(make_plan(config).datasets["linear_limits"].points) == 3 * 9 * 4
    names = {"np": np, "Dataset": figure_data.Dataset, "HOW": figure_data.HOW}
    for name, code in {"measure": measure, "linear_limits": figure, "made_up": made_up}.items():
        (tmp_path / f"{name}.py").write_text(code, encoding="utf-8")
        exec(compile(code, f"{name}.py", "exec"), names)
    assert list(registry.tables(tmp_path)) == ["limit_falls"]
    assert list(registry.figures(tmp_path)) == ["linear_limits"]
    scan = names["linear_limits"]()
    falls = names["limit_falls"]({"linear_limits": scan})
    assert np.allclose(falls["critical"], [20, 25], atol=2)  # u < 15 + limit / 2, on the mean
    drawn = names["draw"]({"linear_limits": scan, "limit_falls": falls})
    lines = [line.get_xdata()[0] for line in drawn.axes[0].lines[-2:]]
    assert np.allclose(lines, falls["critical"])


def test_configuration_has_every_key():
    def names(node):
        if isinstance(node, dict):
            yield from node.get("properties", {})
        if isinstance(node, dict | list):
            for part in node.values() if isinstance(node, dict) else node:
                yield from names(part)

    rules = {"start", "stop", "step", "without_noise", "with_noise", "offset", "count"}
    page = configuration.keys().replace("\\_", "_")
    for name in set(names(Config.model_json_schema())) - rules:
        assert f"| `{name}` |" in page, name
    assert rules <= set(re.findall(r"\w+", page)), "forms of an axis, in the words of its key"


def test_kinds_have_all_that_they_record():
    page = configuration.recorded()
    for kind in kinds.KINDS.values():
        part = page.split(f"### {kind.name}\n")[1].split("\n### ")[0]
        assert all(f"| `{one.name}` |" in part for one in kind.recorded)


@pytest.mark.thorough
def test_results_have_every_figure_table_and_claim():
    assert all(f"#### {name}\n" in claims_and_figures.figure_list() for name in registry.figures())
    listed = claims_and_figures.table_list()
    assert all(f"### {one.file(name)}.csv\n" in listed for name, one in registry.tables().items())
    assert all(f"### {name}\n" in claims_and_figures.claim_list() for name in load_ledger())


def test_figures_and_claims_have_links_both_ways():
    figures, claims = claims_and_figures.figure_list(), claims_and_figures.claim_list()
    parts = {text.split("\n")[0]: text for text in figures.split("#### ")[1:]}
    judged = {text.split("\n")[0]: text for text in claims.split("### ")[1:]}
    for name, text in parts.items():
        for claim in judged:
            assert (f"](#{claim})" in text) == (f"](#{name})" in judged[claim]), (name, claim)
    assert "](#u-critical)" in parts["fig12"] and "](#fig12)" in judged["u-critical"]


def test_words_are_no_marks():
    assert markdown.plain("x_N(t) < *u*, `a_b` [m]") == r"x\_N(t) \< \*u\*, `a_b` \[m\]"
    assert markdown.table(["a"], [["x | y\nz"]]) == "| a |\n| --- |\n| x \\| y z |"


def test_docstrings_are_shown_as_written():
    lines = ["Shares |x|, x_ and *C; `a_`:", "- one"]
    api.as_written(None, "", "", None, None, lines)
    assert lines == [r"Shares \|x\|, x\_ and \*C; `a_`:", "", "- one"]


def test_rules_do_not_cover_each_other():
    names = ["first", "second", "third", "last"]
    edges = [(0, 1), (0, 2), (1, 3), (2, 3), (0, 3)]
    drawn = rule_graph.drawing(names, edges)
    assert re.findall(r"<text[^>]*>(\w+)</text>", drawn) == names
    assert drawn.count('class="edge"') == len(edges)
    boxes = re.findall(r'<rect x="(\S+)" y="(\S+)" width="(\S+)" height="(\S+)"', drawn)
    boxes = np.array(boxes, dtype=float)
    for row, (x, y, width, height) in enumerate(boxes):
        across, down = np.abs(boxes[:, 0] - x) < width, np.abs(boxes[:, 1] - y) < height
        assert np.flatnonzero(across & down).tolist() == [row]
    low, top, *size = map(float, re.search(r'viewBox="(.*?)"', drawn)[1].split())
    assert np.all(boxes[:, :2] >= [low, top])
    assert np.all(boxes[:, :2] + boxes[:, 2:] <= np.add([low, top], size))


# --- the site -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_site(tmp_path):
    """One test, so that the site is built once, whatever the number of processes."""
    site = built(tmp_path)
    every_link_leads_somewhere(site)
    links_to_the_outside_are_listed(site)
    nothing_is_loaded_from_outside(site)
    public_names_lead_to_their_docstrings(site)
    the_command_has_every_option(site)
    if not browser.BROWSER:
        pytest.skip("no Chromium is installed")
    pages_fit_a_phone_and_ask_nobody(site, tmp_path)


def built(folder):
    """The site; a warning is an error."""
    call = ["-m", "sphinx", "-q", "-W", "--keep-going", "-d", str(folder / "trees")]
    done = subprocess.run(
        [sys.executable, *call, str(DOCS), str(folder / "site")],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "site"


def pages(site):
    return sorted(path for path in site.rglob("*.html") if "_static" not in path.parts)


@functools.cache
def marked(path):
    """Text of a page without scripts, and the places that a link can lead to."""
    text = re.sub(r"<script.*?</script>", "", path.read_text(encoding="utf-8"), flags=re.S)
    return text, set(re.findall(r'\bid="([^"]+)"', text))


def every_link_leads_somewhere(site):
    links = 0
    for page in pages(site):
        for link in re.findall(r'<a [^>]*?href="([^"]+)"', marked(page)[0]):
            address, place = urldefrag(html.unescape(link))
            if "://" in address:
                continue
            target = Path(unquote(urljoin(page.as_uri(), address)).removeprefix("file://"))
            assert target.exists(), f"{page.name}: {link}"
            links += 1
            if place and target.suffix == ".html":
                assert unquote(place) in marked(target)[1], f"{page.name}: {link}"
    assert links > 1000


def links_to_the_outside_are_listed(site):
    listed = set((site / "external_links.txt").read_text().split())
    assert "https://doi.org/10.1103/PhysRevE.87.042920" in listed
    assert all(one.startswith("https://") for one in listed)


def nothing_is_loaded_from_outside(site):
    tags = r"<(?:script|img|iframe|source|link)\b[^>]*?(?:src|href)="
    for suffix, loads in (("html", tags), ("css", r"(?:url\(|@import)\s*")):
        for path in site.rglob(f"*.{suffix}"):
            outside = loads + r"""['"]?(?:https?:)?//"""
            assert not re.findall(outside, path.read_text(encoding="utf-8")), path.name


def public_names_lead_to_their_docstrings(site):
    text, _ = marked(site / "reference" / "python.html")
    for name in beltrepro.__all__:
        result = re.search(rf'href="(api/[^"]+)"[^>]*><code[^>]*>(?:<span[^>]*>)?{name}<', text)
        assert result, name


def the_command_has_every_option(site):
    text, _ = marked(site / "reference" / "command.html")
    (commands,) = cli.parser()._subparsers._group_actions
    for name, parser in commands.choices.items():
        assert f'id="beltrepro-{name}"' in text
        for action in parser._actions:
            assert all(f">{option}<" in text for option in action.option_strings), name


PROBE = """
<!DOCTYPE html><html><head><meta charset="utf-8"></head><body><pre id="seen"></pre><script>
const seen = [];
const look = (pages) => {
  if (!pages.length) {
    document.getElementById("seen").textContent = JSON.stringify(seen);
    return;
  }
  const frame = document.createElement("iframe");
  frame.style = "width: 390px; height: 844px; border: 0";
  frame.onload = () => {
    const root = frame.contentDocument.documentElement;
    const loaded = frame.contentWindow.performance.getEntriesByType("resource").map((r) => r.name);
    const player = frame.contentDocument.querySelector(".live [data-do=play]");
    const beyond = root.scrollWidth - root.clientWidth;
    seen.push({page: pages[0], beyond, loaded, plays: !!player && player.offsetWidth > 0});
    frame.remove();
    look(pages.slice(1));
  };
  frame.src = pages[0];
  document.body.append(frame);
};
look(PAGES);
</script></body></html>
"""


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *words):
        pass


def pages_fit_a_phone_and_ask_nobody(site, tmp_path):
    names = [path.relative_to(site).as_posix() for path in pages(site)]
    (site / "probe.html").write_text(PROBE.replace("PAGES", json.dumps(names)), encoding="utf-8")
    handler = functools.partial(Quiet, directory=str(site))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        origin = f"http://127.0.0.1:{server.server_port}/"
        seen = browser.seen(f"{origin}probe.html", tmp_path)
        server.shutdown()
    (site / "probe.html").unlink()
    assert [one["page"] for one in seen] == names
    assert {one["page"]: one["beyond"] for one in seen if one["beyond"] > 0} == {}
    assert {url for one in seen for url in one["loaded"] if not url.startswith(origin)} == set()
    playing = {"index.html", "explanation/motion.html"}
    assert {one["page"] for one in seen if one["plays"]} == playing

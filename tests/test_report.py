"""Report: one self-contained page that says what the files of a run say."""

import base64
import html
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from beltrepro import report, store
from beltrepro.claims import load_ledger, measure
from beltrepro.report import gathering

# The smallest PNG there is: one pixel.
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)
FIGURES = ("fig01", *(f"fig{number:02d}" for number in range(6, 23)))
SETTINGS = {
    "preset": "smoke",
    "seed": 1,
    "model": {
        "static_friction": 71.4,
        "friction_ratio": 0.45,
        "rest_length": 50,
        "linear_limit": 20,
        "compression_rate": 0.2,
        "extension_rate": 0.01,
    },
    "numerics": {"laminar_time": 200.0, "section_rule": "the stated <rule> & no other"},
    "figures": {name: {"title": f"Title of {name}.", "uses": [["scans", "n5_rows"]]}
                for name in FIGURES},
}  # fmt: skip
VOID = {"meta", "img", "br", "link", "input", "hr"}


class Page(HTMLParser):
    """Collects tags, images and addresses, and checks that tags are closed in order."""

    def __init__(self, text):
        super().__init__()
        self.stack, self.images, self.addresses, self.identifiers, self.text = [], [], [], [], []
        self.feed(text)
        assert self.stack == []

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        if tag not in VOID:
            self.stack.append(tag)
        if tag == "img":
            self.images.append(attributes)
        if "id" in attributes:
            self.identifiers.append(attributes["id"])
        self.addresses += [attributes[key] for key in ("href", "src") if key in attributes]

    def handle_endtag(self, tag):
        assert self.stack.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def attributes(kind, **more):
    return {
        "kind": kind,
        "method": "verlet",
        "time_step": 0.001,
        "duration": 2000.0,
        "transient": 500.0,
        "seed": 1,
        "code_version": "0.1.0+gabc",
        "library_versions": json.dumps({"python": "3.11", "numpy": "2.4"}),
        "processor": "Some CPU",
        "config": json.dumps(more),
    }


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A rendered report of a tiny run: (text, page)."""
    tmp_path = tmp_path_factory.mktemp("run")
    scan = tmp_path / "scans" / "n5_rows.h5"
    arrays = {"noise": np.zeros(3), "energy_residual": np.array([1e-9, -3e-8, 0])}
    spans = {"n_blocks": [5], "belt_velocity": list(np.arange(1.0, 51)), "noise": [0, 1]}
    store.write(scan, arrays, attributes("scan", **spans))
    series = tmp_path / "series" / "u1.h5"
    store.write(series, {"time": np.zeros(7)}, attributes("series") | {"n_blocks": 5})
    claims = tmp_path / "claims.csv"
    measure({}, {}, {}, {}, SETTINGS).to_csv(claims, index=False)
    figures = {name: tmp_path / f"{name}.png" for name in FIGURES}
    for path in figures.values():
        path.write_bytes(PIXEL)
    benchmarks = tmp_path / "benchmarks"
    for place, seconds in (
        ("blocks/n5_rows/0000", 100),
        ("blocks/n5_rows/0001", 23),
        ("claims", 4),
    ):
        path = benchmarks / f"{place}.tsv"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"s\th:m:s\tmax_rss\tcpu_time\n{seconds}\t0:00:01\t{seconds}.5\t-\n")
    output = tmp_path / "report.html"
    report.render(output, figures, claims, [scan, series], benchmarks, "smoke", SETTINGS)
    text = output.read_text(encoding="utf-8")
    return text, Page(text)


def test_the_page_is_whole_and_needs_no_network(made):
    text, page = made
    assert [image["src"][:22] for image in page.images] == ["data:image/png;base64,"] * len(FIGURES)
    outside = {address for address in page.addresses if address.startswith("http")}
    assert outside == {"https://doi.org/10.1103/PhysRevE.87.042920"}
    assert not re.search(r"<(link|iframe|script src)|@import|url\(", text)
    inside = {address[1:] for address in page.addresses if address.startswith("#")}
    assert inside <= set(page.identifiers)
    assert len(page.identifiers) == len(set(page.identifiers))


def test_every_claim_and_figure_is_there(made):
    text, page = made
    assert set(load_ledger()) | set(FIGURES) <= set(page.identifiers)
    assert all(len(image["alt"]) > 20 for image in page.images)
    words = html.unescape(text)
    assert all(claim.statement in words for claim in load_ledger().values())


def test_the_verdict_line_counts_the_table(made):
    text, _ = made
    counted = re.findall(r'<tr id="[^"]*" data-verdict="([^"]*)"', text)
    assert len(counted) == len(load_ledger())
    assert f"<strong>{counted.count('holds')} hold</strong>" in text
    assert f"{counted.count('not measured')} are not measured" in " ".join(text.split())


def test_numbers_come_from_the_files(made):
    _, page = made
    words = " ".join(" ".join(page.text).split())
    assert "3 points" in words
    assert "1 to 50 (50)" in words
    assert "3.0e-08" in words
    assert "7 samples" in words
    assert "0.1.0+gabc" in words
    assert "Some CPU" in words
    assert "2 min 03 s" in words
    assert "100 MB" in words
    assert "the stated <rule> & no other" in words
    assert "t = 2000, of which 500 discarded" in words


def test_a_report_without_benchmarks_says_so(tmp_path):
    claims = tmp_path / "claims.csv"
    measure({}, {}, {}, {}, SETTINGS).to_csv(claims, index=False)
    output = tmp_path / "report.html"
    report.render(output, {}, claims, [], tmp_path / "none", "smoke", SETTINGS)
    assert "No benchmark files were found" in output.read_text(encoding="utf-8")


def test_figures_and_open_points_have_words():
    content = gathering.read_content()
    assert set(content["figures"]) == set(FIGURES)
    for words in content["figures"].values():
        assert set(words) == {"paper", "alt"}
    for row in content["deviations"]:
        assert set(row) == {"what", "paper", "ours", "where", "why"}


def test_runs_at_the_lengths_of_the_paper_are_no_deviation():
    paper = {"kind": "scan", "name": "scans/a", "duration": "2e6", "transient": "1e6"}
    rows = gathering.deviations({"deviations": []}, [paper | {"method": "verlet"}])
    assert rows == []
    rows = gathering.deviations({"deviations": []}, [paper | {"method": "event"}])
    assert [row["what"] for row in rows] == ["Integrator"]


def test_benchmarks_are_summed_by_rule(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "1.tsv").write_text("s\tmax_rss\n1.5\t10\n2.5\t-\n")
    (rows,) = gathering.read_benchmarks(tmp_path)
    assert rows == {"rule": "a", "jobs": 2, "seconds": 4.0, "longest": 2.5, "memory_mb": 10.0}

"""The page: whole, without network, fit for readers, and each section says what its files say."""

import base64
import html
import io
import itertools
import json
import re

import html5lib
import numpy as np
import pytest
from PIL import Image

import browser
import pages
from beltrepro.base import store
from beltrepro.replication.plan import registry
from beltrepro.replication.report import findings as findings_module
from beltrepro.replication.report import material, sections
from beltrepro.replication.report.claim_results import count, read, statements
from beltrepro.replication.report.findings import findings_of
from beltrepro.replication.report.material import WORDS
from beltrepro.replication.verdicts.criteria import range_in_words
from beltrepro.replication.verdicts.ledger import SECTIONS, load_ledger, read_yaml
from irregular import grid
from pages import SYMBOLS, badges, cards, cells, part, plain, typeset, words

FIGURES = registry.figures()


def datasets(folder):
    """A scan by the paper's scheme, and a catalogue by the exact integrator."""
    usual = {"duration": 2000.0, "transient": 500.0, "code_version": "0.1.0+gabc"}
    usual |= {"library_versions": json.dumps({"python": "3.11", "numpy": "2.4"})}
    scan = grid(n_blocks=[5], noise=[0, 1], belt_velocity=np.arange(1.0, 61, 2), seed=[1])
    scan |= {"time_step": np.full(60, 0.001), "energy_residual": np.resize([1e-9, -3e-8], 60)}
    slips = grid(n_blocks=[2, 3], belt_velocity=[1.0], noise=[0], time_step=[0.001])
    slips |= {"seed": np.array([1, 3])}
    slips |= {name: np.zeros(size) for name, size in {"slips": 19, "avalanches": 17}.items()}
    for name, arrays, about in (
        ("n5_rows", scan, {"kind": "scan", "method": "verlet"}),
        ("slips_u1", slips, {"kind": "catalogue", "method": "event", "duration": 3000.0}),
    ):
        store.write(folder / f"{name}.h5", arrays, usual | about | {"dataset": name})
    return [folder / "n5_rows.h5", folder / "slips_u1.h5"]


def benchmarks(folder):
    """Two jobs of one rule, one of another, so short that its memory is not known."""
    rows = {"batches/n5_rows/0000": "100\t-\t250.4", "batches/n5_rows/0001": "23\t-\t99"}
    for place, row in (rows | {"claims": "4\t-\t-"}).items():
        path = folder / "benchmarks" / f"{place}.tsv"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"s\th:m:s\tmax_rss\n{row}\n")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The claims of a made-up run, and the page about it."""
    folder = tmp_path_factory.mktemp("run")
    benchmarks(folder)
    made = pages.material(folder, datasets=datasets(folder))
    return read(folder), pages.written(folder, made)


@pytest.fixture(scope="module")
def text(run):
    return run[1]


@pytest.fixture(scope="module")
def results(run):
    return run[0]


# --- the page -------------------------------------------------------------------------------------


def test_the_page_is_valid_whole_and_needs_no_network(text):
    parser = html5lib.HTMLParser()
    parser.parse(text)
    assert parser.errors == []
    markup = re.sub(r"<script>.*?</script>", "", text, flags=re.S)
    addresses = set(re.findall(r'\b(?:href|src)="(?!data:)(.*?)"', markup))
    outside = {address for address in addresses if not address.startswith("#")}
    beside = {"claims.csv", "estimates.csv", *(f"figures/{name}.png" for name in FIGURES)}
    assert outside - beside == {"https://doi.org/10.1103/PhysRevE.87.042920"}
    assert not re.search(r"<(link|iframe|script src)|@import|url\(", text)
    identifiers = re.findall(r'\bid="(.*?)"', markup)
    assert {address[1:] for address in addresses - outside} <= set(identifiers)
    assert len(identifiers) == len(set(identifiers))
    levels = [int(level) for level in re.findall(r"<h([1-6])[ >]", text)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after <= before + 1 for before, after in itertools.pairwise(levels))


def test_sections_stand_in_their_order(text, tmp_path):
    expected = {"model": "The model, and what the paper says", "summary": "What was found"}
    expected["motion"] = "The chain, live"
    for study in WORDS["studies"]:
        about = read_yaml(sections.STUDIES, f"{study}/words.yaml")["section"]
        expected[f"on-{study}"] = about["title"]
        for paragraph in about["paragraphs"]:
            assert "{" in paragraph or plain(paragraph) in words(part(text, f"on-{study}"))
    expected["made"] = "How it was made"
    assert re.findall(r'<section id="([\w-]+)"', text) == list(expected)
    (contents,) = re.findall(r'<nav class="contents".*?>(.*?)</nav>', text, re.S)
    assert re.findall(r'<a href="#(.*?)">(.*?)</a>', contents) == list(expected.items())
    assert {*WORDS["studies"]} == {*SECTIONS.values()}
    fewer = pages.written(tmp_path, pages.material(tmp_path, figures=["fig12"]))
    assert set(cards(fewer)) == set(load_ledger())
    assert "No benchmark files were found" in fewer


@pytest.mark.skipif(not browser.BROWSER, reason="no browser here")
@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 768, 1300])
def test_the_page_is_as_wide_as_the_screen(text, tmp_path, width):
    page = browser.widths(text, tmp_path, width)
    assert page["out"] == [] and page["needed"] == page["asked"] > 0.9 * width
    wide = text.replace("<main>", '<main><div style="width: 90rem">wide</div>')
    page = browser.widths(wide, tmp_path, width)
    assert page["needed"] > page["asked"] and "wide" in page["out"][0]


@pytest.mark.skipif(not browser.BROWSER, reason="no browser here")
@pytest.mark.slow
def test_the_page_passes_the_accessibility_check(text, tmp_path):
    assert browser.violations(text, tmp_path) == []
    page = text.replace("<main>", '<main><p style="color: #ddd">pale</p>')
    assert [fault["rule"] for fault in browser.violations(page, tmp_path)] == ["color-contrast"]


# --- the first screen -----------------------------------------------------------------------------


def test_the_first_screen_counts_statements_runs_and_criteria(text, results):
    first, made = words(part(text, "summary")), statements(results)
    seen = [one.claim.seen for one in made if one.claim.testable]
    # frames of a film, of which a test of our camera counts thousands, are no runs
    judged = [number for one in made for answer in one.answers.values() for number in answer.judged]
    runs = sorted(number.estimate.runs for number in judged if number.estimate.runs)
    for said in (
        f"{len(made)} statements that could come out otherwise; {len(seen)} can be tested",
        "rest on last t = 40000, those of the paper t = 2e6.",
        f"{runs[(len(runs) - 1) // 2]} independent runs (median; {runs[0]} to {runs[-1]})",
        f"{'All' if {*seen} == {'the published run'} else 'of'} {len(seen)} criteria were written",
    ):
        assert said in first
    buttons = re.findall(r'data-show="(.+?)" data-verdict="(.+?)" .*?>(.*?)</button>', text)
    for question, verdicts in count(results).items():
        numbers = {name: number for name, number in verdicts.items() if number}
        assert [button[1:] for button in buttons if button[0] == question] == [
            (name, f"{name} {number}") for name, number in numbers.items()
        ]


def test_the_first_screen_tells_what_holds_in_this_run_and_what_does_not(tmp_path):
    refused = ("slip-size-exponent", "slip-energy-exponent", "soc-power-law", "one-over-f")
    wanted = {name: {"replicated": "yes", "robust": "no"} for name in refused}
    run = pages.material(tmp_path, verdicts=dict.fromkeys(load_ledger(), "yes") | wanted)
    first, findings = part(pages.written(tmp_path, run), "summary"), findings_of(run.claims)
    held = [finding for finding in findings if not finding.unmet]
    listed = re.findall(r"<li><p>(.*?)(?: <a .*?)?</p>", first, re.S)
    assert [words(one) for one in listed] == [plain(finding.text) for finding in held] != []
    assert len(held) < len(findings)
    assert f"{'; '.join(one.topic for one in findings if one.unmet)}." in words(first)
    rows = [[*row] for row in findings_module.printed_and_measured(run.claims)]
    assert cells(first)[1:] == rows != []


def test_the_paragraphs_on_why_r_falls_have_their_first_sentence_in_bold(tmp_path):
    wanted = {"orbits-met": {"replicated": "no", "robust": "no"}}
    run = pages.material(tmp_path, verdicts=dict.fromkeys(load_ledger(), "yes") | wanted)
    section, made = part(pages.written(tmp_path, run), "on-fall"), findings_of(run.claims, "fall")
    held = [one for one in made if not one.unmet]
    assert len(made) == 6 and "Which orbits end the motion" not in [one.topic for one in held] != []
    bold = re.findall(r"<p><strong>(.*?)</strong> (.*?) <a .*?</p>", section, re.S)
    assert [words(" ".join(one)) for one in bold] == [plain(one.text) for one in held]
    assert f"{'; '.join(one.topic for one in made if one.unmet)}." in words(section)


# --- claims and figures ---------------------------------------------------------------------------


def decided(answer):
    """The numbers that decide, with the ranges that are allowed."""
    return plain("; ".join(
        f"{one.name}: {range_in_words(one.allowed)} {SYMBOLS[one.verdict]}" for one in answer.judged
    ))  # fmt: skip


def test_each_claim_stands_once_and_says_what_its_rows_say(text, results):
    listed = re.findall(r'<article class="claim [a-z-]+" id="(.*?)"', text)
    assert sorted(listed) == sorted(results)
    for name, markup in cards(text).items():
        result, said = results[name], words(markup)
        claim = result.claim
        shown = dict(re.findall(r'data-(\w+)="(.*?)"', markup.partition(">")[0]))
        assert shown == (result.verdicts if claim.finding else {})
        assert said.startswith(f"{plain(claim.statement)} {badges(result)}")
        asked = result.answers if claim.finding else {"replicated": result.answers["replicated"]}
        for answer in asked.values():
            assert plain(answer.found)[1:] in typeset(said)
            assert claim.kind == "construction" or decided(answer) in said
        if claim.replicated.tried > 1 and result.answers["replicated"].judged:
            assert f"({claim.replicated.tried} readings)" in said


def test_figures_have_their_claims_and_link_to_their_files(text, results):
    drawn = re.findall(r'<figure class="figure group" id="(.*?)">', text)
    assert sorted(drawn) == sorted(FIGURES)
    for name, entry in FIGURES.items():
        markup = pages.picture(text, name)
        assert f'<a href="figures/{name}.png">' in markup
        encoded = base64.b64decode(re.search(r'image/webp;base64,(.*?)"', markup)[1])
        assert Image.open(io.BytesIO(encoded)).size == (1, 1)
        assert html.unescape(re.search(r'alt="(.*?)"', markup)[1]) == entry.alt
        assert f"{entry.title} {entry.words}" in words(markup)
        on_it = [one for one, result in results.items()
                 if entry.number and str(result.claim.figure) == entry.number]  # fmt: skip
        assert re.findall(r'class="claim [a-z-]+" id="(.*?)"', markup) == on_it


def test_a_picture_is_at_most_as_wide_as_a_screen(tmp_path):
    Image.new("RGB", (2000, 900), "white").save(tmp_path / "fig12.png")
    made = material._at_screen_size(tmp_path / "fig12.png")
    assert (made["width"], made["height"]) == (1000, 450)


# --- what was run ---------------------------------------------------------------------------------


def test_how_it_was_made_has_a_row_for_each_rule_and_the_facts(text):
    made = part(text, "made")
    _, _, times = (cells(table) for table in re.findall(r"<table>.*?</table>", made, re.S))
    assert times[1:] == [
        ["batches", "2", "0:02:03", "0:01:40", "250 MB"],
        ["claims", "1", "0:00:04", "0:00:04", ""],
        ["sum", "3", "0:02:07", "", ""],
    ]
    facts = dict(re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", made))
    assert facts["Energy balance"] == "of each run it closes within 3.0e-08 of the belt's work"
    assert (facts["Seed"], facts["Libraries"]) == ("1; 1, 3", "python 3.11, numpy 2.4")

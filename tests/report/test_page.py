"""The page: whole, without network, fit for readers, and each section says what its files say."""

import base64
import dataclasses
import html
import itertools
import json
import re
from pathlib import Path

import html5lib
import numpy as np
import pandas as pd
import pytest

import browser
import made_up_results
import pages
from alternating import studies
from beltrepro.base import store
from beltrepro.replication.plan import registry
from beltrepro.replication.report import conduct, judged, page, trust
from beltrepro.replication.report.claim_results import count, read_tables
from beltrepro.replication.report.contents import SECTIONS, SUMMARY
from beltrepro.replication.report.findings import findings_of
from beltrepro.replication.report.material import captions
from beltrepro.replication.verdicts.criteria import QUESTIONS, range_in_words
from beltrepro.replication.verdicts.ledger import load_ledger
from pages import PIXEL, badge, badges, cards, cells, part, plain, typeset, words

FIGURES = registry.figures()
OTHERWISE = {"r-jump": "yes", "u-critical": "no"}  # in the run that it is compared with
PARTS = {
    "motion": "The chain, live",
    "summary": "What was found",
    "figures": "Figures",
    "claims": "Claims",
    "dates": "When it was judged",
    "open_points": "What the paper leaves open",
    "presets": "Other presets",
    "deviations": "Deviations from the paper",
    "runs": "What was run",
    "times": "Time per rule",
    "environment": "Environment",
}
OF_STUDIES = ["chaos", "trials", "experiment", "integrators"]  # need their tables
MINUS = "\u2212"


def attributes(kind, **others):
    about = {"kind": kind, "method": "verlet", "duration": 2000.0, "transient": 500.0}
    about |= {"code_version": "0.1.0+gabc", "processor": "Some CPU"}
    return about | {"library_versions": json.dumps({"python": "3.11", "numpy": "2.4"})} | others


def points(n_blocks, belt_velocity, noise, *, seed=1, time_step=0.001):
    columns = {"n_blocks": n_blocks, "belt_velocity": belt_velocity, "noise": noise}
    columns |= {"seed": [seed] * len(n_blocks), "time_step": [time_step] * len(n_blocks)}
    return {name: np.array(values) for name, values in columns.items()}


def datasets(folder):
    """A scan, a series, a catalogue and lifetimes, with different sizes and parameters."""
    tables = {"slips": 19, "avalanches": 17, "section": 13}
    tables = {name: np.zeros(count, [("block", "i4")]) for name, count in tables.items()}
    residual = np.append(np.zeros(58), [1e-9, -3e-8])
    made = {
        "n5_rows": (
            points([5] * 60, np.arange(1.0, 61), [0, 1] * 30) | {"energy_residual": residual},
            attributes("scan"),
        ),
        "u1": (
            points([6], [17.5], [2.2], seed=3) | {"time": np.zeros(7), "events": np.zeros(4)},
            attributes("series"),
        ),
        "slips_u1": (
            points([2, 3], [1.0, 1.0], [0, 0]) | tables,
            attributes("catalogue", duration=3000.0, transient=0.0),
        ),
        "lifetimes": (
            points([4] * 3, [18.0, 24.0, 30.0], [0.5] * 3, time_step=0.002)
            | {"energy_residual": np.array([0, 2e-5, np.nan])},
            attributes("escapes", method="event"),
        ),
    }
    for name, (arrays, about) in made.items():
        store.write(folder / f"{name}.h5", arrays, about | {"dataset": name})
    return [folder / f"{name}.h5" for name in made]


def benchmarks(folder):
    """Two jobs of one rule, one of another; the first has the most memory."""
    for place, seconds, memory in (
        ("batches/n5_rows/0000", 100, 250),
        ("batches/n5_rows/0001", 23, 99),
        ("claims", 4, 61),
    ):
        path = folder / "benchmarks" / f"{place}.tsv"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"s\th:m:s\tmax_rss\n{seconds}\t0:00:01\t{memory}.4\n")


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    """The page of a made-up run beside another one."""
    folder = tmp_path_factory.mktemp("run")
    other, _ = made_up_results.write(folder / "paper", OTHERWISE)
    benchmarks(folder)
    run = pages.material(folder, datasets=datasets(folder), compared=[other])
    return pages.written(folder, run)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The claims on that page."""
    return read_tables(*made_up_results.write(tmp_path_factory.mktemp("claims")))


# --- the page -------------------------------------------------------------------------------------


def test_the_page_is_whole_and_needs_no_network(text):
    images = re.findall(r"<img [^>]*>", text)
    assert len(images) == len(FIGURES)
    for image in images:
        assert 'src="data:image/png;base64,' in image and re.search(r'alt="[^"]*\w', image)
    markup = re.sub(r"<script>.*?</script>", "", text, flags=re.S)
    addresses = set(re.findall(r'\b(?:href|src)="(?!data:)(.*?)"', markup))
    outside = {address for address in addresses if not address.startswith("#")}
    assert outside == {"https://doi.org/10.1103/PhysRevE.87.042920"}
    assert not re.search(r"<(link|iframe|script src)|@import|url\(", text)
    identifiers = re.findall(r'\bid="(.*?)"', markup)
    assert {address[1:] for address in addresses - outside} <= set(identifiers)
    assert len(identifiers) == len(set(identifiers))


def test_sections_stand_in_their_order_and_in_the_contents(text):
    assert re.findall(r'<section id="(\w+)"', text) == list(PARTS)
    titles = re.findall(r"<h2>(.*?)</h2>", text)
    assert titles == [title for name, title in PARTS.items() if name != "motion"]
    (contents,) = re.findall(r'<nav class="contents".*?>(.*?)</nav>', text, re.S)
    assert re.findall(r'<a href="#(.*?)">(.*?)</a>', contents) == list(PARTS.items())
    templates = [section.template for section in (SUMMARY, *SECTIONS)]
    assert sorted(templates) == sorted([*PARTS, *OF_STUDIES])
    templates = {path.name for path in (Path(judged.__file__).parent / "templates").iterdir()}
    used = {f"{section.template}.html.j2" for section in (SUMMARY, *SECTIONS)}
    assert templates == used | {"page.html.j2", "macros.html.j2"}


def test_a_section_without_its_files_is_left_out(tmp_path):
    run = pages.material(tmp_path)
    text = pages.written(tmp_path, dataclasses.replace(run, files=run.files | {"figures": []}))
    assert "No benchmark files were found" in text
    anchors = re.findall(r'<section id="(.*?)">', text)
    assert "claims" in anchors and "figures" not in anchors


def test_the_page_is_valid_html_and_headings_leave_no_level_out(text):
    parser = html5lib.HTMLParser()
    parser.parse(text)
    assert parser.errors == []
    levels = [int(level) for level in re.findall(r"<h([1-6])[ >]", text)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after <= before + 1 for before, after in itertools.pairwise(levels))


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


def summary(text):
    (markup,) = re.findall(r'<section id="summary".*?>(.*?)</section>', text, re.S)
    return markup


def test_the_first_screen_counts_the_claims_by_question(text, results):
    counts, first = count(results), summary(text)
    assert (
        f"Of {counts.total} statements that could come out otherwise, {counts.testable} can be "
        "tested by simulation; the others are about recordings that are not published. Counted "
        f"apart: {counts.apart['validation']} tests of our own camera, "
        f"{counts.apart['construction']} statements that are true because the model is built so, "
        f"and {counts.apart['explanation']} of ours on why r falls."
    ) in words(first)
    tallies = re.findall(r'<div class="tally"><strong>(\w+)</strong>(.*?)</div>', first, re.S)
    bars = re.findall(r'<div class="bar" aria-hidden="true">(.*?)</div>', first, re.S)
    buttons = re.findall(
        r'data-show="(.+?)" data-verdict="(.+?)" aria-pressed="false">(.*?)</button>', text
    )
    for (title, tally), bar, question in zip(tallies, bars, QUESTIONS, strict=True):
        numbers = {name: n for name, n in counts.verdicts[question].items() if n}
        assert title == question.capitalize()
        listed = [words(item) for item in re.findall(r"<li>(.*?)</li>", tally, re.S)]
        assert listed == [f"{badge(name)} {number}" for name, number in numbers.items()]
        widths = re.findall(r'<span class="([a-z-]*)" style="flex: (\d+)">', bar)
        assert widths == [(name.replace(" ", "-"), str(n)) for name, n in numbers.items()]
        assert [button[1:] for button in buttons if button[0] == question] == [
            (name, f"{name} {number}") for name, number in numbers.items()
        ]
    assert f'data-show="" aria-pressed="true">all {len(results)}</button>' in text


def test_the_first_screen_tells_what_holds_in_this_run_and_what_does_not(tmp_path):
    entries = findings_of(read_tables(*made_up_results.write(tmp_path / "a")))
    wanted = {}
    for result in (result for finding in entries for result in finding.results):
        wanted[result.id] = {"replicated": "yes", "robust": "no"}
    run = pages.material(tmp_path / "b", verdicts=dict.fromkeys(load_ledger(), "yes") | wanted)
    first, findings = summary(pages.written(tmp_path, run)), findings_of(run.claims)
    held = [finding for finding in findings if not finding.unmet]
    listed = re.findall(r"<li>\s*<p>(.*?)</p>", first, re.S)
    assert [words(one) for one in listed] == [plain(finding.text) for finding in held]
    for finding in findings:
        if finding.unmet:
            assert plain(f"{finding.topic}: {'; '.join(finding.unmet)}.") in words(first)
        else:
            assert {result.id for result in finding.results} <= set(
                re.findall(r'href="#([^"]*)">', first)
            )


def test_the_first_screen_says_how_far_to_trust_the_run(text, results):
    first = words(summary(text))
    assert trust.dates(results) in first
    for question in QUESTIONS:
        assert f"of the same statements as {question}: " in first


# --- claims and figures ---------------------------------------------------------------------------


def allowed(number, criterion):
    """The range of a number, and how far a lenient reader would go."""
    if number.name not in criterion.lenient:
        return number.allowed_words
    wider = range_in_words(criterion.lenient[number.name])
    return f"{number.allowed_words} (leniently {wider})"


def test_each_claim_says_what_its_rows_say(text, results):
    assert set(cards(text)) == set(results)
    for name, markup in cards(text).items():
        result, said = results[name], words(markup)
        claim = result.claim
        shown = dict(re.findall(r'data-(\w+)="(.*?)"', markup.partition(">")[0]))
        assert shown == (result.verdicts if claim.finding else {})
        assert said.startswith(f"{name} {badges(result)}")
        for one in (claim.says, claim.statement, result.note):
            assert plain(one)[1:] in typeset(said)
        asked = result.answers if claim.finding else {"replicated": result.answers["replicated"]}
        assert [row for row in cells(markup) if row[0] != "Number"] == [
            [plain(cell) for cell in (n.name, n.words, allowed(n, claim.criteria[question]),
                                      badge(n.verdict))]
            for question, answer in asked.items() if claim.testable for n in answer.judged
        ]  # fmt: skip
        for answer in asked.values():
            for one in (answer.found, answer.how * claim.testable):
                assert plain(one)[1:] in typeset(said)
            if answer.found and answer.tried != "1":
                assert f"This reading was found by trying {answer.tried}." in said
        for reading, numbers in result.readings.items():
            assert plain(reading)[1:] in typeset(said)
            for number in numbers.values():
                assert plain(f"{number.name}: {number.words}") in typeset(said)
        for change in claim.history * claim.testable:
            assert f"{change.date}, {change.seen}" in said


def test_claims_and_figures_point_at_each_other(text, results):
    numbered = {entry.number: name for name, entry in FIGURES.items() if entry.number}
    for name, result in results.items():
        links = re.findall(r'<a href="#(.*?)">', cards(text)[name])
        number = str(result.claim.figure or "")
        of_paper = [numbered[number]] if number else []
        assert links[: len(of_paper)] == of_paper
        assert sorted({*links}) == sorted({*of_paper, *result.figures})
        shown = {figure for figure, entry in FIGURES.items() for key in entry.shows
                 if key.partition(": ")[0] == name}  # fmt: skip
        assert set(result.figures) <= shown
    assert any(result.figures for result in results.values())
    for number, name in numbered.items():
        markup = pages.picture(text, name)
        claims = [r for r in results.values() if str(r.claim.figure) == number]
        assert ("What we find." in words(markup)) == bool(claims)
        assert ("What the paper says." in words(markup)) == any(r.claim.says for r in claims)
        for result in claims:
            assert f"{result.id} {badges(result)}" in words(markup)
            for one in (result.claim.says, result.answers["replicated"].found[1:]):
                assert plain(one) in typeset(words(markup))


def test_claims_that_are_counted_apart_stand_apart(text, results):
    groups = re.split(r'<div class="group">', part(text, "claims"))[1:]
    titles = [words(re.search("<h3>(.*?)</h3>", group, re.S)[1]) for group in groups]
    places = [r.claim.section if r.claim.finding else r.claim.kind for r in results.values()]
    expected = [title for place, title in judged.WORDS["groups"].items() if place in places]
    assert titles == expected
    for group, kind in zip(groups[-2:], ("construction", "explanation"), strict=True):
        built = set(re.findall(r'class="claim [a-z-]+" id="(.*?)"', group))
        assert built == {name for name, r in results.items() if r.claim.kind == kind}


def test_figures_have_their_own_picture_and_words_in_the_order_of_the_paper(text):
    assert re.findall(r'<article class="figure" id="(.*?)">', text) == list(FIGURES)
    for name, entry in FIGURES.items():
        markup = pages.picture(text, name)
        assert base64.b64decode(re.search(r'base64,(.*?)"', markup)[1]) == PIXEL + name.encode()
        assert html.unescape(re.search(r'alt="(.*?)"', markup)[1]) == entry.alt
        said = words(markup)
        heading = f"Figure {entry.number}. {entry.title}" if entry.number else entry.title
        assert f"{heading} {entry.words}" in said
        assert ("The paper's caption , in our words:" in said) == bool(entry.number)
        assert plain(captions().get(entry.number, "")) in said
        assert (f"Drawn from {', '.join(entry.uses)}." in said) == bool(entry.uses)


# --- readings and other runs ----------------------------------------------------------------------


def test_open_points_are_those_of_the_model_and_of_the_claims(text, results):
    section = part(text, "open_points")
    for point in judged.WORDS["model"]:
        assert f"Left open {point['open']} Reading {point['reading']}" in words(section)
    listed = dict(re.findall(r'<li><a href="#(.*?)">.*?</a>: (.*?)</li>', section, re.S))
    assert list(listed) == [result.id for result in results.values() if result.claim.open]
    for name, one in listed.items():
        assert plain(results[name].claim.open)[1:] in plain(words(one))


def test_criteria_from_after_the_published_run_are_listed(text, results):
    section = part(text, "dates")
    assert trust.dates(results) in words(section)
    expected = [
        (result.id, str(change.date), change.what)
        for result in results.values() if result.claim.finding and result.claim.testable
        for change in result.claim.history if change.seen == "the published run"
    ]  # fmt: skip
    rows = cells(section)[1:]
    assert [tuple(row[:2]) for row in rows] == [row[:2] for row in expected] != []
    assert all(
        " ".join(what.split())[1:] in row[2] for row, (*_, what) in zip(rows, expected, strict=True)
    )


def test_other_runs_are_compared(text, results, tmp_path):
    other = read_tables(*made_up_results.write(tmp_path, OTHERWISE))
    decided = {"yes", "no", "in part"}
    section, expected = part(text, "presets"), []
    for question in QUESTIONS:
        answers = {name: (r.answers[question], other[name].answers[question])
                   for name, r in results.items() if r.claim.finding}  # fmt: skip
        pairs = {name: (one.verdict, two.verdict)
                 for name, (one, two) in answers.items() if one.reading == two.reading}  # fmt: skip
        pairs = {name: pair for name, pair in pairs.items() if decided >= {*pair}}
        expected += [[name, question, *map(badge, pair)]
                     for name, pair in pairs.items() if pair[0] != pair[1]]  # fmt: skip
        alike = sum(one == two for one, two in pairs.values())
        said = f"{question.capitalize()}: both runs decide {len(pairs)} statements, {alike} of them"
        assert said in words(section)
    assert cells(section)[1:] == expected != []


# --- what was run ---------------------------------------------------------------------------------


def test_what_was_run_has_a_row_for_each_dataset(text):
    assert cells(part(text, "runs"))[1:] == [
        ["n5_rows", "verlet", "5", "1 to 60 (60)", "0, 1", "2000", "500", "60 points", "3.0e-08"],
        ["u1", "verlet", "6", "17.5", "2.2", "2000", "500", "1 point, 7 samples, 4 events", ""],
        ["slips_u1", "verlet", "2, 3", "1", "0", "3000", "0",
         "2 points, 19 slips, 17 avalanches, 13 section points", ""],
        ["lifetimes", "event", "4", "18, 24, 30", "0.5", "2000", "500", "3 points", "2.0e-05"],
    ]  # fmt: skip


def test_deviations_are_those_of_the_run_and_the_general_ones(text):
    rows = cells(part(text, "deviations"))[1:]
    lengths, integrator, *general = rows
    assert lengths[:4] == ["Length of the runs", "t = 2e6, of which 1e6 discarded",
                           "t = 2000, of which 500 discarded", "n5_rows"]  # fmt: skip
    assert (integrator[0], integrator[3]) == ("Integrator", "lifetimes")
    assert general == [list(map(row.get, ("what", "paper", "ours", "where", "why")))
                       for row in conduct.WORDS["deviations"]]  # fmt: skip
    scan = {"kind": "scan", "name": "a", "duration": "2e6", "transient": "1e6", "method": "verlet"}
    assert conduct.deviations_of_run([scan]) == []
    rows = conduct.deviations_of_run(
        [scan, scan | {"transient": "0"}, scan | {"name": "b", "duration": "1e6"}]
    )
    assert [(row["ours"], row["where"]) for row in rows] == [
        ("t = 1e6, of which 1e6 discarded", "b"), ("t = 2e6, of which 0 discarded", "a")
    ]  # fmt: skip


def test_time_is_summed_by_rule(text, tmp_path):
    assert cells(part(text, "times"))[1:] == [
        ["simulate batches", "2", "2 min 03 s", "1 min 40 s", "250 MB"],
        ["measure claims", "1", "4.0 s", "4.0 s", "61 MB"],
        ["sum", "3", "2 min 07 s", "", ""],
    ]
    (tmp_path / "benchmarks" / "a").mkdir(parents=True)
    table = tmp_path / "benchmarks" / "a" / "1.tsv"
    # of a short job there is no memory
    table.write_text("s\tmax_rss\n1.5\t90\n2.5\t-\n0.5\t100\n")
    (tmp_path / "benchmarks" / "b.tsv").write_text("s\tmax_rss\n0.25\t-\n")
    assert conduct.times(pages.material(tmp_path))["rules"] == [
        {"rule": "a", "jobs": 3, "seconds": 4.5, "longest": 2.5, "memory_mb": 100.0},
        {"rule": "b", "jobs": 1, "seconds": 0.25, "longest": 0.25, "memory_mb": 0.0},
    ]


def test_environment_lists_what_differs(text):
    rows = re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", part(text, "environment"))
    facts = {name: html.unescape(value) for name, value in rows}
    assert facts.pop("Cores").endswith("on the machine that wrote this page")
    assert facts == {
        "Code": "0.1.0+gabc",
        "Libraries": "python 3.11, numpy 2.4",
        "Processor": "Some CPU",
        "Seed": "1; 3",
        "Time step": "0.001; 0.002",
        "Preset": "smoke",
        "Constants": "static_friction = 71.4, friction_ratio = 0.45",
        "Laminar phase": "longer than 213",
    }


# --- studies -------------------------------------------------------------------------------


def written_with(folder, **tables):
    """The page of a run that also has these tables."""
    for name, table in tables.items():
        table.to_csv(folder / f"{name}.csv", index=False)
    paths = {name: [folder / f"{name}.csv"] for name in tables}
    text = pages.written(folder, pages.material(folder, figures=["fig12"], **paths))
    assert not re.search(r"\bnan\b", words(text))
    return text


def test_the_section_on_chaos_counts_what_the_tables_have(tmp_path):
    motions = pd.DataFrame({
        "n_blocks": [2, 5, 5, 5, 7, 7, 10], "belt_velocity": [9.0, 9, 14, 30, 9, 14, 9],
        "runs": 8, "periodic": [8, 4, 6, 8, 0, 1, 2], "quasi-periodic": 0,
        "chaotic": [0, 0, 1, 0, 5, 7, 6], "transient": [0, 4, 1, 0, 3, 0, 0],
        "exponent": [0, 1e-3, 4e-3, 0, 0.012, 0.015, 0.02], "error": 2e-4,
        "longest_period": [12, 90, 40, 7, 0, 300, 0],
        "r_periodic": [0.1, 0.10, 0.10, 0.10, np.nan, 0.1, 0.1],
        "r_irregular": [np.nan, 0.12, 0.13, 0.90, 0.1, 0.11, np.nan],
    })  # fmt: skip
    lifetimes = pd.DataFrame({
        "n_blocks": [5, 5, 5, 7], "belt_velocity": [9.0, 14, 9, 9], "initial_spread": 1.0,
        "runs": [16, 16, 4, 9], "settled": [16, 12, 3, 2], "lifetime": [1e4, np.inf, 2345.6, 7e5],
        "lifetime_lower": [8e3, 1e6, 1e3, 5e5], "lifetime_upper": [12e3, np.inf, 4e3, 9e5],
        "exponent": [2e-3, 5e-4, 1e-3, 0.01], "exponent_error": [1e-4, 2e-4, 4e-4, 1e-3],
        "verdict": ["ends", "lasts", "ends", "ends"], "attractor": "periodic",
        "attractor_events": [18, 0, 57, 5],
    })  # fmt: skip
    noisy = pd.DataFrame({"belt_velocity": 9.0, "noise": [0.1, 1.0, 5.0],
                          "exponent": [2.9e-3, 3.1e-3, -0.02], "error": 1e-3})  # fmt: skip
    tables = {"motions": motions, "mean_lifetimes": lifetimes, "noisy_motions": noisy}
    section = part(written_with(tmp_path, **tables), "chaos")
    said, rows = words(section), cells(section)
    assert "From N = 7 on, at least half of the runs are chaotic." in said
    assert "No run is chaotic for N = 2 ." in said or "No run is chaotic for N = 2." in said
    assert rows[2] == ["5", "24", "18", "0", "1", "5", "14", "0.004 ± 0.0002", "14", "90"]
    # of two rows of one point the later one counts; 0.001 is below three times its error
    assert "15 of 20 runs from spread starts settled" in said and "(75%)" in said
    assert "Some runs were still irregular at u = 9, 14." in said
    assert "above zero at 0 of 2 points" in said and "N = 7: 2 of 9 runs settled" in said
    assert "u = 9, σ = 0.1, 1, 5: λ 1 is between -0.02 and 0.0031" in said
    assert "It is above zero at σ = 1." in said
    assert "At 3 points with u ≤ 15" in said and "by 20% (median), and by 30% at most" in typeset(
        said
    )
    assert rows[-1][:5] == ["9", "1", "3 of 4", "2.35e+03", "1e+03 to 4e+03"]


def test_the_section_on_the_trials_says_what_the_tables_do(tmp_path):
    tables = studies(runs=16)
    names = ("experiment_odds", "alternation")
    shares = tables["alternation"]
    first, second, *_ = shares.index[(shares["noise"] == 1) & (shares["friction_ratio"] == 0.45)]
    shares.loc[[first, second], "share"] = 0.5, 0.49
    section = part(written_with(tmp_path, **{name: tables[name] for name in names}), "trials")
    said, table = words(section), cells(section)
    assert "No trial agrees with its recording in r (within 10%) and in its regimes" in said
    assert "all blocks slip at once for longer than 0.61 s" in said
    assert "slip for a minute in 0 of 512 trials, and for 0.61 s at most" in said
    # 64 trials at each speed: none of 64 has r as low, so that at most 0.056 do
    assert table[1][:5] == ["0.22", "1000", "64", "0.072", "0.138 (0.130 to 0.145)"]
    assert table[1][5:] == ["0.130", *3 * ["0 (0 to 0.056)"], "0"]
    places = [["0.28", "1000", "64"], ["0.22", "300", "64"], ["0.28", "300", "64"]]
    assert [row[:3] for row in table[2:5]] == places
    assert table[6] == ["0.5", "16", "nowhere", "", "0"]
    assert table[7] == ["1", "16", "9.44", "0.17", "0.5"]


def test_the_virtual_experiment_is_told_by_its_table(tmp_path):
    table = pd.DataFrame(
        {"film": name, "belt_speed": 0.2 + 0.02 * k}
        | {"noise": 1, "seconds": 1000.0, "frames_per_second": 24.0}
        | {"r_run": 0.13, "r_sampled": 0.14 + 0.01 * k, "r_tracked": (0.14 + 0.01 * k) * 1.001}
        | {"mean_sampled": 0.85, "mean_tracked": 0.86, "small_sampled": 0, "small_tracked": 0.1}
        | {"scatter": 0.01, "offset": -0.11, "largest": 0.21}
        for k, name in enumerate(["belt_022", "belt_028"])
    )
    rows = cells(part(written_with(tmp_path, recordings=table), "experiment"))
    assert rows[1] == ["0.20", "1", "1000", "0.13000", "0.14000", "0.14014", "85.000", "86.000",
                       "0.0", "10.0", "0.010", f"{MINUS}0.110", "0.210"]  # fmt: skip
    assert [row[0] for row in rows[1:]] == ["0.20", "0.22"]


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("lower_first", "Where r falls", "where r falls"),
        ("lower_first", "", ""),
        ("slug", "in part", "in-part"),
        ("number", 0.123456, "0.123"),
        ("number", np.nan, ""),
        ("time", 59.94, "59.9 s"),
        ("time", 60.0, "1 min 00 s"),
        ("time", 245.4, "4 min 05 s"),
        ("time", 3599.6, "1 h 00 min"),
        ("time", 7380.0, "2 h 03 min"),
    ],
)
def test_templates_write_values_as_words(name, value, words):
    assert page._environment().filters[name](value) == words

"""The article takes its numbers from the tables, and is set the same way each time."""

import dataclasses
import json
import re
from pathlib import Path

import pypdf
import pytest

import pages
from beltrepro.replication.report import article, findings, sentences, trust
from beltrepro.replication.report.claim_results import count
from beltrepro.replication.verdicts.ledger import load_ledger

ROOT = Path(__file__).parents[2]
SETTINGS = {
    "preset": "standard",
    "model": {"static_friction": 71.4, "friction_ratio": 0.45, "rest_length": 50.0,
              "linear_limit": 20.0},
    "defaults": {"time_step": 0.001, "seed": 17},
    "datasets": {
        "n5_replicates": {"duration": 123000.0, "transient": 45000.0, "replicate": [*range(1, 12)]}
    },
}  # fmt: skip
ORIGIN = {"code_version": "0.1.0+gabc", "library_versions": json.dumps({"numpy": "2.4.6"})}
LIGATURES = str.maketrans({"ﬁ": "fi", "ﬂ": "fl", "ﬀ": "ff", "ﬃ": "ffi", "ﬄ": "ffl"})


def material(folder, verdicts=None):
    figures = ["fig12", "fig13", "fig19", "motion_map"]
    run = pages.material(folder, verdicts=verdicts, figures=figures, settings=SETTINGS)
    about = {"beltrepro:origin": ORIGIN}
    (folder / "claims.csv-metadata.json").write_text(json.dumps(about))
    return run


def pdf_of(folder, run):
    article.write(folder / "article.pdf", run, ["A. Author"])
    return folder / "article.pdf"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """An article: its material, its PDF, and its words."""
    folder = tmp_path_factory.mktemp("article")
    run = material(folder)
    path = pdf_of(folder, run)
    words = (page.extract_text().rstrip() for page in pypdf.PdfReader(path).pages)
    text = " ".join(re.sub(r"\n\d+$", "", page) for page in words)  # without page numbers
    return run, path, plain(text.translate(LIGATURES))


def plain(text):
    """Without spaces and hyphens, which lines break at."""
    return re.sub(r"[\s\-\u00ad\u200b]", "", text)


def test_every_verdict_and_number_that_decides_stands_in_the_article(made):
    run, _, text = made
    for result in run.claims.values():
        assert plain(result.id) in text
        if not result.claim.finding:
            heading = f"{result.id} ({result.claim.kind}: {result.verdicts['replicated']})"
            assert plain(heading) in text
            continue
        for number in (number for answer in result.answers.values() for number in answer.judged):
            words = f"{number.name} {number.words} [{number.allowed_words}]"
            assert plain(sentences.typeset(words)) in text
        row = next(row for row in article.content(run, [])["claims"] if row["id"] == result.id)
        assert {question: row[question] for question in result.verdicts} == result.verdicts


def test_what_is_against_the_paper_or_open_is_listed_once_with_what_was_found(made):
    run, _, text = made
    content = article.content(run, [])
    for name, verdicts in (("against", {"no", "in part"}), ("open", {"open"})):
        listed = {one["id"]: one for one in content[name]}
        findings = [result for result in run.claims.values() if result.claim.finding]
        assert list(listed) == [r.id for r in findings if verdicts & {*r.verdicts.values()}]
        for one in listed.values():
            answers = run.claims[one["id"]].answers
            findings = {a.found for a in answers.values() if a.verdict in verdicts}
            expected = {sentences.typeset(sentences.as_sentence(item)) for item in findings}
            assert {*one["found"].values()} == expected
            assert all(plain(words) in text for words in one["found"].values())


def test_counts_and_facts_are_those_of_the_run(made):
    run, _, text = made
    number = count(run.claims).verdicts
    for said in (
        f"Of {count(run.claims).testable} statements that a simulation can test (preset standard), "
        f"{number['replicated']['yes']} are replicated, {number['replicated']['in part']} in part "
        f"and {number['replicated']['no']} not; {number['robust']['yes']} are robust, "
        f"{number['robust']['in part']} in part and {number['robust']['no']} not.",
        trust.dates(run.claims),
        "rest on 11 independent runs at each point, of length t = 123000, of which 45000",
        "static friction 71.4", "a time step of 0.001", "seed (17)", "preset=standard",
        "beltrepro 0.1.0+gabc with numpy 2.4.6",
    ):  # fmt: skip
        assert plain(said) in text


def test_nothing_is_missing_or_left_to_fill(made):
    run, _, text = made
    words = json.dumps(article.content(run, []), ensure_ascii=False)
    for said in (words, text):
        assert not re.search(r"\bnan\b|NaN|None|\{=|\{[a-z]+-[a-z]+", said)


def test_a_sentence_without_its_number_is_not_there(tmp_path):
    run = material(tmp_path, dict.fromkeys(load_ledger(), "yes"))
    assert article.content(run, [])["against"] == []
    (tmp_path / "claims.csv-metadata.json").unlink()
    less = dataclasses.replace(run, settings={"preset": "own", "defaults": {}})
    methods = article.content(less, [])["methods"]
    assert methods and not re.search("independent runs at each point|constants", str(methods))


def test_findings_are_those_that_hold_and_the_abstract_has_them(made, monkeypatch):
    run, *_ = made
    entries = findings.findings_of(run.claims)
    held = [dataclasses.replace(one, unmet=("x",) * (k % 2)) for k, one in enumerate(entries)]
    monkeypatch.setattr(article, "findings_of", lambda results: held)
    content = article.content(run, [])
    assert [one["text"] for one in content["findings"]] == [one.text for one in held[::2]]
    assert content["abstract"][-1] == " ".join(one.text for one in held[::2])
    figures = [one["figure"]["name"] for one in content["findings"] if one["figure"]]
    assert figures and set(figures) <= set(run.images)
    assert len(figures) == len(set(figures)) <= article.MOST_FIGURES


def test_a_fact_is_never_invented(made):
    run, *_ = made
    facts = article.facts(run.claims, SETTINGS, ORIGIN)
    asked = {
        place[1:]
        for paragraphs in article.texts().values()
        for paragraph in paragraphs
        for sentence in paragraph
        for place in re.findall(r"{(=.*?)}", sentence)
    }
    assert asked <= set(facts)
    assert facts["shorter"] == "123000"
    deciding = SETTINGS["datasets"]["n5_replicates"] | {"duration": 2e6}
    long = SETTINGS | {"datasets": {"n5_replicates": deciding}}
    assert "shorter" not in article.facts(run.claims, long, ORIGIN)
    more = SETTINGS | {"datasets": {"n5_replicates": deciding | {"more_runs": {"up_to": 24}}}}
    assert article.facts(run.claims, more, ORIGIN)["replicates"] == "11 to 24"
    none = article.facts(run.claims, {"preset": "own", "defaults": {}}, {})
    assert not {"duration", "replicates", "seed", "code_version"} & set(none)


@pytest.mark.parametrize("verdict", [None, "yes", "no"])
def test_it_has_four_to_eight_pages_whatever_comes_out(made, tmp_path, verdict):
    path = made[1]
    if verdict:
        path = pdf_of(tmp_path, material(tmp_path, dict.fromkeys(load_ledger(), verdict)))
    assert 4 <= len(pypdf.PdfReader(path).pages) <= 8


def test_it_has_title_authors_and_no_date(made):
    metadata = pypdf.PdfReader(made[1]).metadata
    assert metadata["/Title"] == "[Re] Chaos on the conveyor belt"
    assert metadata["/Author"] == "A. Author" and "replication" in metadata["/Keywords"]
    assert "/CreationDate" not in metadata
    assert article.name_of({"given-names": "Ann", "family-names": "Bee"}) == "Ann Bee"
    assert article.name_of({"name": "The Group"}) == "The Group"


def test_all_fonts_are_in_the_file(made):
    fonts = {
        str(font.get_object()["/BaseFont"]): font.get_object()
        for page in pypdf.PdfReader(made[1]).pages
        for font in page["/Resources"]["/Font"].values()
    }
    assert fonts
    for name, font in fonts.items():
        (inner,) = font.get("/DescendantFonts", [font])
        described = inner.get_object()["/FontDescriptor"].get_object()
        assert {"/FontFile", "/FontFile2", "/FontFile3"} & set(described), name


def test_the_same_content_gives_the_same_bits(made, tmp_path):
    run, path, _ = made
    assert pdf_of(tmp_path, run).read_bytes() == path.read_bytes()


def test_a_screen_reader_can_read_it(made):
    root = pypdf.PdfReader(made[1]).trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"] and "/StructTreeRoot" in root

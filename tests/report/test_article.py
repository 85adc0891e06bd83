"""The article takes its numbers from the tables, and is set the same way each time."""

import json
import re
from pathlib import Path

import pypdf
import pytest
import yaml
from test_report import PIXEL

import made_up_results
from beltrepro.replication.report import article, findings
from beltrepro.replication.report.article import contents
from beltrepro.replication.report.findings import sentences
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, NOT_MEASURED
from beltrepro.replication.verdicts.entries import load_ledger

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
    claims, estimates = made_up_results.write(folder, verdicts)
    about = {"beltrepro:origin": ORIGIN}
    (folder / "claims.csv-metadata.json").write_text(json.dumps(about))
    figures = {}
    for name in ("fig12", "fig13", "fig19", "motion_map"):
        figures[name] = folder / f"{name}.png"
        figures[name].write_bytes(PIXEL)
    return article.Material(SETTINGS, claims, estimates, figures, ("A. Author",))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """An article: its material, its PDF, and its words."""
    folder = tmp_path_factory.mktemp("article")
    own = material(folder)
    article.write(folder / "article.pdf", own)
    pages = pypdf.PdfReader(folder / "article.pdf").pages
    text = " ".join(page.extract_text() for page in pages).translate(LIGATURES)
    return own, folder / "article.pdf", plain(text)


def plain(text):
    """Without spaces and hyphens, which lines break at."""
    return re.sub(r"[\s\-\u00ad\u200b]", "", text)


def test_every_number_that_decides_stands_in_the_article(made):
    own, _, text = made
    results = findings.read(own.claims, own.estimates)
    for result in results.values():
        if not result.claim.finding:
            continue
        assert plain(result.id) in text
        for number in result.counted.judged:
            allowed = sentences.typeset(number.allowed_words)
            words = sentences.typeset(f"{number.name} {number.words}")
            assert plain(f"{sentences.typeset(number.name)}{words[len(number.name) :]}") in text
            assert plain(f"{sentences.typeset(number.words)} [{allowed}]") in text


def test_counts_and_facts_are_those_of_the_run(made):
    own, _, text = made
    counts = findings.count(findings.read(own.claims, own.estimates).values())
    number = counts.by_verdict
    assert (
        plain(
            f"Of {counts.testable} claims that can be tested {number['holds']} hold, "
            f"{number['partly']} hold in part, {number['fails']} fail"
        )
        in text
    )
    for said in (
        "rest on 11 independent runs at each point, of length t = 123000, of which 45000",
        "static friction 71.4", "a time step of 0.001", "seed (17)", "preset=standard",
        "beltrepro 0.1.0+gabc with numpy 2.4.6",
    ):  # fmt: skip
        assert plain(said) in text


def test_claims_that_fail_say_why(made):
    own, _, text = made
    told = contents.content(own)
    results = findings.read(own.claims, own.estimates)
    failing = [each for each in results.values() if each.verdict in ("fails", "partly")]
    assert [each["id"] for each in told["failing"]] == [
        each.id for each in failing if each.claim.finding
    ]
    for each in told["failing"]:
        assert each["why"] and plain(each["why"]) in text


def test_nothing_is_missing_or_left_to_fill(made):
    own, _, text = made
    words = json.dumps(contents.content(own), ensure_ascii=False)
    for found in (words, text):
        assert not re.search(r"\bnan\b|NaN|None|\{=|\{[a-z]+-[a-z]+", found)
    assert "not found" not in words


def test_a_sentence_without_its_number_is_not_there(tmp_path):
    told = contents.content(material(tmp_path, {"u-critical": NOT_MEASURED}))
    assert "The transition without noise" not in [each["topic"] for each in told["findings"]]
    whole = contents.content(material(tmp_path, dict.fromkeys(load_ledger(), HOLDS)))
    topics = [each["topic"] for each in whole["findings"]]
    assert "The transition without noise" in topics and whole["failing"] == []
    less = contents.content(
        article.Material(
            {"preset": "own", "defaults": {}},
            *(tmp_path / name for name in ("claims.csv", "estimates.csv")),
            {},
            (),
        )
    )
    assert not any("independent runs at each point" in each for each in less["methods"])
    assert not any("constants" in each for each in less["methods"])


def test_a_fact_is_never_invented(tmp_path):
    found = findings.read(*made_up_results.write(tmp_path))
    known = contents.facts(found, SETTINGS, ORIGIN)
    asked = {
        place[1:]
        for paragraphs in contents._texts().values()
        for paragraph in paragraphs
        for sentence in paragraph
        for place in sentences.places(sentence)
    }
    assert asked <= set(known)
    assert known["shorter"] == "123000"
    whole = SETTINGS["datasets"]["n5_replicates"] | {"duration": 2e6}
    assert "shorter" not in contents.facts(
        found, SETTINGS | {"datasets": {"n5_replicates": whole}}, ORIGIN
    )
    none = contents.facts(found, {"preset": "own", "defaults": {}}, {})
    assert not {"duration", "replicates", "seed", "code_version"} & set(none)


def test_it_has_four_to_eight_pages(made):
    assert 4 <= len(pypdf.PdfReader(made[1]).pages) <= 8


@pytest.mark.parametrize("verdict", [HOLDS, FAILS])
def test_it_has_eight_pages_at_most_whatever_comes_out(tmp_path, verdict):
    own = material(tmp_path, dict.fromkeys(load_ledger(), verdict))
    article.write(tmp_path / "article.pdf", own)
    assert len(pypdf.PdfReader(tmp_path / "article.pdf").pages) <= 8


def test_it_has_title_authors_and_no_date(made):
    metadata = pypdf.PdfReader(made[1]).metadata
    assert metadata["/Title"] == "[Re] Chaos on the conveyor belt"
    assert metadata["/Author"] == "A. Author" and "replication" in metadata["/Keywords"]
    assert "/CreationDate" not in metadata


def test_authors_are_those_of_the_citation():
    told = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert all(article.name_of(each) for each in told["authors"])
    assert article.name_of({"given-names": "Ann", "family-names": "Bee"}) == "Ann Bee"


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
    own, path, _ = made
    article.write(tmp_path / "again.pdf", own)
    assert (tmp_path / "again.pdf").read_bytes() == path.read_bytes()


def test_a_screen_reader_can_read_it(made):
    root = pypdf.PdfReader(made[1]).trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"] and "/StructTreeRoot" in root

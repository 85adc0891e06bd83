"""The article has the numbers of its run, and no sentence that its run does not bear out."""

import re
import shutil
import unicodedata
from dataclasses import replace
from pathlib import Path

import pypdf
import pytest

import made_up_results
from beltrepro.base.errors import InputError
from beltrepro.replication.report import article
from beltrepro.replication.report.claim_results import count, read
from beltrepro.replication.report.sentences import number_at, typeset
from beltrepro.replication.verdicts.ledger import load_ledger

ROOT = Path(__file__).parents[2]
PUBLISHED = ROOT / "docs" / "results" / "paper"
SETTINGS = {"datasets": {"n5_replicates": {"duration": 123000.0, "replicate": [*range(1, 12)]}}}
ORIGIN = {"code_version": "0.1.0+gabc"}


def written(path):
    results = read(PUBLISHED)
    figures = {picture.stem: picture for picture in (PUBLISHED / "figures").glob("*.png")}
    about = article.facts(results, SETTINGS, ORIGIN)
    article.write(path, results, about, figures, ["A. Author"])
    return path


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return written(tmp_path_factory.mktemp("article") / "article.pdf")


@pytest.fixture(scope="module")
def words(path):
    """All words without spaces and hyphens, which lines break at, and without page numbers."""
    pages = (page.extract_text().rstrip() for page in pypdf.PdfReader(path).pages)
    return plain(" ".join(re.sub(r"\n\d+$", "", page) for page in pages))


def plain(text):
    return re.sub(r"[\s\-\u00ad\u200b\u2011]", "", unicodedata.normalize("NFKC", text))


def test_every_statement_stands_in_it_with_its_numbers(words):
    for result in read(PUBLISHED).values():
        assert plain(typeset(result.claim.statement)) in words
        for number in (n for answer in result.answers.values() for n in answer.judged):
            if result.claim.finding:
                entry = f"{number.name} {number.words} [{number.allowed_words}"
                assert plain(typeset(entry)) in words


def test_numbers_and_facts_in_the_prose_are_those_of_the_run(words):
    results = read(PUBLISHED)
    verdicts = count(results).verdicts
    tested = sum(verdicts["robust"].values()) - verdicts["robust"]["not testable"]
    for text in (
        f"By the protocol {verdicts['replicated']['yes']} of ",
        f"Of {tested} statements {verdicts['robust']['yes']} pass it",
        f"at the belt velocity u = {number_at('u-critical: critical', results).words}",
        "rest on 11 runs at each u and σ. Each lasts 123,000 time units",
        "beltrepro 0.1.0+gabc",
    ):
        assert plain(text) in words


def test_nothing_is_left_to_fill_in(words):
    assert not re.search(r"\bnan\b|NaN|None|=\w+\"|#number|restson\(", words)


def test_no_sign_is_swallowed():
    """A semicolon after `#m(...)` or `#number(...)` would end the call, and not be printed."""
    assert not re.search(r'(\$|")\);', article.text())


LINES = [line for line in article.text().splitlines() if "#rests-on" in line or "#lies" in line]


def test_many_sentences_are_watched():
    assert len(LINES) >= 25
    results = read(PUBLISHED)
    for line in LINES:
        article.refuse_what_does_not_hold(line, results)


@pytest.mark.parametrize("verdict", ["yes", "in part", "no", "open"])
def test_a_sentence_that_does_not_hold_is_named(tmp_path, verdict):
    """Where all claims have one verdict, every sentence that rests on another one is refused."""
    made_up_results.write(tmp_path, dict.fromkeys(load_ledger(), verdict))
    results = read(tmp_path)
    refused = 0
    for line in LINES:
        wanted = re.findall(r'#rests-on\("(.+?)", "(.+?)", "(.+?)"\)', line)
        wrong = [claim for claim, question, word in wanted
                 if results[claim].verdicts[question] != word]  # fmt: skip
        if wrong:
            with pytest.raises(InputError) as caught:
                article.refuse_what_does_not_hold(line, results)
            sentence, _, reasons = str(caught.value).partition(" is not what this run found: ")
            first_words = re.sub(r"#m\(\$(.*?)\$\)", r"\1", line).split()[:2]
            assert "#" not in sentence and sentence.strip("\"'").split()[:2] == first_words
            assert wrong[0] in reasons
            refused += 1
    assert refused >= (3 if verdict == "yes" else 15)


def test_a_number_that_leaves_its_range_is_named(tmp_path):
    shutil.copytree(PUBLISHED, tmp_path / "run")
    results = read(tmp_path / "run")
    low = number_at("u-critical: critical", results).estimate.low
    for limit, refused in ((0.8 * low, False), (1.2 * low, True)):
        line = f'It falls. #lies("u-critical: critical", {limit}, 30)'
        if refused:
            with pytest.raises(InputError, match=r"'It falls.' is not what .* u-critical"):
                article.refuse_what_does_not_hold(line, results)
        else:
            article.refuse_what_does_not_hold(line, results)


def test_what_the_run_does_not_have_is_refused():
    results = read(PUBLISHED)
    prose = '#number("u-critical: critical") #number("no-claim: x") #number("=absent")'
    with pytest.raises(InputError, match="no-claim: x; =absent"):
        article.numbers_in(prose, results, {})
    with pytest.raises(InputError, match="shows fig01, of which this run has no picture"):
        article.write(Path("a.pdf"), results, article.facts(results, SETTINGS, ORIGIN), {}, [])


def test_statements_that_are_replicated_and_not_robust_are_counted(tmp_path):
    verdicts = dict.fromkeys(load_ledger(), "yes")
    made_up_results.write(tmp_path, verdicts)
    results = read(tmp_path)
    ledger = load_ledger().items()
    names = [name for name, claim in ledger if claim.finding
             and not any(c.untestable for c in claim.criteria.values())]  # fmt: skip
    alike = [name for name in names
             if len({a.criterion for a in results[name].answers.values()}) == 1]  # fmt: skip
    other = [name for name in names if name not in alike]
    for name in (*alike[:2], *other[:3]):
        answers = results[name].answers
        answers["robust"] = replace(answers["robust"], verdict="no")
    about = article.facts(results, SETTINGS, ORIGIN)
    assert (about["dropped"], about["dropped by the same range"]) == ("5", "2")
    assert (about["robust no"], about["open"]) == ("5", "0")
    answers["robust"] = replace(answers["robust"], verdict="open")
    assert article.facts(results, SETTINGS, ORIGIN)["open"] == "1"


def test_title_authors_no_date_and_tags_for_screen_readers(path):
    reader = pypdf.PdfReader(path)
    assert reader.metadata["/Title"] == "[Re] Chaos on the conveyor belt"
    assert reader.metadata["/Author"] == "A. Author" and "chaos" in reader.metadata["/Keywords"]
    assert "/CreationDate" not in reader.metadata
    root = reader.trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"] and "/StructTreeRoot" in root
    assert article.name_of({"given-names": "Ann", "family-names": "Bee"}) == "Ann Bee"
    assert article.name_of({"name": "The Group"}) == "The Group"


def test_all_fonts_are_in_the_file(path):
    fonts = {
        str(font.get_object()["/BaseFont"]): font.get_object()
        for page in pypdf.PdfReader(path).pages
        for font in page["/Resources"]["/Font"].values()
    }
    assert fonts
    for name, font in fonts.items():
        (inner,) = font.get("/DescendantFonts", [font])
        described = inner.get_object()["/FontDescriptor"].get_object()
        assert {"/FontFile", "/FontFile2", "/FontFile3"} & set(described), name


def test_the_same_content_gives_the_same_bits(path, tmp_path):
    assert written(tmp_path / "again.pdf").read_bytes() == path.read_bytes()


def test_every_source_is_cited_and_every_citation_has_a_source():
    sources = re.findall(r"^@\w+\{(\w+),", (Path(article.__file__).parent / article.SOURCES)
                         .read_text(encoding="utf-8"), re.M)  # fmt: skip
    assert len(set(sources)) == len(sources) >= 25
    prose = article.text()
    assert [name for name in sources if f"@{name}" not in prose] == []

"""What is published is what the run has; article and README.md have its numbers."""

import re
import shutil
import unicodedata
from pathlib import Path

import pandas as pd
import pypdf
import pytest

import made_up_results
import pages
from beltrepro.base import seal
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import io, registry
from beltrepro.replication.report import findings, publishing
from beltrepro.replication.report.claim_results import count, read, statements
from beltrepro.replication.report.findings import typeset
from beltrepro.replication.verdicts.ledger import load_ledger

ROOT = Path(__file__).parents[2]
PUBLISHED = Path("docs/results/paper")
# whose statements are not those of this version, so that sentences on the others have no numbers
earlier = pytest.mark.skipif(
    {*read(Path(__file__).parents[2] / PUBLISHED)} != {*load_ledger()},
    reason="the published run is of an earlier version",
)
PROSE = (ROOT / publishing.ARTICLE).read_text(encoding="utf-8")
PICTURES = {*re.findall(r'#picture\("(.+?)"', PROSE)}


@pytest.fixture(autouse=True)
def at_the_top(monkeypatch):
    monkeypatch.chdir(ROOT)


# --- copies and checksums -------------------------------------------------------------------------


@pytest.fixture
def finished(tmp_path):
    """A finished run: results/standard."""
    folder = tmp_path / "results" / "standard"
    made_up_results.write(folder, dict.fromkeys(load_ledger(), "yes"))
    (folder / "figures").mkdir()
    (folder / "tables").mkdir()
    (folder / "tables" / "shares.csv").write_text("share\n1\n")
    (folder / "figures" / "fig00.png").write_bytes(pages.PIXEL)
    (folder / "figures" / "fig00.pdf").write_bytes(b"%PDF")
    (folder / "report.html").write_text("<p>" * 99)
    for name in ("report.html", "figures/fig00.png", "tables/shares.csv"):
        seal.put(folder / name)
    return folder


def test_report_figures_and_tables_are_published_as_a_whole(finished, tmp_path):
    left = tmp_path / "docs" / "standard" / "figures" / "old.png"
    left.parent.mkdir(parents=True)
    left.touch()
    folder = publishing.publish(finished, tmp_path / "docs")
    names = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert names == {*publishing.FILES, "figures/fig00.png", "tables/shares.csv"}
    for name in names:
        seal.check(folder / name)
        assert (folder / name).read_bytes() == (finished / name).read_bytes()


@pytest.mark.parametrize("name", [*publishing.FILES, "figures/fig00.png", "tables/shares.csv"])
def test_an_unfinished_or_damaged_run_is_not_published(finished, tmp_path, name):
    content = (finished / name).read_bytes()
    for damaged in (content[:-50], content[:9] + b"#" + content[10:]):
        (finished / name).write_bytes(damaged)
        with pytest.raises(InputError, match=f"{name}: (damaged|has no seal): "):
            publishing.publish(finished, tmp_path / "docs")
    if "/" not in name:
        (finished / name).unlink()
        with pytest.raises(InputError, match=f"{name}: no such file"):
            publishing.publish(finished, tmp_path / "docs")
    assert not (tmp_path / "docs").exists()


# --- README.md ------------------------------------------------------------------------------------


def test_readme_has_the_numbers_of_the_published_run():
    published = io.read_table(PUBLISHED / "claims.csv")["id"]
    if {*published} != {*load_ledger()}:
        pytest.skip("the published run has other claims; the next `make publish` writes README.md")
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    begin = f"{publishing.BEGIN}\n"
    written = text.partition(begin)[2].partition(publishing.END)[0]
    assert written == publishing.block(PUBLISHED), "`make publish` writes it"
    results = read(PUBLISHED)
    for question, numbers in count(results).items():
        counted = ", ".join(f"{number} {word}" for word, number in numbers.items())
        assert f"*{question.capitalize()}*: {counted}" in written
    answers = results["u-critical"].answers.values()
    cells = (answer.numbers["critical"].estimate.words for answer in answers)
    assert f"| 16.5 | {' | '.join(cells)} |" in written


def test_the_block_is_written_between_its_marks(tmp_path, run):
    readme = tmp_path / "README.md"
    readme.write_text(f"before\n{publishing.BEGIN}\nOLD\n{publishing.END}\nafter\n")
    publishing.write_block(readme, run)
    block = publishing.block(run)
    text = f"before\n{publishing.BEGIN}\n{block}{publishing.END}\nafter\n"
    assert readme.read_text() == text
    readme.write_text("before")
    with pytest.raises(InputError, match="lacks"):
        publishing.write_block(readme, run)


# --- the article ----------------------------------------------------------------------------------


@pytest.fixture
def run(tmp_path, monkeypatch):
    """The published run in a folder with what the article needs, its tables as jobs write them.

    Numbers of explanations that it lacks are made up, and figures are copies: they changed since.
    """
    shutil.copytree(ROOT / "docs/article", tmp_path / "docs/article")
    for folder in ("figures", "tables"):
        shutil.copytree(ROOT / PUBLISHED / folder, tmp_path / "run" / folder)
    shutil.copyfile(ROOT / "CITATION.cff", tmp_path / "CITATION.cff")
    for picture in PICTURES:
        if not (path := tmp_path / f"run/figures/{picture}.png").exists():
            shutil.copyfile(path.with_stem("fig12"), path)
    ours = {claim.id for claim in load_ledger().values() if claim.kind == "explanation"}
    made_up = made_up_results.tables(dict.fromkeys(ours, "yes"))
    sources = io.said(ROOT / PUBLISHED / "claims.csv")["sources"]
    readings = {}
    tables = ["claims", "id"], ["estimates", "id", "name"]
    for made, (name, *keys) in zip(made_up, tables, strict=True):
        table = io.read_table(ROOT / PUBLISHED / f"{name}.csv", dtype=str, keep_default_na=False)
        table = table[table["id"].isin(load_ledger())]
        readings = readings or dict(zip(table["id"], table["replicated_reading"], strict=True))
        known = {*table[keys].itertuples(index=False, name=None)}
        made = made[made["id"].isin(ours)]
        made = made[[row not in known for row in made[keys].itertuples(index=False, name=None)]]
        if name == "estimates":
            made = made.assign(reading=made["id"].map(readings).fillna(made["reading"]))
        path = tmp_path / "run" / f"{name}.csv"
        table = pd.concat([table, made])
        io.write_table(path, table, title="Published.", columns={}, sources=sources)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "run"


def plain(text):
    """Without spaces and hyphens, which lines break at."""
    return re.sub(r"[\s\-\u00ad\u200b\u2011]", "", unicodedata.normalize("NFKC", text))


@earlier
def test_the_article_has_every_statement_with_its_numbers(run):
    content = publishing.set_article(run)
    assert content == publishing.set_article(run)
    (run / "article.pdf").write_bytes(content)
    reader = pypdf.PdfReader(run / "article.pdf")
    texts = (page.extract_text().rstrip() for page in reader.pages)
    words = plain(" ".join(re.sub(r"\n\d+$", "", text) for text in texts))
    results = read(run)
    # words and criteria are those of the run, which may be older than the ledger's
    rows = {row["id"]: row for row in io.read_as_text(run / "claims.csv")}
    entries = [row["statement"] for row in rows.values()]
    for result in statements(results):
        for question, answer in result.answers.items():
            criterion = rows[result.id][f"{question}_criterion"].split("; ")
            for number in answer.judged:
                prefix = "robust " if question == "robust" else ""
                value = findings.filled(f"{{{prefix}{result.id}: {number.name}}}", results)
                (ranges,) = (one for one in criterion if one.startswith(f"{number.name}: "))
                ranges = ranges.removeprefix(f"{number.name}: ").rstrip(")")
                entries.append(f"{number.name} {value} [{ranges.replace(' (lenient: ', ' | ')}]")
    verdicts, about = count(results), io.said(run / "claims.csv")
    tested = sum(verdicts["robust"].values()) - verdicts["robust"]["not testable"]
    entries += [
        f"To the first, {verdicts['replicated']['yes']} of ",
        f"to the second, which is harder, {verdicts['robust']['yes']} of {tested}, ",
        f"Simulated by beltrepro {about['sources']['n5_replicates']['code_version']}",
        f"tables are by beltrepro {about['code_version']}.",
        *(registry.figures()[name].title.replace("sigma", "σ") for name in PICTURES),
    ]
    assert [entry for entry in entries if plain(typeset(entry)) not in words] == []
    root = reader.trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"] and "/StructTreeRoot" in root  # for screen readers


CONDITIONS = [
    *re.findall(r'#rests-on\("(.+?)", "(.+?)", "(.+?)"\)', PROSE),
    *re.findall(r'#lies\("(?:robust )?(.+?): .+?", (.+?), (.+?)\)', PROSE),
]


def test_many_sentences_are_watched_and_every_source_is_cited():
    assert len(CONDITIONS) >= 60
    bibliography = (ROOT / "docs/article/references.bib").read_text(encoding="utf-8")
    assert [name for name in re.findall(r"^@\w+\{(\w+),", bibliography, re.M)
            if f"@{name}" not in PROSE] == []  # fmt: skip


@earlier
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"uc-sigma22", "replicated", "yes"', '"uc-sigma22", "replicated", "no"',
         "uc-sigma22 is yes as replicated, not no"),
        ('"r-jump: ratio", 8, 12.5', '"r-jump: ratio", 8, 10', "r-jump: ratio is 9.8"),
        ("not in it", '#number("r-jump: none")', "r-jump: none"),
    ],
)  # fmt: skip
def test_a_sentence_that_does_not_hold_is_named(run, old, new, message):
    prose = PROSE.replace(old, new) if old in PROSE else f"{PROSE}\n{new}"
    publishing.ARTICLE.write_text(prose, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        publishing.set_article(run)


def test_a_paper_that_findings_do_not_describe_is_refused(finished, tmp_path):
    paper = finished.rename(finished.with_name("paper"))
    with pytest.raises(InputError, match=r"is not what this run found: .* is .*, not"):
        publishing.publish(paper, tmp_path / "docs")
    assert not (tmp_path / "docs").exists()
    assert {*registry.figures()} >= PICTURES

"""What is published is what the run has; README.md has its numbers."""

import base64
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import made_up_results
from beltrepro.base import seal
from beltrepro.base.errors import InputError
from beltrepro.replication.report import findings, publishing
from beltrepro.replication.report.claim_results import count, read
from beltrepro.replication.verdicts.criteria import VERDICTS
from beltrepro.replication.verdicts.ledger import load_ledger

ROOT = Path(__file__).parents[2]


def picture(path, seed=0, side=40):
    path.parent.mkdir(exist_ok=True)
    levels = np.random.default_rng(seed).integers(0, 255, (side, side, 3), dtype=np.uint8)
    Image.fromarray(levels).save(path)
    seal.put(path)


def pictures_of(folder):
    return sorted((folder / "figures").glob("*.png"))


@pytest.fixture
def finished(tmp_path):
    """A finished run: results/paper."""
    folder = tmp_path / "results" / "standard"
    made_up_results.write(folder, dict.fromkeys(load_ledger(), "yes"))
    for number in range(2):
        picture(folder / "figures" / f"fig0{number}.png", seed=number)
    images = [base64.b64encode(path.read_bytes()).decode() for path in pictures_of(folder)]
    (folder / "report.html").write_text(
        "".join(f'<img src="data:image/png;base64,{image}">' for image in images)
    )
    seal.put(folder / "report.html")
    (folder / "figures" / "fig00.pdf").write_bytes(b"%PDF")
    return folder


def test_report_figures_and_tables_are_published(finished, tmp_path):
    folder = publishing.publish(finished, tmp_path / "docs")
    names = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert folder == tmp_path / "docs" / "standard"
    assert names == {*publishing.FILES, "figures/fig00.png", "figures/fig01.png"}
    for name in names:
        seal.check(folder / name)
        if name.endswith(".csv"):
            assert (folder / name).read_bytes() == (finished / name).read_bytes()


def test_the_report_is_one_file_that_holds_the_published_pictures(finished, tmp_path, monkeypatch):
    other = '<img src="data:image/png;base64,AAAA">'
    (finished / "report.html").write_text(seal.content(finished / "report.html") + other)
    seal.put(finished / "report.html")
    folder = publishing.publish(finished, tmp_path / "docs")
    images = [base64.b64encode(path.read_bytes()).decode() for path in pictures_of(folder)]
    shown = "".join(f'<img src="data:image/png;base64,{image}">' for image in images)
    assert seal.content(folder / "report.html") == shown + other
    monkeypatch.setattr(publishing, "REPORT_LIMIT", len(shown))
    with pytest.raises(InputError, match=r"report\.html: larger than"):
        publishing.publish(finished, tmp_path / "docs")


def test_it_is_replaced_as_a_whole(finished, tmp_path):
    folder = publishing.publish(finished, tmp_path / "docs")
    (finished / "figures" / "fig01.png").unlink()
    publishing.publish(finished, tmp_path / "docs")
    assert not (folder / "figures" / "fig01.png").exists()
    assert [path.name for path in (tmp_path / "docs").iterdir()] == ["standard"]


@pytest.mark.parametrize("name", [*publishing.FILES, "figures"])
def test_an_unfinished_run_is_refused(finished, tmp_path, name):
    if name == "figures":
        for path in (finished / name).glob("*.png"):
            path.unlink()
    else:
        (finished / name).unlink()
    with pytest.raises(InputError, match=f"{name}: not there; `snakemake"):
        publishing.publish(finished, tmp_path / "docs")
    assert not (tmp_path / "docs").exists()


@pytest.mark.parametrize("name", [*publishing.FILES, "figures/fig01.png"])
def test_a_damaged_file_is_not_published(finished, tmp_path, name):
    content = (finished / name).read_bytes()
    for damaged in (content[:-50], content[:99] + b"#" + content[100:]):
        (finished / name).write_bytes(damaged)
        with pytest.raises(InputError, match=f"{name}: (damaged|has no seal): "):
            publishing.publish(finished, tmp_path / "docs")


def test_a_published_table_is_compared_when_it_is_read(finished, tmp_path):
    folder = publishing.publish(finished, tmp_path / "docs")
    read(folder)
    text = (folder / "claims.csv").read_text()
    (folder / "claims.csv").write_text(text.replace(",yes,", ",no,", 1))
    with pytest.raises(InputError, match=r"claims.csv: damaged: "):
        read(folder)


def test_pictures_lose_colours_that_nobody_sees(finished, tmp_path):
    folder = publishing.publish(finished, tmp_path / "docs")
    pictures = (publishing.size(run / "figures") for run in (folder, finished))
    assert next(pictures) < 0.6 * next(pictures)
    for path in pictures_of(folder):
        assert Image.open(path).mode == "P"
        ours, theirs = (np.asarray(Image.open(root / "figures" / path.name).convert("RGB"), float)
                        for root in (folder, finished))  # fmt: skip
        assert np.abs(ours - theirs).mean() < 20


def test_a_run_that_is_too_large_is_refused(finished, tmp_path, monkeypatch):
    monkeypatch.setattr(publishing, "LIMIT", 1000)
    with pytest.raises(InputError, match="MB, at most 0 are published"):
        publishing.publish(finished, tmp_path / "docs")
    assert not (tmp_path / "docs" / "standard").exists()


def test_readme_has_the_numbers_of_the_published_run():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    _, _, rest = text.partition(f"{publishing.BEGIN}\n")
    written, end, _ = rest.partition(publishing.END)
    assert end
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        if "replicated" in (publishing.PLACE / "paper" / "claims.csv").read_text().split("\n")[0]:
            block = publishing.block(publishing.PLACE)
            assert written == block, "`make publish` writes it"


def place(claim):
    """Of the first number that decides."""
    return f"{claim}: {next(iter(load_ledger()[claim].replicated.allowed))}"


@pytest.fixture
def said(monkeypatch):
    """Two findings in place of those of the published run, and the table below them."""
    entries = [
        {"topic": name, "text": f"{name}: {{robust {place(claim)}}}.", "figure": "fig12",
         "numbers": {},
         "verdicts": {claim: {"replicated": True, "robust": verdict}}}
        for name, claim, verdict in (("One", "u-critical", False), ("Two", "uc-sigma22", True))
    ]  # fmt: skip
    rows = [{"what": "slips", "place": "slip-size-exponent"},
            {"what": "fall", "place": place("u-critical"), "printed": "15 to 18"}]  # fmt: skip
    monkeypatch.setattr(findings, "words", lambda: {"findings": entries, "numbers": rows})
    return {"u-critical": {"replicated": "yes", "robust": "no"}}


@pytest.fixture
def block(tmp_path, monkeypatch):
    """Publishes made-up tables of a run, and gives the block of README.md and the results."""
    monkeypatch.chdir(tmp_path)

    def block(name="paper", **verdicts):
        folder = Path("docs") / "results" / name
        made_up_results.write(folder, dict.fromkeys(load_ledger(), "yes") | verdicts)
        (folder / "report.html").touch()
        return publishing.block(), read(folder)

    return block


def test_the_block_takes_its_numbers_from_the_tables(block, said):
    text, results = block(**said)
    u, slips = results["u-critical"].answers, results["slip-size-exponent"].answers
    replicated, robust = u["replicated"].judged[0], u["robust"].judged[0]
    assert f"- One: {robust.words}.\n- Two: " in text
    assert f"| fall | 15 to 18 | {replicated.words} | {robust.words} |" in text
    (number, *_) = slips["replicated"].judged
    words = number.words.replace("-", "−")
    assert f"| slips | −1.47 | {words} | " in text
    counts = count(results)
    assert f"The paper makes {counts.total} statements" in text
    numbers = counts.verdicts["robust"]
    row = " | ".join(str(numbers[verdict]) for verdict in VERDICTS)
    assert f"| robust | {row} |" in text and numbers["no"] == 1
    assert "docs/results/paper/report.html" in text


def test_a_sentence_that_does_not_hold_stops_the_paper_and_no_other_run(
    finished, tmp_path, said, block, monkeypatch
):
    paper = finished.rename(finished.parent / "paper")
    monkeypatch.setattr(publishing.article, "write", lambda output, *_: output.write_bytes(b"%PDF"))
    monkeypatch.chdir(ROOT)
    made_up_results.write(paper, dict.fromkeys(load_ledger(), "yes"))
    with pytest.raises(InputError, match=r"'One: .*u-critical is yes as robust, not no; change"):
        publishing.publish(paper, tmp_path / "docs")
    assert list((tmp_path / "docs").iterdir()) == []
    made_up_results.write(paper, dict.fromkeys(load_ledger(), "yes") | said)
    folder = publishing.publish(paper, tmp_path / "docs")
    assert seal.content(folder / "article.pdf") == "%PDF"
    monkeypatch.chdir(tmp_path)
    text, _ = block("standard")
    assert "- Two: " in text and "One" not in text


def test_the_command_writes_the_block(finished, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("README.md").write_text(f"before\n{publishing.BEGIN}\nOLD\n{publishing.END}\nafter\n")
    publishing.main(str(finished))
    text = Path("README.md").read_text()
    assert text.startswith("before\n") and text.endswith(f"{publishing.END}\nafter\n")
    assert "OLD" not in text and publishing.block() in text


@pytest.mark.parametrize(
    "text",
    ["nothing", f"a {publishing.BEGIN} b", f"a {publishing.END} b",
     f"{publishing.END} a {publishing.BEGIN}"],
)  # fmt: skip
def test_a_page_without_both_marks_in_order_is_refused(tmp_path, text):
    (tmp_path / "README.md").write_text(text)
    with pytest.raises(InputError, match="lacks"):
        publishing.write_block(tmp_path / "README.md", tmp_path)
    assert (tmp_path / "README.md").read_text() == text

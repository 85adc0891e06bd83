"""What is published is what the run has; README.md has its numbers."""

import base64
import hashlib
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import made_up_results
from beltrepro.base import seal
from beltrepro.base.errors import InputError
from beltrepro.cli import app as cli
from beltrepro.replication.report import publishing
from beltrepro.replication.report.claim_results import count, read
from beltrepro.replication.verdicts.ledger import load_ledger

ROOT = Path(__file__).parents[2]


def picture(path, seed=0, side=40):
    path.parent.mkdir(exist_ok=True)
    levels = np.random.default_rng(seed).integers(0, 255, (side, side, 3), dtype=np.uint8)
    Image.fromarray(levels).save(path)


def pictures_of(folder):
    return sorted((folder / "figures").glob("*.png"))


@pytest.fixture
def finished(tmp_path):
    """A finished run: results/paper."""
    folder = tmp_path / "results" / "paper"
    made_up_results.write(folder, dict.fromkeys(load_ledger(), "holds"))
    for number in range(2):
        picture(folder / "figures" / f"fig0{number}.png", seed=number)
    images = [base64.b64encode(path.read_bytes()).decode() for path in pictures_of(folder)]
    (folder / "report.html").write_text(
        "".join(f'<img src="data:image/png;base64,{each}">' for each in images)
    )
    (folder / "article.pdf").write_bytes(b"%PDF")
    (folder / "figures" / "fig00.pdf").write_bytes(b"%PDF")
    return folder


def test_report_article_figures_and_tables_are_published(finished, tmp_path):
    folder = publishing.publish(finished, tmp_path / "docs")
    names = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert folder == tmp_path / "docs" / "paper"
    assert names == {
        *publishing.FILES, "figures/fig00.png", "figures/fig01.png", "manifest-sha256.txt"
    }  # fmt: skip
    for line in (folder / "manifest-sha256.txt").read_text().splitlines():
        checksum, name = line.split("  ")
        assert checksum == hashlib.sha256((folder / name).read_bytes()).hexdigest()
        if name != "report.html":
            assert (folder / name).read_bytes() == (finished / name).read_bytes()
        names.remove(name)
    assert names == {"manifest-sha256.txt"}


def test_the_report_shows_the_files_and_does_not_hold_them(finished, tmp_path):
    other = '<img src="data:image/png;base64,AAAA">'
    (finished / "report.html").write_text((finished / "report.html").read_text() + other)
    folder = publishing.publish(finished, tmp_path / "docs")
    pictures = '<img src="figures/fig00.png"><img src="figures/fig01.png">'
    assert (folder / "report.html").read_text() == pictures + other


def test_it_is_replaced_as_a_whole(finished, tmp_path):
    folder = publishing.publish(finished, tmp_path / "docs")
    (finished / "figures" / "fig01.png").unlink()
    publishing.publish(finished, tmp_path / "docs")
    assert not (folder / "figures" / "fig01.png").exists()
    assert [path.name for path in (tmp_path / "docs").iterdir()] == ["paper"]


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


def test_a_damaged_file_is_not_published(finished, tmp_path):
    path = finished / "figures" / "fig01.png"
    seal.put(path)
    publishing.publish(finished, tmp_path / "docs")
    damaged = bytearray(path.read_bytes())
    damaged[100] ^= 4
    path.write_bytes(damaged)
    with pytest.raises(InputError, match=r"fig01.png: damaged: its bytes"):
        publishing.publish(finished, tmp_path / "docs")


def test_a_large_run_loses_colours(finished, tmp_path, monkeypatch):
    before = publishing.size(publishing.publish(finished, tmp_path / "docs"))
    monkeypatch.setattr(publishing, "LIMIT", before - 2000)
    folder = publishing.publish(finished, tmp_path / "docs")
    pictures = (publishing.size(each / "figures") for each in (folder, finished))
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
    assert not (tmp_path / "docs" / "paper").exists()


def test_readme_has_the_numbers_of_the_published_run():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    _, _, rest = text.partition(f"{publishing.BEGIN}\n")
    written, end, _ = rest.partition(publishing.END)
    assert end
    place = Path(publishing.PLACE)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        assert written == publishing.block(place), "`beltrepro publish` writes it"


FOUND = publishing.WORDS["found"]
AS_SAID = {name: verdict for entry in FOUND for name, verdict in entry["rests_on"].items()}


@pytest.fixture
def judged(tmp_path, monkeypatch):
    """Publishes made-up tables of a run with these verdicts, and gives the block of README.md."""
    monkeypatch.chdir(tmp_path)

    def block(name="paper", **verdicts):
        folder = Path("docs") / "results" / name
        made_up_results.write(folder, dict.fromkeys(load_ledger(), "holds") | AS_SAID | verdicts)
        return publishing.block(), read(folder)

    return block


def test_the_block_takes_its_numbers_from_the_tables(judged):
    text, results = judged()
    for name, number in (("u-critical", "critical"), ("r-jump", "ratio")):
        assert f" {results[name].counted.numbers[number].words} |" in text
    assert text.count("\n| ") == len(publishing.WORDS["numbers"]) + 2  # and the head
    assert "| exponent of slip sizes | −1.47 | " in text and "| 0.132 | " in text  # as printed
    assert text.count("\n- ") + text.startswith("- ") == len(FOUND)
    assert f"Of {count(results).testable} statements" in text
    assert "docs/results/paper/report.html" in text


@pytest.mark.parametrize("name", AS_SAID)
def test_a_sentence_whose_verdict_is_another_is_refused(judged, name):
    other = "fails" if AS_SAID[name] == "holds" else "holds"
    with pytest.raises(InputError, match=f"{name} must be '{AS_SAID[name]}'.* is '{other}'"):
        judged(**{name: other})
    shutil.rmtree("docs")
    text, _ = judged("standard", **{name: other})  # of another run it is left out
    assert text.count("\n- ") + text.startswith("- ") == len(FOUND) - 1


def test_the_command_writes_the_block(finished, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(publishing.WORDS, "found", [])
    Path("README.md").write_text(f"before\n{publishing.BEGIN}\nOLD\n{publishing.END}\nafter\n")
    assert cli.main(["publish", str(finished)]) == 0
    text = Path("README.md").read_text()
    assert text.startswith("before\n") and text.endswith(f"{publishing.END}\nafter\n")
    assert "OLD" not in text and publishing.block() in text


def test_a_page_without_marks_is_refused(tmp_path):
    (tmp_path / "README.md").write_text("nothing")
    with pytest.raises(InputError, match="lacks"):
        publishing.write_block(tmp_path / "README.md", tmp_path)
    assert (tmp_path / "README.md").read_text() == "nothing"

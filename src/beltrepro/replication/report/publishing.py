"""Results of a run published in the repository, in `docs/results`: what there is to be read.

README.md has a block of what was found, with the main numbers. It is written from the published
tables.
"""

import base64
import io
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from PIL import Image

from beltrepro.base import seal
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import manifest
from beltrepro.replication.report.claim_results import Results, count, read
from beltrepro.replication.report.sentences import filled, place_of, typeset
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, PARTLY, UNDECIDED
from beltrepro.replication.verdicts.ledger import load_ledger, read_yaml

PLACE = Path("docs/results")
LIMIT = 20_000_000  # bytes of a published run, as repositories and their readers bear them
FILES = ("report.html", "article.pdf", "claims.csv", "estimates.csv")
FIRST = ("paper", "standard", "smoke")  # the run that README.md shows: the first that is published
BEGIN, END = "<!-- results: written by `make publish` -->", "<!-- end of results -->"

WORDS = read_yaml("beltrepro.replication.report", "readme.yaml")


def publish(results: Path, place: Path = PLACE) -> Path:
    """Copy what a finished run shows, with a list of checksums.

    The report shows the pictures in the folder `figures` instead of holding them a second time. PNG
    files lose colours if all is larger than `LIMIT` otherwise.
    """
    target, wanted = place / results.name, _wanted(results)
    place.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=place) as name:
        folder = Path(name) / target.name
        for path in wanted:
            (folder / path.parent).mkdir(parents=True, exist_ok=True)
            shutil.copyfile(results / path, folder / path)
        _link_pictures(folder)
        if size(folder) > LIMIT:
            _take_colours(folder)
        if size(folder) > LIMIT:
            raise InputError(
                f"{results}: {size(folder) / 1e6:.1f} MB, at most {LIMIT / 1e6:.0f} are published"
            )
        _list(folder)
        if target.exists():
            shutil.rmtree(target)
        folder.rename(target)
    return target


def write_block(readme: Path, place: Path = PLACE) -> None:
    """Write the block of results in a page anew."""
    text = readme.read_text(encoding="utf-8")
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise InputError(f"{readme}: lacks {BEGIN} or {END}")
    with replacing(readme) as unfinished:
        unfinished.write_text(f"{before}{BEGIN}\n{block(place)}{END}{after}", encoding="utf-8")


def block(place: Path = PLACE) -> str:
    """The block of results, as Markdown."""
    for name in FIRST:
        if (place / name / "claims.csv").is_file():
            return "\n".join([*_block(place / name), ""])
    return "No run is published yet: `make publish RUN=paper` does it.\n"


def size(folder: Path) -> int:
    """Bytes of all files below a folder."""
    return sum(path.stat().st_size for path in _files(folder))


def _block(folder: Path) -> Iterator[str]:
    results = read(folder)
    counts = count(results)
    number = counts.by_verdict
    for entry in WORDS["found"]:
        if sentence := _found(**entry, results=results, strict=folder.name == FIRST[0]):
            yield f"- {sentence}"
    yield ""
    yield "| | printed | measured (95 %) |"
    yield "| --- | --- | --- |"
    for entry in WORDS["numbers"]:
        if measured := filled(f"{{{entry['place']}}}", results):
            claim, name = place_of(entry["place"])
            paper = load_ledger()[claim].paper
            value = paper.get(name) if isinstance(paper, dict) else paper
            printed = entry.get("printed") or typeset(f"{value:g}")
            yield f"| {entry['what']} | {printed} | {measured} |"
    yield ""
    yield (
        f"Of {counts.testable} statements that can be tested {number[HOLDS]} hold, "
        f"{number[PARTLY]} hold in part, {number[FAILS]} fail, and {number[UNDECIDED]} stay open: "
        f"[report]({folder}/report.html), [article]({folder}/article.pdf)."
    )


def _found(text: str, rests_on: dict[str, str], results: Results, *, strict: bool) -> str | None:
    """A sentence on what was found; if a verdict on which it rests is another: None or an error."""
    for name, verdict in rests_on.items():
        if results[name].verdict != verdict:
            if strict:
                raise InputError(
                    f"README.md would say {text!r}: {name} must be {verdict!r} for that, and "
                    f"is {results[name].verdict!r}; change readme.yaml beside publishing.py"
                )
            return None
    return filled(text, results)


def _wanted(results: Path) -> list[Path]:
    """Whole files of a finished run, by their paths below it."""
    figures = sorted((results / "figures").glob("*.png"))
    missing = [name for name in FILES if not (results / name).is_file()]
    if missing or not figures:
        raise InputError(
            f"{results}: {', '.join(missing) or 'no figures'}: not there; "
            f"`snakemake --cores 2 --config preset={results.name}` makes it"
        )
    paths = [*(results / name for name in FILES), *figures]
    for path in paths:
        seal.check(path)
    return [path.relative_to(results) for path in paths]


def _link_pictures(folder: Path) -> None:
    """The report with links to the files of its pictures in place of their bytes."""
    page = folder / "report.html"
    text = page.read_text(encoding="utf-8")
    for path in (folder / "figures").glob("*.png"):
        embedded = base64.b64encode(path.read_bytes()).decode()
        text = text.replace(f"data:image/png;base64,{embedded}", f"figures/{path.name}")
    page.write_text(text, encoding="utf-8")


def _take_colours(folder: Path) -> None:
    """Give each picture a palette, where that makes it smaller."""
    for path in (folder / "figures").glob("*.png"):
        smaller = io.BytesIO()
        with Image.open(path) as image:
            palette = image.convert("RGB").quantize(256, dither=Image.Dither.NONE)
            palette.save(smaller, format="PNG", optimize=True)
        path.write_bytes(min(path.read_bytes(), smaller.getvalue(), key=len))


def _list(folder: Path) -> None:
    lines = [
        manifest.line(seal.digest_of(path), path.relative_to(folder).as_posix())
        for path in _files(folder)
    ]
    (folder / manifest.NAME).write_text("".join(lines), encoding="utf-8")


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())

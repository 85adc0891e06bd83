"""Results of a run published in the repository, in `docs/results`: what there is to be read.

README.md has a block with their main numbers, the claims that do not hold, and some figures. It is
written from the published tables.
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
from beltrepro.replication.plan import manifest, registry
from beltrepro.replication.report.claim_results import Results, count, read, with_verdict
from beltrepro.replication.report.findings import findings_of
from beltrepro.replication.report.sentences import filled, place_of, typeset
from beltrepro.replication.verdicts.criteria import FAILS, PARTLY, UNDECIDED
from beltrepro.replication.verdicts.ledger import load_ledger

PLACE = Path("docs/results")
LIMIT = 20_000_000  # bytes of a published run, as repositories and their readers bear them
COLOURS = 256
FILES = ("report.html", "article.pdf", "claims.csv", "estimates.csv")
FIRST = ("paper", "standard", "smoke")  # the run that README.md shows: the first that is published
BEGIN, END = "<!-- results: written by `make publish` -->", "<!-- end of results -->"

SHIFT = "method-independence: mean shift"

# Numbers in README.md: what it is, its place (see `sentences`), and what the paper says where it
# prints no number of this name.
HEADLINE = (
    ("critical velocity without noise, five blocks", "u-critical: critical", ""),
    ("factor by which r falls there", "r-jump: ratio", "6.5"),
    ("share of permanent chaos at u ≤ 15, outside the windows", "permanent-chaos", "1"),
    ("critical velocity at σ = 2.2", "uc-sigma22: u_c", ""),
    ("σ at which r rises at u = 7", "sigma-c-u7: sigma_c", ""),
    ("exponent of the spectrum at u = 1", "spectrum-exponent: exponent", ""),
    ("exponent of slip sizes", "slip-size-exponent", ""),
    ("exponent of dissipated energies", "slip-energy-exponent", ""),
    ("r at 0.22 m/s", "r-experiment: r_022", ""),
    ("r at 0.28 m/s", "r-experiment: r_028", ""),
    ("ln r by exact integration less ln r by the scheme, with noise", f"{SHIFT}, with noise", "0"),
    ("the same without noise", f"{SHIFT}, without noise", "0"),
)

GALLERY = ("fig12", "fig13", "fig17", "fig18", "fig16", "fig19", "fig09", "fig10")
ACROSS = 2  # pictures in a row of the gallery


def publish(results: Path, place: Path = PLACE) -> Path:
    """Copy what a finished run shows, with a list of checksums.

    The report shows the pictures in the folder `figures` instead of holding them a second time. PNG
    files lose colours if all is larger than `LIMIT` otherwise.
    """
    target = place / results.name
    place.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=place) as name:
        folder = Path(name) / target.name
        _copy(results, folder)
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
    yield (
        f"The preset `{folder.name}` tests {counts.testable} claims of the paper: "
        f"{number['holds']} hold, {number['partly']} hold in part, {number['fails']} fail. "
        f"Undecided: {number['undecided']}, not measured: {number['not measured']}."
    )
    yield f"See the [report]({folder}/report.html) and the [article]({folder}/article.pdf)."
    yield ""
    yield from (f"- {finding.heading}" for finding in findings_of(results))
    yield ""
    yield "| | printed | measured (95 %) |"
    yield "| --- | --- | --- |"
    for what, place, said in HEADLINE:
        if measured := filled(f"{{{place}}}", results):
            yield f"| {what} | {said or _printed(place)} | {measured} |"
    yield from _claims("These claims fail", FAILS, results)
    yield from _claims("These hold in part", PARTLY, results)
    if undecided := [f"`{result.id}`" for result in with_verdict(results, UNDECIDED)]:
        yield ""
        yield f"Undecided are {', '.join(undecided)}. The report says what would decide them."
    yield from _gallery(folder)


def _printed(place: str) -> str:
    """What the paper prints for a number."""
    claim, name = place_of(place)
    paper = load_ledger()[claim].paper
    return typeset(f"{paper[name] if isinstance(paper, dict) else paper:g}")


def _claims(heading: str, verdict: str, results: Results) -> Iterator[str]:
    """A list of the claims with a verdict: what is claimed, and which numbers speak against it."""
    claims = with_verdict(results, verdict)
    if claims:
        yield from ("", f"{heading}:", "")
    for result in claims:
        reason = typeset(result.counted.reason or result.counted.said).rstrip(".")
        yield f"- *{result.claim.statement}* Measured: {reason} (`{result.id}`)."


def _gallery(folder: Path) -> Iterator[str]:
    """A table of pictures, each a link to its file."""
    paths = {name: folder / "figures" / f"{name}.png" for name in GALLERY}
    cells = [
        f"[![{entry.alt}]({paths[name]})]({paths[name]})<br>Fig. {entry.number}: {entry.title}"
        for name, entry in registry.figures().items()
        if name in paths and paths[name].is_file()
    ]
    for first in range(0, len(cells), ACROSS):
        row = [*cells[first : first + ACROSS], ""][:ACROSS]
        if first == 0:
            yield from ("", "| " * ACROSS + "|", "| --- " * ACROSS + "|")
        yield f"| {' | '.join(row)} |"


def _copy(results: Path, folder: Path) -> None:
    (folder / "figures").mkdir(parents=True)
    figures = sorted((results / "figures").glob("*.png"))
    wanted = [results / name for name in FILES]
    missing = [path.name for path in wanted if not path.is_file()]
    if missing or not figures:
        raise InputError(
            f"{results}: {', '.join(missing) or 'no figures'}: not there; "
            f"`snakemake --cores 2 --config preset={results.name}` makes it"
        )
    for path in wanted:
        shutil.copyfile(path, folder / path.name)
    for path in figures:
        shutil.copyfile(path, folder / "figures" / path.name)


def _link_pictures(folder: Path) -> None:
    """The report with links to the files of its pictures in place of their bytes."""
    page = folder / "report.html"
    text = page.read_text(encoding="utf-8")
    for path in (folder / "figures").glob("*.png"):
        embedded = base64.b64encode(path.read_bytes()).decode()
        text = text.replace(f"data:image/png;base64,{embedded}", f"figures/{path.name}")
    page.write_text(text, encoding="utf-8")


def _take_colours(folder: Path) -> None:
    for path in (folder / "figures").glob("*.png"):
        path.write_bytes(_fewer_colours(path.read_bytes()))


def _fewer_colours(picture: bytes) -> bytes:
    """The picture with a palette, if that makes it smaller."""
    smaller = io.BytesIO()
    with Image.open(io.BytesIO(picture)) as image:
        image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(
            smaller, format="PNG", optimize=True
        )
    return min(picture, smaller.getvalue(), key=len)


def _list(folder: Path) -> None:
    lines = [
        manifest.line(seal.digest_of(path), path.relative_to(folder).as_posix())
        for path in _files(folder)
    ]
    (folder / manifest.NAME).write_text("".join(lines), encoding="utf-8")


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())

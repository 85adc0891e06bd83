"""Results of a run published in the repository, in `docs/results`: what there is to be read.

README.md has a block of what was found, with the main numbers. It is written from the published
tables.
"""

import base64
import shutil
import sys
import tempfile
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import yaml
from PIL import Image

from beltrepro.base import seal
from beltrepro.base.atomic import UNFINISHED, replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import io
from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.report import article, findings
from beltrepro.replication.report.claim_results import count, read
from beltrepro.replication.verdicts.criteria import QUESTIONS, VERDICTS

PLACE = Path("docs/results")
LIMIT = 20_000_000  # bytes of a published run, as repositories and their readers bear them
REPORT_LIMIT = 12_000_000  # bytes of a page that is sent or downloaded alone
FILES = ("report.html", "claims.csv", "estimates.csv")
ARTICLE = "article.pdf"
FIRST = ("paper", "standard", "smoke")  # the run that README.md shows: the first that is published
_CONFIG, _CITATION = Path("config.yaml"), Path("CITATION.cff")
BEGIN, END = "<!-- results: written by `make publish` -->", "<!-- end of results -->"


def publish(results: Path, place: Path = PLACE) -> Path:
    """Copy what a finished run shows, once each file agrees with its seal.

    The report is one file that holds its pictures, with a palette of colours where that makes them
    smaller. The article is about the run `paper` and set here; that run is refused where a sentence
    of the findings or of the article does not hold in it.
    """
    target, wanted = place / results.name, _wanted(results)
    place.mkdir(parents=True, exist_ok=True)
    for left in place.glob(f"{UNFINISHED}*"):  # by a kill
        shutil.rmtree(left)
    with tempfile.TemporaryDirectory(dir=place, prefix=UNFINISHED) as name:
        folder = Path(name) / target.name
        for path in wanted:
            (folder / path.parent).mkdir(parents=True, exist_ok=True)
            shutil.copyfile(results / path, folder / path)
        if results.name == FIRST[0]:
            findings.check(read(results))
            _set_article(results, folder / ARTICLE)
        _take_colours(folder)
        if (folder / FILES[0]).stat().st_size > REPORT_LIMIT:
            raise InputError(f"{results / FILES[0]}: larger than {REPORT_LIMIT / 1e6:.0f} MB")
        if size(folder) > LIMIT:
            raise InputError(
                f"{results}: {size(folder) / 1e6:.1f} MB, at most {LIMIT / 1e6:.0f} are published"
            )
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
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def _block(folder: Path) -> Iterator[str]:
    results = read(folder)
    for finding in findings.findings_of(results):
        if not finding.unmet:
            yield f"- {finding.text}"
    yield ""
    yield "| | printed | replicated (95 %) | robust (95 %) |"
    yield "| --- | --- | --- | --- |"
    for cells in findings.printed_and_measured(results):
        yield f"| {' | '.join(cells)} |"
    counts = count(results)
    yield ""
    yield "Where the last cell is empty, both verdicts rest on the same number."
    yield ""
    yield (
        f"The paper makes {counts.total} statements that a simulation could refute. *In part*: one "
        "number holds and another does not. *Open*: the runs do not tell."
    )
    yield ""
    yield f"| | {' | '.join(VERDICTS)} |"
    yield "| --- |" + " --- |" * len(VERDICTS)
    for question in QUESTIONS:
        numbers = (str(counts.verdicts[question][word]) for word in VERDICTS)
        yield f"| {question} | {' | '.join(numbers)} |"
    yield ""
    pages = {"Report": "report.html", "article": ARTICLE}
    there = {name: path for name, path in pages.items() if (folder / path).is_file()}
    if there:
        links = ", ".join(f"[{name}]({folder}/{path})" for name, path in there.items())
        yield f"{links} (download the report and open it)."


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


def _set_article(results: Path, output: Path) -> None:
    """Of a run of this clone, with the authors that CITATION.cff names."""
    settings = make_plan(load_config(_CONFIG) | {"preset": results.name}).settings()
    citation = yaml.safe_load(_CITATION.read_text(encoding="utf-8"))
    claims = read(results)
    article.write(
        output,
        claims,
        article.facts(claims, settings, io.said(results / "claims.csv")),
        {path.stem: path for path in (results / "figures").glob("*.png")},
        [article.name_of(author) for author in citation["authors"]],
    )
    seal.put(output)


def _take_colours(folder: Path) -> None:
    """Give each picture a palette, where that makes it smaller, in its file and in the report."""
    page = folder / FILES[0]
    text = seal.content(page)
    for path in (folder / "figures").glob("*.png"):
        smaller, before = BytesIO(), path.read_bytes()
        with Image.open(path) as image:
            palette = image.convert("RGB").quantize(256, dither=Image.Dither.NONE)
            palette.save(smaller, format="PNG", optimize=True)
        if len(smaller.getvalue()) < len(before):
            path.write_bytes(smaller.getvalue())
            seal.put(path)
        text = text.replace(_embedded(before), _embedded(path.read_bytes()))
    page.write_text(text, encoding="utf-8")
    seal.put(page)


def _embedded(picture: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(picture).decode()}"


def main(results: str) -> None:
    """Publish a run and write its numbers into README.md: `make publish`."""
    try:
        published = publish(Path(results))
        write_block(Path("README.md"))
    except InputError as error:
        sys.exit(f"error: {error}")
    print(f"{published}: {size(published) / 1e6:.1f} MB; README.md has its numbers")


if __name__ == "__main__":
    main(*sys.argv[1:])

"""A finished run published in the repository, in `docs/results`: what there is to be read.

The run `paper` has an article, and its main numbers stand in a block of README.md.
"""

import json
import math
import shutil
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

import typst

from beltrepro.base import seal
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import io, registry
from beltrepro.replication.report import excerpts, findings
from beltrepro.replication.report.claim_results import Results, count, read, statements
from beltrepro.replication.verdicts.criteria import QUESTIONS

PLACE = Path("docs/results")
SHOWN = "paper"  # the run that article and README.md tell of
FILES = ("report.html", "claims.csv", "estimates.csv")
BESIDE = ("figures/*.png", "tables/*.csv", "experiment/*.csv")
ARTICLE = Path("docs/article/article.typ")
BEGIN, END = "<!-- results: written by `make publish` -->", "<!-- end of results -->"


def publish(results: Path, place: Path = PLACE) -> Path:
    """Copy what a finished run shows, once each file agrees with its seal.

    The run `paper` is refused where a sentence of the findings or of the article does not hold.
    """
    beside = (path for pattern in BESIDE for path in results.glob(pattern))
    names = [*FILES, *sorted(path.relative_to(results).as_posix() for path in beside)]
    for name in names:
        seal.check(results / name)
    article = set_article(results) if results.name == SHOWN else b""
    drawn = excerpts.excerpts(results)
    target = place / results.name
    shutil.rmtree(target, ignore_errors=True)
    for name in names:
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(results / name, target / name)
    excerpts.write(drawn, target)
    if article:
        (target / "article.pdf").write_bytes(article)
        seal.put(target / "article.pdf")
    return target


def set_article(run: Path) -> bytes:
    """The article as PDF/UA (tagged for screen readers): article.typ reads the tables of the run.

    It is told the words of numbers and the captions of the report; a sentence that the run does not
    bear out stops it.
    """
    results = read(run)
    findings.check(results)
    about = io.said(run / "claims.csv")
    content = {
        "run": f"/{run.absolute().relative_to(Path.cwd())}",
        "simulated": _by_version(about["sources"]),
        "judged": about["code_version"],
        "kinds": {result.id: result.claim.kind for result in results.values()},
        "numbers": dict(_numbers(results)),
        "fall": [one.parts for one in findings.findings_of(results, findings.WHY)],
        "columns": findings.words()["columns"],
        "measured": list(findings.printed_and_measured(results)),
        "figures": {name: vars(figure) for name, figure in registry.figures().items()},
    }
    try:
        return typst.compile(
            ARTICLE,
            root=Path.cwd(),
            ignore_system_fonts=True,
            pdf_standards=["ua-1"],
            sys_inputs={"content": json.dumps(content)},
        )
    except typst.TypstError as error:
        raise InputError(f"{ARTICLE}: {error}") from None


def _by_version(sources: dict[str, dict[str, str]]) -> list[tuple[str, list[str]]]:
    """Versions of the code, each with the datasets that it simulated; that of most first."""
    datasets = defaultdict(list)
    for name, source in sources.items():
        datasets[source["code_version"]].append(name)
    return sorted(datasets.items(), key=lambda made: -len(made[1]))


def _numbers(results: Results) -> Iterator[tuple[str, str]]:
    """Each number of a run in words, by its place in sentences."""
    for result in results.values():
        for prefix, answer in zip(("", "robust "), result.answers.values(), strict=True):
            for name, number in answer.numbers.items():
                for form in ("", "value ", "percent ", "count "):
                    place = f"{form}{prefix}{result.id}: {name}"
                    if not math.isnan(number.estimate.value):
                        yield place, findings.filled(f"{{{place}}}", results)


def block(folder: Path) -> str:
    """The results of a published run, as Markdown."""
    results = read(folder)
    words, counts = findings.words(), count(results)
    texts = [one.text for one in findings.findings_of(results) if not one.unmet]
    about = io.said(folder / "claims.csv")
    versions = ", ".join(version for version, _ in _by_version(about["sources"]))
    lines = [
        words["ways"],
        "",
        *texts[:1],
        "",
        *(f"- {text}" for text in texts[1:]),
        "",
        _row(words["columns"]),
        _row(["---"] * len(words["columns"])),
        *map(_row, findings.printed_and_measured(results)),
        "",
        words["below"],
        "",
        f"The paper makes {len(statements(results))} statements that could come out otherwise. "
        f"{'; '.join(_counted(one, counts[one]) for one in QUESTIONS)}. "
        f"All of them: [report]({folder}/report.html) (download it), "
        f"[article]({folder}/article.pdf), by one run of `make paper`, simulated by {versions}.",
    ]
    return "\n".join([*lines, ""])


def _counted(question: str, verdicts: dict[str, int]) -> str:
    """How many statements have each verdict."""
    return f"*{question.capitalize()}*: {', '.join(f'{n} {word}' for word, n in verdicts.items())}"


def _row(cells: Iterable[object]) -> str:
    """A row of a table in Markdown."""
    return f"| {' | '.join(map(str, cells))} |"


def write_block(readme: Path, folder: Path) -> None:
    """Write the block of results in a page anew."""
    before, begin, rest = readme.read_text(encoding="utf-8").partition(f"{BEGIN}\n")
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise InputError(f"{readme}: lacks {BEGIN} or {END}")
    with replacing(readme) as unfinished:
        unfinished.write_text(f"{before}{begin}{block(folder)}{end}{after}", encoding="utf-8")


def main(results: str) -> None:
    """Publish a run, and write the numbers of the run `paper` into README.md: `make publish`."""
    try:
        folder = publish(Path(results))
        if folder.name == SHOWN:
            write_block(Path("README.md"), folder)
    except InputError as error:
        sys.exit(f"error: {error}")
    print(folder)


if __name__ == "__main__":
    main(*sys.argv[1:])

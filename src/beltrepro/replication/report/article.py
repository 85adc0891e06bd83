"""The article about the run `paper`, as PDF: prose in article.typ, numbers and verdicts of the run.

Each sentence that rests on a verdict, or on where a number lies, says so beside it. If the run does
not have it, the article is refused, and the sentence is named.
"""

import json
import re
import shutil
import tempfile
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import typst

from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import registry
from beltrepro.replication.report.claim_results import Answer, Result, Results, count
from beltrepro.replication.report.findings import missed, printed_and_measured
from beltrepro.replication.report.sentences import filled, typeset
from beltrepro.replication.report.trust import DECIDING, dated, dates
from beltrepro.replication.verdicts import ledger

KEYWORDS = ("spring-block model", "stick-slip motion", "avalanches", "chaos", "replication")
PROSE, SOURCES = "article.typ", "references.bib"
_ROOM = "beltrepro.replication.report"
_PLACE = re.compile(r'#number\("(.+?)"\)')
_FIGURE = re.compile(r'#picture\("(.+?)"')
_RESTS = re.compile(r'#rests-on\("(.+?)", "(.+?)", "(.+?)"\)')
_LIES = re.compile(r'#lies\("(.+?)", (\S+?), (\S+?)\)')


def write(
    output: Path,
    results: Results,
    about: Mapping[str, str],
    figures: Mapping[str, Path],
    authors: list[str],
) -> None:
    """Set the article as PDF/UA (tagged for screen readers); the same content, the same bits.

    about : facts of the run, by name; figures : pictures by name; InputError for the first sentence
    that does not hold.
    """
    prose = text()
    refuse_what_does_not_hold(prose, results)
    content = {
        "title": "[Re] Chaos on the conveyor belt",
        "authors": authors,
        "keywords": list(KEYWORDS),
        "numbers": numbers_in(prose, results, about),
        "figures": {name: _about(name, figures) for name in _FIGURE.findall(prose)},
        "measured": list(printed_and_measured(results)),
        **supplement(results),
    }
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)  # all that the typesetter sees
        for path in (PROSE, SOURCES):
            (folder / path).write_bytes(resources.files(_ROOM).joinpath(path).read_bytes())
        (folder / "content.json").write_text(json.dumps(content), encoding="utf-8")
        for figure in content["figures"]:
            shutil.copyfile(figures[figure], folder / f"{figure}{figures[figure].suffix}")
        pdf = typst.compile(
            folder / PROSE, root=folder, ignore_system_fonts=True, pdf_standards=["ua-1"]
        )
    with replacing(output) as unfinished:
        unfinished.write_bytes(pdf)


def text() -> str:
    """The article as it is written."""
    return resources.files(_ROOM).joinpath(PROSE).read_text(encoding="utf-8")


def refuse_what_does_not_hold(prose: str, results: Results) -> None:
    """Raise InputError for the first sentence whose conditions a run does not meet."""
    for line in prose.splitlines():
        lies = [(place, [float(low), float(high)]) for place, low, high in _LIES.findall(line)]
        if reasons := list(missed(results, _RESTS.findall(line), lies)):
            raise InputError(
                f"{_read(line)!r} is not what this run found: {'; '.join(reasons)}; "
                f"change {PROSE} in {_ROOM.replace('.', '/')}"
            )


def _read(line: str) -> str:
    """A line of the prose without its markup, and with the names of its numbers."""
    for markup, words in (
        (_RESTS, ""),
        (_LIES, ""),
        (_PLACE, r"{\1}"),
        (re.compile(r"#m\(\$(.*?)\$\)"), r"\1"),
    ):
        line = markup.sub(words, line)
    return line.strip()


def numbers_in(prose: str, results: Results, about: Mapping[str, str]) -> dict[str, str]:
    """Words of each number and fact that the prose asks for, by its place."""
    words = {place: filled(f"{{{place}}}", results, about) for place in _PLACE.findall(prose)}
    missing = [place for place, number in words.items() if number is None]
    if missing:
        raise InputError(f"{PROSE} asks for what this run does not have: {'; '.join(missing)}")
    return {place: number for place, number in words.items() if number is not None}


def facts(
    results: Results, settings: Mapping[str, Any], origin: Mapping[str, Any]
) -> dict[str, str]:
    """Facts of a run as short texts by name: counts of verdicts, lengths, version of the code."""
    counts = count(results)
    about = {"testable": str(counts.testable), "code_version": origin["code_version"]}
    for question, numbers in counts.verdicts.items():
        about |= {f"{question} {verdict}": str(number) for verdict, number in numbers.items()}
    deciding = settings["datasets"][DECIDING]
    runs = str(len(deciding["replicate"]))
    if more := deciding.get("more_runs"):
        runs += f" to {more['up_to']}"
    return about | {"replicates": runs, "duration": f"{float(deciding['duration']):,.0f}"}


def supplement(results: Results) -> dict[str, Any]:
    """What stands in the table of all statements, and how the criteria came to be."""
    findings = [result for result in results.values() if result.claim.finding]
    return {
        "dates": dates(results),
        "after": [result.id for result in dated(results, ledger.SEEN[-1])],
        "claims": [_row(result) for result in findings],
        "apart": [
            {"id": result.id, "kind": result.claim.kind, "verdict": result.verdicts["replicated"]}
            for result in results.values()
            if not result.claim.finding
        ],
    }


def name_of(author: Mapping[str, str]) -> str:
    """Name of an author of CITATION.cff, a person or a group."""
    parts = (author.get("given-names"), author.get("family-names"))
    return author.get("name") or " ".join(filter(None, parts))


def _about(name: str, figures: Mapping[str, Path]) -> dict[str, str]:
    if name not in figures:
        raise InputError(f"{PROSE} shows {name}, of which this run has no picture")
    return {"alt": registry.figures()[name].alt, "ending": figures[name].suffix}


def _row(result: Result) -> dict[str, Any]:
    """A row of the table of claims; numbers once where both questions judge the same ones."""
    numbers = {question: _numbers(answer) for question, answer in result.answers.items()}
    about = {"id": result.id, "figure": str(result.claim.figure or ""), **result.verdicts}
    return about | {"numbers": _once({name: words for name, words in numbers.items() if words})}


def _once(texts: dict[str, str]) -> dict[str, str]:
    """Texts by question; one without a question if all are the same."""
    same = len(texts) > 1 and len({*texts.values()}) == 1
    return {"": next(iter(texts.values()))} if same else texts


def _numbers(answer: Answer) -> str:
    """The numbers that decide, with the ranges that are allowed."""
    numbers = (f"{n.name} {n.words} [{n.allowed_words}]" for n in answer.judged)
    return typeset("; ".join(numbers))

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
from beltrepro.replication.verdicts.criteria import NOT_TESTABLE, OPEN, YES, range_in_words

KEYWORDS = ("spring-block model", "stick-slip motion", "avalanches", "chaos", "replication")
PROSE, SOURCES = "article.typ", "references.bib"
# What is counted apart, by its kind in the ledger.
APART = {
    "construction": "True because the model is built so",
    "validation": "Tests of our own camera",
    "explanation": "Explanations of our own",
}
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
    about = {"code_version": origin["code_version"]} | _counts(results)
    deciding = settings["datasets"][DECIDING]
    runs = str(len(deciding["replicate"]))
    return about | {"replicates": runs, "duration": f"{float(deciding['duration']):,.0f}"}


def _counts(results: Results) -> dict[str, str]:
    """How many statements have each verdict, are open, and are replicated and not robust."""
    findings = [result for result in results.values() if result.claim.finding]
    numbers = {"open": sum(OPEN in result.verdicts.values() for result in findings)}
    for question, verdicts in count(results).verdicts.items():
        numbers |= {f"{question} {verdict}": number for verdict, number in verdicts.items()}
        numbers[f"{question} testable"] = sum(verdicts.values()) - verdicts[NOT_TESTABLE]
    dropped = [r for r in findings if r.verdicts["replicated"] == YES != r.verdicts["robust"]]
    asked = [[answer.criterion for answer in result.answers.values()] for result in dropped]
    numbers |= {"dropped": len(dropped), "dropped by the same range": sum(a == b for a, b in asked)}
    return {name: str(number) for name, number in numbers.items()}


def supplement(results: Results) -> dict[str, Any]:
    """What stands in the table of all statements, and how the criteria came to be."""
    findings = [result for result in results.values() if result.claim.finding]
    return {
        "dates": dates(results),
        "before": [_statement(result) for result in dated(results, *ledger.SEEN[:-1])],
        "claims": [_row(result) for result in findings],
        "apart": {
            name: [
                {"statement": _statement(result), "verdict": result.verdicts["replicated"]}
                for result in results.values()
                if result.claim.kind == kind
            ]
            for kind, name in APART.items()
        },
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
    numbers = {
        question: _numbers(answer, result.claim.criteria[question].lenient)
        for question, answer in result.answers.items()
    }
    about = {"statement": _statement(result), "figure": str(result.claim.figure or "")}
    about |= result.verdicts
    return about | {"numbers": _once({name: words for name, words in numbers.items() if words})}


def _statement(result: Result) -> str:
    return typeset(result.claim.statement)


def _once(texts: dict[str, str]) -> dict[str, str]:
    """Texts by question; one without a question if all are the same."""
    same = len(texts) > 1 and len({*texts.values()}) == 1
    return {"": next(iter(texts.values()))} if same else texts


def _numbers(answer: Answer, lenient: Mapping[str, Any]) -> str:
    """The numbers that decide, with what a strict and a lenient reader allow."""
    words = []
    for number in answer.judged:
        ranges = [number.allowed_words]
        if number.name in lenient:
            ranges.append(range_in_words(lenient[number.name]))
        words.append(f"{number.name} {number.words} [{' | '.join(ranges)}]")
    return typeset("; ".join(words))

"""The findings that a reader is told first: templates in `topics.yaml`."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from beltrepro.replication.report.findings.results import Result, Results
from beltrepro.replication.report.findings.sentences import all_filled
from beltrepro.replication.verdicts import packaged
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, PARTLY, UNDECIDED


@dataclass(frozen=True)
class Finding:
    """A finding of a run: claims that belong together, and what came out.

    topic : title that says nothing of the outcome; heading : what was found, by the verdict;
    sentences : numbers and reasons; figure : name of the picture that shows it.
    """

    name: str
    topic: str
    verdict: str
    heading: str
    sentences: tuple[str, ...]
    figure: str
    results: tuple[Result, ...]


def chosen(results: Results) -> list[Finding]:
    """The findings whose claims were all measured, in the words of their verdicts."""
    found = (_finding(template, results) for template in templates())
    return [each for each in found if each is not None]


@functools.cache
def templates() -> tuple[dict[str, Any], ...]:
    """The templates as they stand in the file."""
    return tuple(packaged.read_yaml("beltrepro.replication.report.findings", "topics.yaml"))


def together(results: Iterable[Result]) -> str:
    """Verdict of several claims taken as one: all must hold."""
    grades = {each.verdict for each in results}
    if grades in ({HOLDS}, {FAILS}):
        return grades.pop()
    return PARTLY if grades & {HOLDS, PARTLY} and grades & {FAILS, PARTLY} else UNDECIDED


def _finding(template: dict[str, Any], results: Results) -> Finding | None:
    own = [results[name] for name in template["claims"] if name in results]
    if len(own) < len(template["claims"]) or not all(each.measured for each in own):
        return None
    verdict = together(own)
    sentences = all_filled((_said(each, results) for each in template["sentences"]), results)
    return Finding(
        name=template["name"],
        topic=template["topic"],
        verdict=verdict,
        heading=template["heading"][verdict],
        sentences=tuple(dict.fromkeys(sentences)),
        figure=template["figure"],
        results=tuple(own),
    )


def _said(sentence: str | dict[str, str], results: Results) -> str:
    """A sentence, or that for the verdict of a claim; empty if it has none for it."""
    if isinstance(sentence, str):
        return sentence
    of = results[sentence["of"]].verdict
    return sentence.get(of, "")

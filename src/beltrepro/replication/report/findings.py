"""What a reader is told: findings by templates in `topics.yaml`, and what each figure shows."""

import functools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from beltrepro.replication.report.claim_results import Result, Results
from beltrepro.replication.report.sentences import all_filled, typeset
from beltrepro.replication.verdicts import criteria, ledger
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, PARTLY, UNDECIDED

_BEGINS = {
    HOLDS: "As the paper says",
    PARTLY: "In part as the paper says",
    FAILS: "Not as the paper says",
    UNDECIDED: "Undecided",
    criteria.NOT_MEASURED: "Not measured in this run",
    criteria.NOT_TESTABLE: "Not testable here",
}


@dataclass(frozen=True)
class Finding:
    """A finding of a run: claims that belong together, and what came out."""

    topic: str  # title that says nothing of the outcome
    verdict: str
    heading: str  # what was found, by the verdict
    sentences: tuple[str, ...]  # numbers and reasons
    figure: str  # name of the picture that shows it
    results: tuple[Result, ...]


@functools.cache
def templates() -> tuple[dict[str, Any], ...]:
    """The templates as they stand in the file."""
    return tuple(ledger.read_yaml("beltrepro.replication.report", "topics.yaml"))


def findings_of(results: Results) -> list[Finding]:
    """The findings whose claims were all measured, in the words of their verdicts."""
    return [
        _finding(template, results)
        for template in templates()
        if all(name in results and results[name].measured for name in template["claims"])
    ]


def verdict_of(results: Iterable[Result]) -> str:
    """Verdict of several claims taken as one: all must hold."""
    grades = {result.verdict for result in results}
    if grades in ({HOLDS}, {FAILS}):
        return grades.pop()
    return PARTLY if grades & {HOLDS, PARTLY} and grades & {FAILS, PARTLY} else UNDECIDED


def seen(results: Iterable[Result]) -> list[str]:
    """What a figure shows: a sentence for each verdict that its claims have, with their numbers."""
    results = list(results)
    return [
        f"{begin}: {'; '.join(_with_numbers(result) for result in results_so_judged)}."
        for verdict, begin in _BEGINS.items()
        if (results_so_judged := [result for result in results if result.verdict == verdict])
    ]


def _finding(template: dict[str, Any], results: Results) -> Finding:
    claims = tuple(results[name] for name in template["claims"])
    verdict = verdict_of(claims)
    # of a sentence that depends on the verdict of a claim, the one for this verdict, if any
    sentences = (
        entry if isinstance(entry, str) else entry.get(results[entry["of"]].verdict, "")
        for entry in template["sentences"]
    )
    return Finding(
        topic=template["topic"],
        verdict=verdict,
        heading=template["heading"][verdict],
        sentences=tuple(dict.fromkeys(all_filled(sentences, results))),
        figure=template["figure"],
        results=claims,
    )


def _with_numbers(result: Result) -> str:
    """A claim and the numbers that decided."""
    numbers = ", ".join(f"{n.name} {typeset(n.words)}".strip() for n in result.counted.judged)
    return f"{result.id}, with {numbers}" if numbers else result.id

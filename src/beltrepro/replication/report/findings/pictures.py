"""What a figure shows, in a sentence for each verdict on its claims."""

from collections.abc import Iterable

from beltrepro.replication.report.findings.results import Number, Result
from beltrepro.replication.report.findings.sentences import typeset
from beltrepro.replication.verdicts.criteria import (
    FAILS,
    HOLDS,
    NOT_MEASURED,
    NOT_TESTABLE,
    PARTLY,
    UNDECIDED,
)

_BEGINS = {
    HOLDS: "As the paper says",
    PARTLY: "In part as the paper says",
    FAILS: "Not as the paper says",
    UNDECIDED: "Undecided",
    NOT_MEASURED: "Not measured in this run",
    NOT_TESTABLE: "Not testable here",
}


def seen(results: Iterable[Result]) -> list[str]:
    """Sentences, one for each verdict that the claims have, with the numbers that decided."""
    results = list(results)
    return [
        f"{begin}: {'; '.join(_of(each) for each in results if each.verdict == verdict)}."
        for verdict, begin in _BEGINS.items()
        if any(each.verdict == verdict for each in results)
    ]


def _of(result: Result) -> str:
    numbers = ", ".join(map(_number, result.counted.judged))
    return f"{result.id}, with {numbers}" if numbers else result.id


def _number(number: Number) -> str:
    words = typeset(number.words)
    return f"{number.name} {words}" if number.name else words

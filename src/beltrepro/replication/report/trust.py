"""How far the verdicts of a run can be trusted, in sentences."""

import statistics
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from beltrepro.replication.report.claim_results import OtherRun, Result, Results
from beltrepro.replication.verdicts.criteria import QUESTIONS
from beltrepro.replication.verdicts.ledger import SEEN

PAPER_DURATION, PAPER_TRANSIENT = 2e6, 1e6
DECIDING = "n5_replicates"  # the dataset that most claims rest on


def trust(
    results: Results, settings: Mapping[str, Any], others: Iterable[OtherRun] = ()
) -> Iterator[str]:
    """Sentences on lengths, on how many runs decide, and on what is left open."""
    dataset = settings.get("datasets", {}).get(DECIDING)
    if dataset:
        duration = float(dataset["duration"])
        compared = f"those of the paper t = {length(PAPER_DURATION)}"
        if duration >= PAPER_DURATION:
            compared = "as long as those of the paper"
        yield f"The runs that most verdicts rest on last t = {length(duration)}, {compared}."
    findings = [result for result in results.values() if result.claim.finding]
    answers = [answer for result in findings for answer in result.answers.values()]
    numbers = [number.estimate.runs for answer in answers for number in answer.judged]
    runs = [count for count in numbers if count is not None]
    if runs:
        yield (
            f"A number that decides rests on {statistics.median_low(runs)} independent runs "
            f"(median; {min(runs)} to {max(runs)})."
        )
    for other in others:
        for question in QUESTIONS:
            both, alike, opposed = other.agreement(results, question)
            yield (
                f"The run {other.name} decides {both} of the same statements as {question}: "
                f"{alike} alike, {opposed or 'none'} the other way round."
            )


def dates(results: Results) -> str:
    """How many criteria were written after what had been seen, as a sentence."""
    seen = Counter(result.claim.seen for result in dated(results))
    numbers = [seen[name] or "none" for name in SEEN]
    return (
        f"The criteria are no predictions. Of {seen.total()} statements that can be tested, "
        f"{numbers[3]} have criteria that were written or last changed after the published run had "
        f"been seen, {numbers[2]} after long trial runs, {numbers[1]} after short ones and "
        f"{numbers[0]} before any run."
    )


def dated(results: Results, *seen: str) -> list[Result]:
    """The statements that can be tested, by the most that had been seen when they were judged."""
    return [
        result
        for result in results.values()
        if result.claim.finding and result.claim.testable
        if not seen or result.claim.seen in seen
    ]


def length(value: float) -> str:
    """A duration as short text: 40000, 2e6."""
    return f"{value:.3g}".replace("e+0", "e").replace("e+", "e") if value >= 1e6 else f"{value:g}"

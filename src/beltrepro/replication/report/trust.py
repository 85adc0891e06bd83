"""How far the verdicts of a run can be trusted, in sentences."""

import statistics
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from beltrepro.replication.report.claim_results import Results, with_verdict
from beltrepro.replication.report.readings import OtherRun
from beltrepro.replication.verdicts.criteria import NOT_MEASURED, UNDECIDED

PAPER_DURATION, PAPER_TRANSIENT = 2e6, 1e6
DECIDING = "n5_replicates"  # the dataset that most claims rest on


def trust(
    results: Results, settings: Mapping[str, Any], others: Iterable[OtherRun] = ()
) -> Iterator[str]:
    """Sentences on lengths, on how many runs decide, and on what is left undecided."""
    dataset = settings.get("datasets", {}).get(DECIDING)
    if dataset:
        duration = float(dataset["duration"])
        compared = f"those of the paper t = {length(PAPER_DURATION)}"
        if duration >= PAPER_DURATION:
            compared = "as long as those of the paper"
        yield f"The runs that most verdicts rest on last t = {length(duration)}, {compared}."
    numbers = [number for result in results.values() for number in result.counted.judged]
    runs = [number.estimate.runs for number in numbers if number.estimate.runs is not None]
    if runs:
        yield (
            f"A number that decides rests on {statistics.median_low(runs)} independent runs "
            f"(median; {min(runs)} to {max(runs)})."
        )
    if numbers:
        undecided = sum(number.verdict == UNDECIDED for number in numbers)
        yield (
            f"Of {len(numbers)} numbers that decide, {undecided} are undecided: their 95 % "
            "intervals cover an end of the allowed range."
        )
    if missing := [result.id for result in with_verdict(results, NOT_MEASURED)]:
        yield f"Not measured: {', '.join(missing)}."
    for other in others:
        yield f"{other.same} of {len(other.verdicts)} verdicts are those of the run {other.name}."


def length(value: float) -> str:
    """A duration as short text: 40000, 2e6."""
    return f"{value:.3g}".replace("e+0", "e").replace("e+", "e") if value >= 1e6 else f"{value:g}"

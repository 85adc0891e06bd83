"""How far the verdicts of a run can be trusted, in sentences."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Mapping
from typing import Any

from beltrepro.replication.report.findings.presets import Comparison
from beltrepro.replication.report.findings.results import Results
from beltrepro.replication.verdicts.criteria import NOT_MEASURED, UNDECIDED

PAPER_DURATION = 2e6
DECIDING = "n5_replicates"  # the dataset that most claims rest on


def trust(
    results: Results, settings: Mapping[str, Any], comparison: Comparison | None = None
) -> list[str]:
    """Sentences on lengths, on how many runs decide, and on what is left undecided."""
    return [
        *_on_lengths(settings),
        *_on_runs(results),
        *_on_undecided(results),
        *(_on_comparison(comparison) if comparison else ()),
    ]


def length(value: float) -> str:
    """A duration as short text: 40000, 2e6."""
    return f"{value:.3g}".replace("e+0", "e").replace("e+", "e") if value >= 1e6 else f"{value:g}"


def _on_lengths(settings: Mapping[str, Any]) -> Iterator[str]:
    dataset = settings.get("datasets", {}).get(DECIDING)
    if not dataset:
        return
    duration = float(dataset["duration"])
    compared = (
        "as long as those of the paper"
        if duration >= PAPER_DURATION
        else f"those of the paper t = {length(PAPER_DURATION)}"
    )
    yield f"The runs that most verdicts rest on last t = {length(duration)}, {compared}."


def _on_runs(results: Results) -> Iterator[str]:
    runs = [
        number.estimate.runs
        for result in results.values()
        for number in result.counted.judged
        if number.estimate.runs is not None
    ]
    if runs:
        yield (
            f"A number that decides rests on {statistics.median_low(runs)} independent runs "
            f"(median; {min(runs)} to {max(runs)})."
        )


def _on_undecided(results: Results) -> Iterator[str]:
    numbers = [each for result in results.values() for each in result.counted.judged]
    open_ones = [each for each in numbers if each.verdict == UNDECIDED]
    if numbers:
        yield (
            f"Of {len(numbers)} numbers that decide, {len(open_ones)} are undecided: their 95 % "
            "intervals cover an end of the allowed range."
        )
    missing = [each.id for each in results.values() if each.verdict == NOT_MEASURED]
    if missing:
        yield f"Not measured: {', '.join(missing)}."


def _on_comparison(comparison: Comparison) -> Iterator[str]:
    for name, same, known in zip(comparison.runs, comparison.same, comparison.known, strict=True):
        yield f"{same} of {known} verdicts are those of the run {name}."

"""The claims of the ledger measured and judged: the tables claims.csv and estimates.csv."""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import pandas as pd

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.plan import registry
from beltrepro.replication.verdicts.criteria import (
    NOT_TESTABLE,
    OPEN,
    Criterion,
    Judgement,
    Measurement,
    bounds,
    judge,
    sentence,
    show,
)
from beltrepro.replication.verdicts.evidence import Evidence
from beltrepro.replication.verdicts.ledger import REGISTRY, Claim, load_ledger


class Measured(NamedTuple):
    """Claims with their verdicts, and the numbers that these rest on."""

    claims: pd.DataFrame  # a row for each claim in the order of the ledger; all cells are text
    # A row for each number of each reading; one that decides has the question for which it does
    # (both, if by the same range), what is allowed, and what that makes of it.
    estimates: pd.DataFrame


class Judged(NamedTuple):
    """A criterion, and what it makes of its reading."""

    criterion: Criterion
    reading: str
    measurement: Measurement
    judgement: Judgement


def measure(datasets: dict, settings: dict) -> Measured:
    """Measured values and verdicts of every claim, by its two criteria."""
    evidence = Evidence(datasets, settings)
    rows, estimates = [], []
    for claim in load_ledger().values():
        evidence.start(claim)
        readings = _readings(evidence, claim)
        answers = {name: _judged(criterion, readings) for name, criterion in claim.criteria.items()}
        rows.append(_row(claim, answers, evidence.used))
        estimates += _estimates(claim, answers, readings)
    return Measured(pd.DataFrame(rows), pd.DataFrame(estimates))


def _readings(evidence: Evidence, claim: Claim) -> dict[str, Measurement | str]:
    """What each reading measures, or in a line why it cannot; a lone reading has no name."""

    def tried(reading: Callable) -> Measurement | str:
        try:
            return reading(evidence)
        except NotEnoughDataError as error:
            return str(error)

    readings = REGISTRY.get(claim.id, {"": lambda evidence: Measurement()})
    return {name: tried(reading) for name, reading in readings.items()}


def _judged(criterion: Criterion, readings: dict[str, Measurement | str]) -> Judged:
    """Verdict of the reading that a criterion names, or of the first."""
    name = criterion.reading or next(iter(readings))
    measurement = readings[name]
    if not isinstance(measurement, str):
        return Judged(criterion, name, measurement, judge(criterion, measurement))
    reason = criterion.untestable or measurement
    verdict = NOT_TESTABLE if criterion.untestable else OPEN
    return Judged(criterion, name, Measurement(), Judgement(verdict, reason=reason))


def _row(claim: Claim, answers: dict[str, Judged], used: list[str]) -> dict[str, str]:
    """A row of claims.csv."""
    row = {
        "id": claim.id,
        "figure": str(claim.figure or ""),
        "kind": claim.kind,
        "says": claim.says,
        "statement": claim.statement,
        "paper": show(claim.paper),
    }
    for question, (criterion, reading, measurement, judgement) in answers.items():
        numbers = measurement.numbers
        runs = [numbers[name].runs for name in judgement.components]
        fewest = min((count for count in runs if count is not None), default="")
        row |= {
            question: judgement.verdict,
            f"{question}_found": sentence(criterion.found, numbers)
            if numbers
            else judgement.reason,
            f"{question}_reading": reading,
            f"{question}_tried": str(criterion.tried),
            f"{question}_how": criterion.how,
            f"{question}_criterion": criterion.ranges,
            f"{question}_because": criterion.because,
            f"{question}_reason": judgement.reason,
            f"{question}_runs": str(fewest),
        }
    notes = (answer.measurement.note for answer in answers.values())
    return row | {
        "seen": claim.seen,
        "note": ". ".join(dict.fromkeys(filter(None, notes))),
        "dataset": ", ".join(used or claim.needs),
    }


def _estimates(
    claim: Claim, answers: dict[str, Judged], readings: dict[str, Measurement | str]
) -> Iterator[dict[str, object]]:
    """Rows of estimates.csv: each number of each reading; twice if questions judge it otherwise."""
    first = next(iter(readings))
    for reading, measurement in readings.items():
        for name, estimate in () if isinstance(measurement, str) else measurement.numbers.items():
            deciding: dict[tuple, list[str]] = {}
            for question, answer in answers.items():
                if answer.reading == reading and name in answer.judgement.components:
                    allowed = bounds(answer.criterion.allowed[name])
                    key = *allowed, answer.judgement.components[name]
                    deciding.setdefault(key, []).append(question)
            shown = registry.figures_with(claim.id, "" if reading == first else reading, name)
            for key, questions in (deciding or {(math.nan, math.nan, ""): []}).items():
                yield {
                    **{"id": claim.id, "reading": reading, "name": name},
                    **estimate.named("value", "low", "high"),
                    "runs": estimate.runs,
                    "decides": ", ".join(questions),
                    **dict(zip(("allowed_low", "allowed_high", "verdict"), key, strict=True)),
                    "figures": ", ".join(shown),
                }

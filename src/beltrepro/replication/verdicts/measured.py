"""The claims of the ledger measured and judged: the tables claims.csv and estimates.csv."""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import pandas as pd

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.plan import registry
from beltrepro.replication.verdicts import criteria
from beltrepro.replication.verdicts.criteria import (
    ANSWER,
    OPEN,
    QUESTIONS,
    Criterion,
    Judgement,
    Measurement,
)
from beltrepro.replication.verdicts.evidence import Evidence
from beltrepro.replication.verdicts.ledger import REGISTRY, Claim, load_ledger, readings_of

COLUMNS = (
    *("id", "figure", "kind", "says", "statement", "paper"),
    *(f"{question}{column}" for question in QUESTIONS for column in ANSWER),
    *("seen", "note", "dataset"),
)
ESTIMATE_COLUMNS = (
    *("id", "reading", "name", "value", "low", "high", "runs"),
    *("decides", "allowed_low", "allowed_high", "verdict", "figures"),
)


class Measured(NamedTuple):
    """Claims with their verdicts, and the numbers that these rest on."""

    claims: pd.DataFrame  # a row for each claim in the order of the ledger; all cells are text
    # A row for each number of each reading; one that decides has the question for which it does
    # (both, if by the same range), what is allowed, and what that makes of it.
    estimates: pd.DataFrame


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
    return Measured(
        pd.DataFrame(rows, columns=list(COLUMNS)),
        pd.DataFrame(estimates, columns=list(ESTIMATE_COLUMNS)),
    )


class Judged(NamedTuple):
    """A criterion, and what it makes of its reading."""

    criterion: Criterion
    reading: str
    measurement: Measurement
    judgement: Judgement

    @property
    def found(self) -> str:
        """What was found, as a sentence; without numbers, why there are none."""
        if not self.measurement.numbers:
            return self.judgement.reason
        return criteria.sentence(self.criterion.found, self.measurement.numbers)

    @property
    def runs(self) -> int | None:
        """Independent runs of the number that rests on fewest; None if none does on runs."""
        numbers = self.measurement.numbers
        runs = (numbers[name].runs for name in self.judgement.components)
        return min((count for count in runs if count is not None), default=None)


def _readings(evidence: Evidence, claim: Claim) -> dict[str, Measurement | str]:
    """What each reading measures, or in a line why it cannot; a lone reading has no name."""

    def tried(reading: Callable) -> Measurement | str:
        try:
            return reading()
        except NotEnoughDataError as error:
            return str(error)

    if claim.id not in REGISTRY:
        return {"": Measurement()}
    measured = tried(lambda: readings_of(claim.id, evidence))
    if not isinstance(measured, dict):
        return {"": measured}
    return {name: tried(reading) for name, reading in measured.items()}


def _judged(criterion: Criterion, readings: dict[str, Measurement | str]) -> Judged:
    """Verdict of the reading that a criterion names, or of the first."""
    name = criterion.reading or next(iter(readings))
    if isinstance(readings.get(""), str):
        name = ""  # no reading at all could be measured
    measurement = readings[name]
    if isinstance(measurement, str) and not criterion.untestable:
        return Judged(criterion, name, Measurement(), Judgement(OPEN, reason=measurement))
    measurement = Measurement() if isinstance(measurement, str) else measurement
    return Judged(criterion, name, measurement, criteria.judge(criterion, measurement))


def _row(claim: Claim, answers: dict[str, Judged], used: list[str]) -> dict[str, str]:
    notes = (answer.measurement.note for answer in answers.values())
    row = {
        "id": claim.id,
        "figure": "" if claim.figure is None else str(claim.figure),
        "kind": claim.kind,
        "says": claim.says,
        "statement": claim.statement,
        "paper": criteria.show(claim.paper),
        "seen": claim.seen,
        "note": ". ".join(dict.fromkeys(filter(None, notes))),
        "dataset": ", ".join(used or claim.needs),
    }
    for question, answer in answers.items():
        cells = (
            answer.judgement.verdict, answer.found, answer.reading, str(answer.criterion.tried),
            answer.criterion.how, answer.criterion.ranges, answer.criterion.because,
            answer.judgement.reason, "" if answer.runs is None else str(answer.runs),
        )  # fmt: skip
        row |= {f"{question}{end}": cell for end, cell in zip(ANSWER, cells, strict=True)}
    return row


def _estimates(
    claim: Claim, answers: dict[str, Judged], readings: dict[str, Measurement | str]
) -> Iterator[dict[str, object]]:
    """A row for each number of each reading; two where the questions have different ranges."""
    first = next(iter(readings))
    for reading, measurement in readings.items():
        if isinstance(measurement, str):
            continue
        for name, estimate in measurement.numbers.items():
            deciding: dict[tuple, list[str]] = {}
            for question, answer in answers.items():
                if answer.reading == reading and name in answer.judgement.components:
                    low, high = criteria.bounds(answer.criterion.allowed[name])
                    key = low, high, answer.judgement.components[name]
                    deciding.setdefault(key, []).append(question)
            shown = registry.figures_with(claim.id, "" if reading == first else reading, name)
            for key, questions in (deciding or {(math.nan, math.nan, ""): []}).items():
                cells = (claim.id, reading, name, *estimate.numbers, estimate.runs)
                cells += (", ".join(questions), *key, ", ".join(shown))
                yield dict(zip(ESTIMATE_COLUMNS, cells, strict=True))

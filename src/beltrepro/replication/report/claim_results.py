"""The tables of claims of a run, as values: two verdicts for each claim, and their numbers."""

import math
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from beltrepro.base.errors import InputError
from beltrepro.base.names import one_of
from beltrepro.replication.plan import io
from beltrepro.replication.verdicts.criteria import QUESTIONS, VERDICTS
from beltrepro.replication.verdicts.ledger import Claim, load_ledger
from beltrepro.stats.estimates import Estimate

_NUMBERS = ("value", "low", "high", "runs", "allowed_low", "allowed_high")


class Number(NamedTuple):
    """A measured number; only one that decides has a range and a verdict."""

    name: str
    estimate: Estimate
    allowed: tuple[float, float] = (math.nan, math.nan)
    verdict: str = ""


@dataclass(frozen=True)
class Answer:
    """What a run says to one of the two questions."""

    verdict: str
    found: str  # as a sentence; why there is no verdict where nothing was measured
    reading: str  # which one counts; empty if there is but one
    runs: str  # fewest of a number that decides
    numbers: dict[str, Number] = field(hash=False)  # of its reading

    @property
    def judged(self) -> list[Number]:
        """The numbers that decide."""
        return [number for number in self.numbers.values() if number.verdict]


@dataclass(frozen=True)
class Result:
    """A claim of the paper and what a run says of it."""

    claim: Claim
    paper: str
    note: str
    dataset: str
    answers: dict[str, Answer] = field(hash=False)  # by question
    readings: dict[str, dict[str, Estimate]] = field(hash=False)  # their numbers, by name
    figures: set[str] = field(hash=False)  # names of those that show any of its numbers

    @property
    def id(self) -> str:
        """Name of the claim."""
        return self.claim.id

    @property
    def verdicts(self) -> dict[str, str]:
        """Both verdicts, by question."""
        return {question: answer.verdict for question, answer in self.answers.items()}


Results = dict[str, Result]


def read(folder: Path) -> Results:
    """The claims of a run by id, in the order of the ledger."""
    claims, estimates = (
        io.read_as_text(folder / f"{name}.csv") for name in ("claims", "estimates")
    )
    rows = defaultdict(list)
    try:
        for row in estimates:
            rows[row["id"]].append(row)
        return {row["id"]: _result(row, rows[row["id"]]) for row in claims}
    except (KeyError, ValueError) as error:
        raise InputError(f"{folder}: tables made by an earlier version ({error})") from None


def statements(results: Results) -> list[Result]:
    """Those of the paper that could come out otherwise."""
    return [result for result in results.values() if result.claim.finding]


def count(results: Results) -> dict[str, dict[str, int]]:
    """How many statements have each verdict, by question."""
    answers = [result.verdicts for result in statements(results)]
    return {
        question: {word: sum(answer[question] == word for answer in answers) for word in VERDICTS}
        for question in QUESTIONS
    }


def _result(row: dict[str, str], rows: list[dict[str, str]]) -> Result:
    """A row of claims.csv, with its rows of estimates.csv."""
    readings: dict[str, dict[str, Estimate]] = defaultdict(dict)
    answers = {}
    for question in QUESTIONS:
        texts = (row[f"{question}_{name}"] for name in ("found", "reading", "runs"))
        answers[question] = Answer(one_of(question, row[question], VERDICTS), *texts, numbers={})
    for one in rows:
        value, low, high, runs, *allowed = (float(one[name] or "nan") for name in _NUMBERS)
        estimate = Estimate(value, low, high, None if math.isnan(runs) else int(runs))
        readings[one["reading"]][one["name"]] = estimate
        for question, answer in answers.items():
            if question in one["decides"] and one["reading"] == answer.reading:
                number = Number(one["name"], estimate, (allowed[0], allowed[1]), one["verdict"])
                answer.numbers[number.name] = number
            elif one["reading"] == answer.reading:  # another question may judge it otherwise
                answer.numbers.setdefault(one["name"], Number(one["name"], estimate))
    about = (row[name] for name in ("paper", "note", "dataset"))
    figures = {name for one in rows for name in one["figures"].split(", ") if name}
    return Result(load_ledger()[row["id"]], *about, answers, readings, figures)

"""The tables of claims of a run, as values: two verdicts for each claim, and their numbers."""

import math
from collections import defaultdict
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import NamedTuple

from beltrepro.base.errors import InputError
from beltrepro.replication.plan import io
from beltrepro.replication.verdicts.criteria import (
    IN_PART,
    NO,
    QUESTIONS,
    VERDICTS,
    YES,
)
from beltrepro.replication.verdicts.ledger import Claim, load_ledger
from beltrepro.stats.estimates import Estimate


class Number(NamedTuple):
    """A measured number; only one that decides has a range and a verdict."""

    name: str
    estimate: Estimate
    allowed: tuple[float, float] = (math.nan, math.nan)
    verdict: str = ""


@dataclass(frozen=True)
class Answer:
    """What a run says to one of the two questions; the texts stand in the table of claims."""

    verdict: str
    found: str  # as a sentence; why there is no verdict where nothing was measured
    reading: str  # which one counts; empty if there is but one
    tried: str  # readings that were tried until this one gave the printed number
    how: str
    criterion: str
    because: str
    reason: str
    runs: str
    numbers: dict[str, Number] = field(hash=False)  # of its reading

    @property
    def judged(self) -> list[Number]:
        """The numbers that decide."""
        return [number for number in self.numbers.values() if number.verdict]


_TEXTS = [text.name for text in fields(Answer)[1:-1]]


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
    try:
        numbers = defaultdict(list)
        for row in estimates:
            numbers[row["id"]].append(row)
        return {row["id"]: _result(row, numbers[row["id"]]) for row in claims}
    except KeyError as error:
        raise InputError(f"{folder}: made by an earlier version, without {error}") from None


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


class OtherRun(NamedTuple):
    """Another run beside this one: statements that both decide, by the same criterion."""

    name: str
    # by question: how many both decide, how many of them alike, and how many yes against no
    agreement: dict[str, tuple[int, int, int]]
    differing: list[tuple[str, str, str, str]]  # statement, question, verdicts of this and of that


def compare(results: Results, claims_csv: Path) -> OtherRun:
    """Compare with the table of claims of another run."""
    other = OtherRun(claims_csv.parent.name, {}, [])
    rows = io.read_as_text(claims_csv)
    for question in QUESTIONS:
        key = ("id", f"{question}_criterion", f"{question}_reading")
        # tables of earlier versions lack these columns: nothing in them is compared
        theirs = {tuple(map(row.get, key)): row.get(question) for row in rows}
        pairs = []
        for result in statements(results):
            answer = result.answers[question]
            pair = answer.verdict, theirs.get((result.id, answer.criterion, answer.reading))
            if {*pair} <= {YES, IN_PART, NO}:
                pairs.append(pair)
                if pair[0] != pair[1]:
                    other.differing.append((result.id, question, *pair))
        opposed = sum({*pair} == {YES, NO} for pair in pairs)
        alike = sum(ours == their for ours, their in pairs)
        other.agreement[question] = len(pairs), alike, opposed
    return other


def _result(row: dict[str, str], numbers: list[dict[str, str]]) -> Result:
    """A row of claims.csv, with its rows of estimates.csv."""
    readings: dict[str, dict[str, Estimate]] = defaultdict(dict)
    for number in numbers:
        cells = (number[name] for name in ("value", "low", "high", "runs"))
        *ends, runs = (float(cell or "nan") for cell in cells)
        estimate = Estimate(*ends, None if math.isnan(runs) else int(runs))
        readings[number["reading"]][number["name"]] = estimate
    answers = {}
    for question in QUESTIONS:
        answer = Answer(row[question], *(row[f"{question}_{name}"] for name in _TEXTS), numbers={})
        for name, estimate in readings.get(answer.reading, {}).items():
            answer.numbers[name] = Number(name, estimate)
        for number in numbers:
            if number["reading"] == answer.reading and question in number["decides"].split(", "):
                name, allowed = number["name"], (number["allowed_low"], number["allowed_high"])
                estimate, (low, high) = answer.numbers[name].estimate, map(float, allowed)
                answer.numbers[name] = Number(name, estimate, (low, high), number["verdict"])
        answers[question] = answer
    figures = {name for number in numbers for name in number["figures"].split(", ") if name}
    about = (row[name] for name in ("paper", "note", "dataset"))
    return Result(load_ledger()[row["id"]], *about, answers, readings, figures)

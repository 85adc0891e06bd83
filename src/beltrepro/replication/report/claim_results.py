"""The tables of claims of a run, as values: two verdicts for each claim, and their numbers."""

import math
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import NamedTuple, TypeVar

from beltrepro.base.errors import InputError
from beltrepro.base.names import hint, one_of
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

T = TypeVar("T")


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


class _Row(NamedTuple):
    """A row of estimates.csv."""

    claim: str
    reading: str
    questions: list[str]  # for which its number decides
    number: Number
    figures: set[str]


def read(folder: Path) -> Results:
    """The claims of a run by id, in the order of the ledger."""
    paths = folder / "claims.csv", folder / "estimates.csv"
    claims, estimates = map(io.read_as_text, paths)
    numbers = defaultdict(list)
    for row in _values(paths[1], estimates, _number):
        numbers[row.claim].append(row)
    results = _values(paths[0], claims, lambda row: _result(row, numbers[row["id"]]))
    return {result.id: result for result in results}


def _values(path: Path, rows: list[dict], value_of: Callable[[dict], T]) -> Iterator[T]:
    """Each row of a table as a value; one line for the first that is none."""
    for place, row in enumerate(rows, 1):
        try:
            if row["id"] not in load_ledger():
                near = hint(row["id"], load_ledger())
                raise ValueError(f"id = {row['id']!r}: no claim of this version{near}")
            yield value_of(row)
        except KeyError as error:
            raise InputError(f"{path}: made by an earlier version, without {error}") from None
        except ValueError as error:
            raise InputError(f"{path}: row {place}: {error}") from None


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


def _number(row: dict[str, str]) -> _Row:
    """A row of estimates.csv, of which the one that decides has a range and a verdict."""
    names = ("value", "low", "high", "runs", "allowed_low", "allowed_high")
    value, low, high, runs, *allowed = (_float(name, row[name]) for name in names)
    questions = row["decides"].split(", ") if row["decides"] else []
    if questions:
        one_of("verdict", row["verdict"], VERDICTS)
        if any(map(math.isnan, allowed)):
            raise ValueError("decides, and has no allowed_low or allowed_high")
    estimate = Estimate(value, low, high, None if math.isnan(runs) else int(runs))
    number = Number(row["name"], estimate, (allowed[0], allowed[1]), row["verdict"])
    figures = set(filter(None, row["figures"].split(", ")))
    return _Row(row["id"], row["reading"], questions, number, figures)


def _float(name: str, cell: str) -> float:
    """The number in a cell; NaN for none."""
    try:
        return float(cell or "nan")
    except ValueError:
        raise ValueError(f"{name} = {cell!r}: not a number") from None


def _result(row: dict[str, str], numbers: list[_Row]) -> Result:
    """A row of claims.csv, with its rows of estimates.csv."""
    readings: dict[str, dict[str, Estimate]] = defaultdict(dict)
    for _, reading, _, number, _ in numbers:
        readings[reading][number.name] = number.estimate
    answers = {}
    for question in QUESTIONS:
        texts = (row[f"{question}_{name}"] for name in _TEXTS)
        answer = Answer(one_of(question, row[question], VERDICTS), *texts, numbers={})
        for _, reading, questions, number, _ in numbers:
            if reading == answer.reading and question in questions:
                answer.numbers[number.name] = number
            elif reading == answer.reading:  # another question may judge it by another range
                answer.numbers.setdefault(number.name, Number(number.name, number.estimate))
        answers[question] = answer
    about = (row[name] for name in ("paper", "note", "dataset"))
    figures = set().union(*(number.figures for number in numbers))
    return Result(load_ledger()[row["id"]], *about, answers, readings, figures)

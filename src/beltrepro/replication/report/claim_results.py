"""The tables of claims of a run, as values: two verdicts for each claim, and their numbers."""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from beltrepro.base.errors import InputError
from beltrepro.replication.plan import io
from beltrepro.replication.verdicts import criteria
from beltrepro.replication.verdicts.criteria import IN_PART, NO, QUESTIONS, YES
from beltrepro.replication.verdicts.ledger import FINDINGS, KINDS, Claim, load_ledger
from beltrepro.stats.estimates import Estimate

TABLES = ("claims.csv", "estimates.csv")
DECIDED = (YES, IN_PART, NO)
APART = tuple(kind for kind in KINDS if kind not in FINDINGS)


@dataclass(frozen=True)
class Number:
    """A measured number of a reading."""

    name: str
    estimate: Estimate
    decides: tuple[str, ...] = ()  # questions; without any it has no range and no verdict
    allowed: tuple[float, float] = (math.nan, math.nan)
    verdict: str = ""
    figures: tuple[str, ...] = ()  # names of those that show it

    @property
    def words(self) -> str:
        """Value and 95 % interval."""
        return self.estimate.words

    @property
    def allowed_words(self) -> str:
        """The allowed range, empty if there is none."""
        return criteria.range_in_words(self.allowed) if self.decides else ""


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
        return [number for number in self.numbers.values() if number.decides]


@dataclass(frozen=True)
class Result:
    """A claim of the paper and what a run says of it."""

    claim: Claim
    paper: str
    note: str
    dataset: str
    answers: dict[str, Answer] = field(hash=False)  # by question
    readings: dict[str, dict[str, Number]] = field(hash=False)  # all of them, by name

    @property
    def id(self) -> str:
        """Name of the claim."""
        return self.claim.id

    @property
    def verdicts(self) -> dict[str, str]:
        """Both verdicts, by question."""
        return {question: answer.verdict for question, answer in self.answers.items()}

    @property
    def figures(self) -> list[str]:
        """The figures that show any of its numbers."""
        numbers = (number for reading in self.readings.values() for number in reading.values())
        return list(dict.fromkeys(name for number in numbers for name in number.figures))


Results = dict[str, Result]


@dataclass(frozen=True)
class Counts:
    """How many claims have each verdict, by question, and how many are counted apart, by kind."""

    verdicts: dict[str, dict[str, int]]
    apart: dict[str, int]
    total: int  # statements of the paper that could come out otherwise
    testable: int  # those of them with anything that a simulation can be compared with


@dataclass(frozen=True)
class OtherRun:
    """What another run makes of the claims that it judges by the same criteria as this one."""

    name: str
    verdicts: dict[str, dict[str, str]]  # by question and claim

    def pairs(self, results: Results, question: str) -> dict[str, tuple[str, str]]:
        """The verdicts of this run and of the other one, where both decide."""
        pairs = {
            name: (results[name].verdicts[question], verdict)
            for name, verdict in self.verdicts[question].items()
            if results[name].claim.finding
        }
        return {name: pair for name, pair in pairs.items() if {*pair} <= {*DECIDED}}

    def agreement(self, results: Results, question: str) -> tuple[int, int, int]:
        """How many claims both decide, how many of them alike, and how many yes against no."""
        pairs = self.pairs(results, question).values()
        alike = sum(one == other for one, other in pairs)
        return len(pairs), alike, sum({*pair} == {YES, NO} for pair in pairs)


def count(results: Results) -> Counts:
    """Count the claims of a run by their verdicts."""
    findings = [result for result in results.values() if result.claim.finding]
    verdicts = {}
    for question in QUESTIONS:
        numbers = Counter(result.verdicts[question] for result in findings)
        verdicts[question] = {verdict: numbers[verdict] for verdict in criteria.VERDICTS}
    kinds = Counter(result.claim.kind for result in results.values())
    testable = sum(result.claim.testable for result in findings)
    return Counts(verdicts, {kind: kinds[kind] for kind in APART}, len(findings), testable)


def read(folder: Path) -> Results:
    """The claims of a run by id, in the order of the ledger."""
    return read_tables(*(folder / name for name in TABLES))


def read_tables(claims_csv: Path, estimates_csv: Path) -> Results:
    """`read` from two files."""
    ledger = load_ledger()
    claims, numbers = io.read_as_text(claims_csv), _numbers(estimates_csv)
    results: Results = {}
    for row in claims:
        if row["id"] not in ledger:
            raise InputError(f"{claims_csv}: claim {row['id']!r} is not in the ledger")
        if not is_current(row):
            raise InputError(f"{claims_csv}: made by an earlier version, with one verdict a claim")
        rows = numbers.get(row["id"], [])
        readings = {name: {n.name: n for r, n in rows if r == name} for name, _ in rows}
        answers = {question: _answer(row, question, rows) for question in QUESTIONS}
        results[row["id"]] = Result(
            ledger[row["id"]], row["paper"], row["note"], row["dataset"], answers, readings
        )
    return results


def is_current(row: dict[str, str]) -> bool:
    """Whether a row of a table of claims has both verdicts."""
    return all(question in row for question in QUESTIONS)


def compared(results: Results, tables: Iterable[Path]) -> list[OtherRun]:
    """Other runs, by their tables of claims; those of earlier versions are left out."""
    runs = []
    for path in tables:
        if (rows := io.read_as_text(path)) and is_current(rows[0]):
            verdicts = {question: _same(results, rows, question) for question in QUESTIONS}
            runs.append(OtherRun(path.parent.name, verdicts))
    return runs


def _same(results: Results, rows: list[dict[str, str]], question: str) -> dict[str, str]:
    """Verdicts by criteria and readings that are those of this run."""
    verdicts = {}
    for row in rows:
        if row["id"] in results:
            answer = results[row["id"]].answers[question]
            criterion = row[f"{question}_criterion"], row[f"{question}_reading"]
            if criterion == (answer.criterion, answer.reading):
                verdicts[row["id"]] = row[question]
    return verdicts


def _answer(row: dict[str, str], question: str, rows: list[tuple[str, Number]]) -> Answer:
    texts = [row[f"{question}{end}"] for end in criteria.ANSWER]
    reading = row[f"{question}_reading"]
    numbers: dict[str, Number] = {}
    for name, number in rows:
        if name == reading and (question in number.decides or number.name not in numbers):
            only = number if question in number.decides else Number(number.name, number.estimate)
            numbers[number.name] = only
    return Answer(*texts, numbers=numbers)


def _numbers(path: Path) -> dict[str, list[tuple[str, Number]]]:
    """Readings and numbers by claim; one that both questions judge otherwise is there twice."""
    numbers: dict[str, list[tuple[str, Number]]] = {}
    for row in io.read_as_text(path):
        if "reading" not in row:
            raise InputError(f"{path}: made by an earlier version, with one verdict a claim")
        value, low, high, *allowed = (
            float(row[name] or "nan")
            for name in ("value", "low", "high", "allowed_low", "allowed_high")
        )
        runs = int(float(row["runs"])) if row["runs"] else None
        decides, figures = (
            tuple(filter(None, row[name].split(", "))) for name in ("decides", "figures")
        )
        estimate = Estimate(value, low, high, runs)
        number = Number(row["name"], estimate, decides, tuple(allowed), row["verdict"], figures)
        numbers.setdefault(row["id"], []).append((row["reading"], number))
    return numbers

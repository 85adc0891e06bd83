"""The tables of claims of a run, as values: verdicts, numbers and readings."""

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from beltrepro.base.errors import InputError
from beltrepro.replication.verdicts import criteria
from beltrepro.replication.verdicts.ledger import Claim, load_ledger
from beltrepro.stats.estimates import Estimate

_BY = {
    criteria.FAILS: "It fails by",
    criteria.PARTLY: "It fails in part, by",
    criteria.UNDECIDED: "It is undecided by",
}


@dataclass(frozen=True)
class Number:
    """A measured number of a claim; `name` may be empty."""

    name: str
    estimate: Estimate
    allowed: tuple[float, float] | None = None  # None: it decides nothing, and has no verdict
    verdict: str = ""

    @property
    def words(self) -> str:
        """Value and 95 % interval."""
        return self.estimate.words

    @property
    def allowed_words(self) -> str:
        """The allowed range, empty if there is none."""
        return "" if self.allowed is None else criteria.range_in_words(self.allowed)


@dataclass(frozen=True)
class Reading:
    """A claim in one reading; `name` is empty for the one that counts."""

    name: str
    verdict: str
    reason: str  # the numbers that do not hold, and by what; empty if all do
    note: str  # what is to be known besides
    runs: str
    numbers: dict[str, Number] = field(hash=False)

    @property
    def judged(self) -> list[Number]:
        """The numbers that decide."""
        return [number for number in self.numbers.values() if number.allowed is not None]

    @property
    def also(self) -> list[Number]:
        """The numbers that are only reported."""
        return [number for number in self.numbers.values() if number.allowed is None]

    @property
    def said(self) -> str:
        """The note as sentences."""
        return as_sentence(self.note)

    @property
    def why(self) -> str:
        """Why it does not hold, as sentences; empty if it holds or cannot be tested."""
        if self.verdict in (criteria.HOLDS, criteria.NOT_TESTABLE):
            return ""
        if not self.reason:
            return self.said
        return f"{as_sentence(f'{_BY[self.verdict]} {self.reason}')} {self.said}".strip()


@dataclass(frozen=True)
class Result:
    """A claim of the paper and what a run says of it, first in the reading that counts."""

    claim: Claim
    readings: tuple[Reading, ...]
    criterion: str
    paper: str
    dataset: str

    @property
    def id(self) -> str:
        """Name of the claim."""
        return self.claim.id

    @property
    def counted(self) -> Reading:
        """The reading that counts."""
        return self.readings[0]

    @property
    def variants(self) -> tuple[Reading, ...]:
        """The other readings."""
        return self.readings[1:]

    @property
    def verdict(self) -> str:
        """Of the reading that counts."""
        return self.counted.verdict

    @property
    def measured(self) -> bool:
        """Whether there is a verdict."""
        return self.verdict not in (criteria.NOT_MEASURED, criteria.NOT_TESTABLE)


Results = dict[str, Result]


@dataclass(frozen=True)
class Counts:
    """How many claims that could come out otherwise have each verdict; and those that could not."""

    by_verdict: dict[str, int]
    construction: int  # true because the model is built so

    @property
    def total(self) -> int:
        """Claims that could come out otherwise."""
        return sum(self.by_verdict.values())

    @property
    def testable(self) -> int:
        """Those of them that a simulation can test."""
        return self.total - self.by_verdict[criteria.NOT_TESTABLE]


def count(results: Results) -> Counts:
    """Count the claims of a run by their verdicts."""
    verdicts = [result.verdict for result in results.values() if result.claim.finding]
    by_verdict = {verdict: verdicts.count(verdict) for verdict in criteria.VERDICTS}
    return Counts(by_verdict, len(results) - len(verdicts))


def with_verdict(results: Results, *verdicts: str) -> list[Result]:
    """The claims that have one of these verdicts."""
    return [result for result in results.values() if result.verdict in verdicts]


def read(folder: Path) -> Results:
    """The claims of a run by id, in the order of the ledger; InputError for one that it lacks."""
    return read_tables(folder / "claims.csv", folder / "estimates.csv")


def read_tables(claims_csv: Path, estimates_csv: Path) -> Results:
    """`read` from two files."""
    ledger = load_ledger()
    claims, numbers = read_claims(claims_csv), _numbers(estimates_csv)
    results: Results = {}
    for name, rows in claims.groupby("id", sort=False):
        if name not in ledger:
            raise InputError(f"{claims_csv}: claim {name!r} is not in the ledger")
        readings = (
            _reading(row, numbers.get((name, row["variant"]), {}))
            for row in rows.to_dict("records")
        )
        first = rows.iloc[0]
        results[name] = Result(
            ledger[name], tuple(readings), first["criterion"], first["paper"], first["dataset"]
        )
    return results


def read_claims(path: Path) -> pd.DataFrame:
    """A table of claims, all of it text."""
    return _read_csv(path, dtype=str, keep_default_na=False)


def as_sentence(text: str) -> str:
    """With a full stop, and a capital for words, not for symbols."""
    text = text.strip()
    if not text:
        return ""
    begin = text[0].upper() if re.match(r"[a-z]{3}", text) else text[0]
    return begin + text[1:] + ("" if text.endswith((".", "?", "!")) else ".")


def _read_csv(path: Path, **how) -> pd.DataFrame:
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    return pd.read_csv(path, **how)


def _reading(row: dict[str, str], numbers: dict[str, Number]) -> Reading:
    reason, note = row.get("reason", ""), row["note"]
    if "reason" not in row:  # runs of beltrepro up to 0.1 have it at the head of the note
        judged = {number.name: number for number in numbers.values() if number.allowed}
        allowed = {name: number.allowed for name, number in judged.items()}
        estimates = {name: number.estimate for name, number in judged.items()}
        computed = criteria.judge({"allowed": allowed}, criteria.Measurement(estimates)).reason
        if note == computed or note.startswith(f"{computed}. "):
            reason, note = computed, note.removeprefix(computed).removeprefix(". ")
    return Reading(row["variant"], row["verdict"], reason, note, row["runs"], numbers)


def _numbers(path: Path) -> dict[tuple[str, str], dict[str, Number]]:
    """Numbers by claim and reading, and in these by name."""
    texts = dict.fromkeys(("id", "variant", "name", "verdict"), "")
    table = _read_csv(path, dtype=dict.fromkeys(texts, str), na_values=[""], keep_default_na=False)
    numbers: dict[tuple[str, str], dict[str, Number]] = {}
    for row in table.fillna(texts).to_dict("records"):
        runs = None if math.isnan(row["runs"]) else int(row["runs"])
        estimate = Estimate(row["value"], row["low"], row["high"], runs)
        ends = (row["allowed_low"], row["allowed_high"])
        allowed = None if math.isnan(ends[0]) else ends
        number = Number(row["name"], estimate, allowed, row["verdict"])
        numbers.setdefault((row["id"], row["variant"]), {})[row["name"]] = number
    return numbers

"""The tables of claims of a run, as values: verdicts, numbers and readings."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from beltrepro.base.errors import InputError
from beltrepro.replication.verdicts.criteria import (
    FAILS,
    HOLDS,
    NOT_MEASURED,
    NOT_TESTABLE,
    PARTLY,
    UNDECIDED,
    range_in_words,
)
from beltrepro.replication.verdicts.entries import Claim, load_ledger
from beltrepro.stats.estimates import Estimate

_BY = {
    FAILS: "It fails by",
    PARTLY: "It fails in part, by",
    UNDECIDED: "It is undecided by",
}


@dataclass(frozen=True)
class Number:
    """A measured number of a claim.

    name : of the component; may be empty.
    allowed : range in which it must lie, None if it decides nothing; verdict is then empty.
    """

    name: str
    estimate: Estimate
    allowed: tuple[float, float] | None = None
    verdict: str = ""

    @property
    def words(self) -> str:
        """Value and 95 % interval."""
        return self.estimate.words

    @property
    def allowed_words(self) -> str:
        """The allowed range, empty if there is none."""
        return "" if self.allowed is None else range_in_words(self.allowed)


@dataclass(frozen=True)
class Reading:
    """A claim in one reading; `name` is empty for the one that counts."""

    name: str
    verdict: str
    note: str
    runs: str
    numbers: dict[str, Number] = field(hash=False)

    @property
    def judged(self) -> list[Number]:
        """The numbers that decide."""
        return [each for each in self.numbers.values() if each.allowed is not None]

    @property
    def also(self) -> list[Number]:
        """The numbers that are only reported."""
        return [each for each in self.numbers.values() if each.allowed is None]

    @property
    def reason(self) -> str:
        """The numbers that do not hold, which come first in the note."""
        decided = all(each.verdict == HOLDS for each in self.judged)
        return "" if decided else self.note.partition(". ")[0]

    @property
    def said(self) -> str:
        """What the note says besides, as sentences."""
        return as_sentence(self.note.partition(". ")[2] if self.reason else self.note)

    @property
    def why(self) -> str:
        """Why it does not hold, as sentences; empty if it holds or cannot be tested."""
        if self.verdict in (HOLDS, NOT_TESTABLE):
            return ""
        if not self.reason:
            return self.said
        return f"{as_sentence(f'{_BY[self.verdict]} {self.reason}')} {self.said}".strip()


@dataclass(frozen=True)
class Result:
    """A claim of the paper, and what a run says of it.

    counted : in the reading that counts; variants : in others.
    """

    claim: Claim
    counted: Reading
    variants: tuple[Reading, ...]
    criterion: str
    paper: str
    dataset: str

    @property
    def id(self) -> str:
        """Name of the claim."""
        return self.claim.id

    @property
    def verdict(self) -> str:
        """Of the reading that counts."""
        return self.counted.verdict

    @property
    def measured(self) -> bool:
        """Whether there is a verdict."""
        return self.verdict not in (NOT_MEASURED, NOT_TESTABLE)

    @property
    def readings(self) -> tuple[Reading, ...]:
        """All of them, the one that counts first."""
        return (self.counted, *self.variants)

    @property
    def why(self) -> str:
        """Why it does not hold, as sentences; empty if it holds."""
        return self.counted.why


Results = dict[str, Result]


def read(claims_csv: Path, estimates_csv: Path) -> Results:
    """The claims of a run by id, in the order of the ledger."""
    ledger = load_ledger()
    table, numbers = _table(claims_csv), _numbers(estimates_csv)
    found: Results = {}
    for name, rows in table.groupby("id", sort=False):
        if name not in ledger:
            raise InputError(f"{claims_csv}: claim {name!r} is not in the ledger")
        first, *others = (
            Reading(
                row["variant"],
                row["verdict"],
                row["note"],
                row["runs"],
                numbers.get((name, row["variant"]), {}),
            )
            for row in rows.to_dict("records")
        )
        row = rows.iloc[0]
        found[name] = Result(
            ledger[name], first, tuple(others), row["criterion"], row["paper"], row["dataset"]
        )
    return found


def as_sentence(text: str) -> str:
    """With a full stop, and a capital for words, not for symbols."""
    text = text.strip()
    if not text:
        return ""
    begin = text[0].upper() if re.match(r"[a-z]{3}", text) else text[0]
    return begin + text[1:] + ("" if text.endswith((".", "?", "!")) else ".")


def _table(path: Path) -> pd.DataFrame:
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    return pd.read_csv(path, dtype=str, keep_default_na=False)


def _numbers(path: Path) -> dict[tuple[str, str], dict[str, Number]]:
    """Numbers by claim and reading, and in these by name."""
    texts = ("id", "variant", "name", "verdict")
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    table = pd.read_csv(
        path, dtype=dict.fromkeys(texts, str), na_values=[""], keep_default_na=False
    )
    table = table.fillna(dict.fromkeys(texts, ""))
    found: dict[tuple[str, str], dict[str, Number]] = {}
    for row in table.to_dict("records"):
        runs = None if math.isnan(row["runs"]) else int(row["runs"])
        estimate = Estimate(row["value"], row["low"], row["high"], runs)
        allowed = (row["allowed_low"], row["allowed_high"])
        number = Number(
            row["name"], estimate, None if math.isnan(allowed[0]) else allowed, row["verdict"]
        )
        found.setdefault((row["id"], row["variant"]), {})[row["name"]] = number
    return found

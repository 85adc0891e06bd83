"""What other readings of the paper give, and other runs."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from beltrepro.replication.report.claim_results import Number, Reading, Result, Results, read_claims
from beltrepro.replication.verdicts.ledger import CHANGES
from beltrepro.stats.estimates import Estimate, difference


@dataclass(frozen=True)
class Printed:
    """A number that the paper prints, and what the readings give for it."""

    result: Result
    name: str
    value: float
    low: float  # ends of the intervals of all readings together
    high: float

    @property
    def inside(self) -> bool:
        """Whether the printed number lies within what the readings give."""
        return self.low <= self.value <= self.high


@dataclass(frozen=True)
class Shift:
    """What a reading with another `what` (see CHANGES) makes of a number."""

    result: Result
    what: str
    reading: Reading
    counted: Number
    other: Number

    @property
    def shift(self) -> Estimate:
        """Other minus counted, as if both were independent."""
        return difference(self.other.estimate, self.counted.estimate)

    @property
    def matters(self) -> bool | None:
        """Whether the shift is clear of zero; None if its error is not known."""
        low, high = self.shift.low, self.shift.high
        return low > 0 or high < 0 if math.isfinite(low) and math.isfinite(high) else None

    @property
    def turns(self) -> bool:
        """Whether it gives the number another verdict."""
        return self.other.verdict != self.counted.verdict


@dataclass(frozen=True)
class OtherRun:
    """Verdicts of another run on the claims that it judges by the criteria of this one."""

    name: str
    verdicts: dict[str, str]
    same: int  # how many of them are those of this run


def printed(results: Iterable[Result]) -> list[Printed]:
    """The numbers that the paper prints for claims with other readings."""
    return [number for result in results if result.claim.open for number in _printed(result)]


def depends_on_reading(result: Result) -> str:
    """Whether the verdict depends on the reading, as a sentence; empty if there is but one."""
    if not result.variants:
        return ""
    counts = Counter(reading.verdict for reading in result.readings)
    if len(counts) == 1:
        return f"All {len(result.readings)} readings give this verdict."
    parts = ", ".join(f"{number} {verdict}" for verdict, number in counts.most_common())
    return f"The verdict depends on the reading: {parts}."


def shifts(results: Results) -> dict[str, list[Shift]]:
    """What numerics and starts make of the claims that carry the paper, by what is changed."""
    by_change: dict[str, list[Shift]] = {what: [] for what in CHANGES}
    for result in results.values():
        for reading in result.variants:
            what = result.claim.changes.get(reading.name)
            for number in result.counted.judged if what else ():
                other = reading.numbers.get(number.name)
                if other is None:
                    continue
                if not math.isnan(number.estimate.value) and not math.isnan(other.estimate.value):
                    by_change[what].append(Shift(result, what, reading, number, other))
    return by_change


def compared(results: Results, tables: Iterable[Path]) -> list[OtherRun]:
    """Other runs, by their tables of claims."""
    runs = []
    for path in tables:
        verdicts = {
            row["id"]: row["verdict"]
            for row in read_claims(path).to_dict("records")
            if not row["variant"] and row["id"] in results
            if row["criterion"] == results[row["id"]].criterion
        }
        same = sum(results[name].verdict == verdict for name, verdict in verdicts.items())
        runs.append(OtherRun(path.parent.name, verdicts, same))
    return runs


def differing(results: Results, others: list[OtherRun]) -> list[tuple[Result, list[str]]]:
    """Claims that any two runs judge differently; an empty verdict where a run has none."""
    rows = [
        (result, [other.verdicts.get(name, "") for other in others])
        for name, result in results.items()
    ]
    return [(result, row) for result, row in rows if {*row} - {"", result.verdict}]


def _printed(result: Result) -> Iterator[Printed]:
    """What is printed for single numbers, if they are judged against a range that has it in it."""
    paper, judged = result.claim.paper, result.counted.judged
    if not isinstance(paper, dict):
        paper = {judged[0].name: paper} if len(judged) == 1 else {}
    allowed = {number.name: number.allowed for number in judged}
    for name, value in paper.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or name not in allowed:
            continue
        if not allowed[name][0] <= value <= allowed[name][1]:
            continue
        numbers = [reading.numbers[name] for reading in result.readings if name in reading.numbers]
        lows = [n.estimate.low for n in numbers if math.isfinite(n.estimate.low)]
        highs = [n.estimate.high for n in numbers if math.isfinite(n.estimate.high)]
        if lows and highs:
            yield Printed(result, name, float(value), min(lows), max(highs))

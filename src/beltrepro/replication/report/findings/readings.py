"""What other readings of the paper give: whether what it prints lies within what they span."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from beltrepro.replication.report.findings.results import Number, Reading, Result, Results
from beltrepro.stats.estimates import Estimate, difference

# The claims that carry the paper; those of them that a run has not measured are left out.
CARRYING = (
    "r-jump",
    "u-critical",
    "permanent-chaos",
    "no-permanent-chaos",
    "transient-lifetime",
    "uc-of-sigma",
    "uc-sigma22",
    "sigma-c-u7",
    "intermittency",
    "transition-width",
    "n10-intermittency",
    "method-independence",
)
# What a reading changes that the paper leaves to the one who computes, by words in its name.
CHANGES = {
    "integrator": r"scheme|exact dynamics|integrator|method",
    "time step": r"time step|\bdt\b",
    "initial state": r"start|declared",
    "transient": r"transient|settles",
    "length": r"length|long run|series",
    "number of runs": r"one run|single run|independent runs|many runs",
}


@dataclass(frozen=True)
class Printed:
    """A printed number and what the readings give for it.

    low, high : ends of all their intervals together.
    """

    result: Result
    name: str
    value: float
    low: float
    high: float

    @property
    def inside(self) -> bool:
        """Whether the printed number lies within what the readings give."""
        return self.low <= self.value <= self.high


@dataclass(frozen=True)
class Shift:
    """What another reading makes of a number.

    what : what it changes, one of CHANGES; counted, other : the number in the reading that counts
    and in this one; shift : their difference, with its interval if they are independent.
    """

    result: Result
    what: str
    reading: Reading
    counted: Number
    other: Number

    @property
    def shift(self) -> Estimate:
        """Other minus counted."""
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


def printed(results: Iterable[Result]) -> list[Printed]:
    """The numbers that the paper prints for claims with other readings."""
    return [
        each
        for result in results
        if result.claim.open
        for name, value in _values(result)
        for each in _span(result, name, value)
    ]


def together(result: Result) -> str:
    """Whether the verdict depends on the reading, as a sentence; empty if there is but one."""
    if not result.variants:
        return ""
    counts = Counter(each.verdict for each in result.readings)
    if len(counts) == 1:
        return f"All {len(result.readings)} readings give this verdict."
    each = ", ".join(f"{number} {verdict}" for verdict, number in counts.most_common())
    return f"The verdict depends on the reading: {each}."


def shifts(results: Results) -> list[Shift]:
    """What numerics and starts make of the claims that carry the paper."""
    return [
        Shift(result, what, reading, number, reading.numbers[number.name])
        for result in (results[name] for name in CARRYING if name in results)
        for reading in result.variants
        for what in changed(reading.name)
        for number in result.counted.judged
        if number.name in reading.numbers and _found(number, reading.numbers[number.name])
    ]


def changed(name: str) -> list[str]:
    """What a reading of this name changes: the first of CHANGES that it names, or nothing."""
    return [what for what, words in CHANGES.items() if re.search(words, name)][:1]


def _values(result: Result) -> Iterator[tuple[str, float]]:
    """Names of numbers and what is printed for them; pairs and whole tables are left out."""
    paper, judged = result.claim.paper, result.counted.judged
    if isinstance(paper, dict):
        yield from ((name, value) for name, value in paper.items() if _is_number(value))
    elif _is_number(paper) and len(judged) == 1:
        yield judged[0].name, paper


def _span(result: Result, name: str, value: float) -> Iterator[Printed]:
    """Nothing if the number is not judged against a range that has the printed one in it."""
    number = result.counted.numbers.get(name)
    if number is None or number.allowed is None:
        return
    if not number.allowed[0] <= value <= number.allowed[1]:
        return
    found = [each.numbers[name].estimate for each in result.readings if name in each.numbers]
    lows = [each.low for each in found if math.isfinite(each.low)]
    highs = [each.high for each in found if math.isfinite(each.high)]
    if lows and highs:
        yield Printed(result, name, float(value), min(lows), max(highs))


def _found(*numbers: Number) -> bool:
    return not any(math.isnan(each.estimate.value) for each in numbers)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)

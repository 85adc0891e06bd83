"""How a criterion of the ledger turns what was measured into a verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from beltrepro.stats.estimates import Estimate, in_words

HOLDS = "holds"
PARTLY = "partly"
FAILS = "fails"
UNDECIDED = "undecided"
NOT_MEASURED = "not measured"
NOT_TESTABLE = "not testable here"
VERDICTS = (HOLDS, PARTLY, FAILS, UNDECIDED, NOT_MEASURED, NOT_TESTABLE)
FEW_RUNS = 8


@dataclass(frozen=True)
class Measurement:
    """What a claim function found.

    judged : estimates by the names that the criterion allows ranges for.
    also : further estimates, reported only.
    note : what a reader should know; of a claim that fails or is undecided, the measured reason.
    """

    judged: dict[str, Estimate] = field(default_factory=dict)
    also: dict[str, Estimate] = field(default_factory=dict)
    note: str = ""

    @property
    def runs(self) -> int | None:
        """Independent runs of the estimate that rests on fewest; None if none does on runs."""
        known = [each.runs for each in self.judged.values() if each.runs is not None]
        return min(known, default=None)

    @property
    def words(self) -> str:
        """All estimates as short text."""
        return in_words(self.judged | self.also)


@dataclass(frozen=True)
class Judgement:
    """A verdict, and the components that led to it by name.

    reason : what fails and what is undecided, and how many runs would decide it; empty if all
    holds.
    """

    verdict: str
    components: dict[str, str] = field(default_factory=dict)
    reason: str = ""


def judge(criterion: dict[str, Any], measurement: Measurement) -> Judgement:
    """Verdict of one measurement.

    A component holds if its whole interval lies in the allowed range, fails if the whole of it lies
    outside, and is undecided otherwise. What was looked for and not found fails. The claim is that
    all components hold. It holds if all do, and fails if all fail. If some hold and some fail it is
    right in part. Otherwise it is undecided.
    """
    if not criterion.get("allowed"):
        return Judgement(NOT_TESTABLE)
    components, reasons = {}, []
    for name, allowed in criterion["allowed"].items():
        low, high = bounds(allowed)
        found = measurement.judged[name]
        components[name] = _component(found, low, high)
        if components[name] != HOLDS:
            reasons.append(f"{_named(name)}{_reason(components[name], found, low, high)}")
    grades = set(components.values())
    if grades in ({HOLDS}, {FAILS}):
        verdict = grades.pop()
    else:
        verdict = PARTLY if {HOLDS, FAILS} <= grades else UNDECIDED
    return Judgement(verdict, components, "; ".join(reasons))


def bounds(allowed: Any) -> tuple[float, float]:
    """Ends of an allowed range of the ledger: [low, high], or yes or no."""
    if isinstance(allowed, bool):
        return float(allowed), float(allowed)
    low, high = allowed
    return float(low), float(high)


def range_in_words(allowed: Any) -> str:
    """An allowed range as short text."""
    low, high = bounds(allowed)
    if low == high in (0.0, 1.0):
        return ("no", "yes")[int(low)]
    if math.isinf(high):
        return f"{low:g} or more"
    if math.isinf(low):
        return f"{high:g} or less"
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def show(value: Any, digits: int = 4) -> str:
    """A printed value as short text: "low to high" for pairs, "name: value; ..." for dicts."""
    if value is None:
        return ""
    if isinstance(value, dict):
        return "; ".join(f"{name}: {show(inner, digits)}" for name, inner in value.items())
    if isinstance(value, list | tuple):
        return " to ".join(show(inner, digits) for inner in value)
    return f"{value:.{digits}g}"


def _component(found: Estimate, low: float, high: float) -> str:
    if math.isnan(found.value):
        return FAILS
    if math.isnan(found.low) or math.isnan(found.high):
        return UNDECIDED
    if low <= found.low and found.high <= high:
        return HOLDS
    return FAILS if found.high < low or found.low > high else UNDECIDED


def _reason(grade: str, found: Estimate, low: float, high: float) -> str:
    """What fails, or what would decide."""
    if grade == FAILS:
        return f"{found.words}, not {range_in_words([low, high])}" if low != high else found.words
    if math.isnan(found.low) or math.isnan(found.high):
        return "found in fewer than 95 % of the resampled runs"
    if found.runs == 1:
        return f"{found.value:.3g} in one run, whose error is not known"
    crossed = [end for end, beyond in ((low, found.low < low), (high, found.high > high)) if beyond]
    limit = min(crossed, key=lambda end: abs(end - found.value))
    distance = abs(limit - found.value)
    reach = found.high - found.value if limit > found.value else found.value - found.low
    text = f"{found.words} covers the limit {limit:.4g}"
    if found.still_open:
        return f"{text}; {found.still_open} of {found.runs} runs must be longer to tell"
    if found.runs is None or not 0 < distance < reach:
        return text
    needed = found.runs * (reach / distance) ** 2
    if needed > 1e4:
        return f"{text}, at which it lies"
    return f"{text}; some {_rounded(needed)} independent runs would decide, {found.runs} were made"


def _rounded(number: float) -> str:
    """Two digits, upwards."""
    scale = 10 ** max(0, math.floor(math.log10(number)) - 1)
    return f"{math.ceil(number / scale) * scale:g}"


def _named(name: str) -> str:
    return f"{name}: " if name else ""

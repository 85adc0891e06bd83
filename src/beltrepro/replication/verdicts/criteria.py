"""How a criterion of the ledger turns what was measured into a verdict and a sentence."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Any

from beltrepro.stats.estimates import Estimate

YES, IN_PART, NO, OPEN, NOT_TESTABLE = "yes", "in part", "no", "open", "not testable"
VERDICTS = (YES, IN_PART, NO, OPEN, NOT_TESTABLE)
# What is asked of each statement: do the authors' protocol and reading give what they printed, and
# does it stand with exact dynamics, independent starts and sound statistics?
QUESTIONS = ("replicated", "robust")
_PLACE = re.compile(r"\{(?:(count|value|percent) )?([^{}]+)\}")
_NEXT_SENTENCE = re.compile(r"(?<=\.) +(?=[A-Z{])")


@dataclass(frozen=True)
class Measurement:
    """What a claim function found.

    judged : estimates by the names that criteria allow ranges for.
    also : further estimates, reported only.
    note : what a reader should know besides.
    """

    judged: dict[str, Estimate] = field(default_factory=dict)
    also: dict[str, Estimate] = field(default_factory=dict)
    note: str = ""

    @property
    def numbers(self) -> dict[str, Estimate]:
        """All estimates by name."""
        return self.judged | self.also


@dataclass(frozen=True)
class Criterion:
    """What decides one of the two verdicts; docs/trust.md explains the fields."""

    allowed: dict[str, Any] = field(default_factory=dict, hash=False)
    lenient: dict[str, Any] = field(default_factory=dict, hash=False)
    reading: str = ""
    how: str = ""
    because: str = ""
    found: str = ""
    tried: int = 1
    untestable: str = ""

    @property
    def ranges(self) -> str:
        """The allowed ranges as short text."""
        return "; ".join(
            f"{name}: {range_in_words(allowed)}"
            + (f" (lenient: {range_in_words(self.lenient[name])})" if name in self.lenient else "")
            for name, allowed in self.allowed.items()
        )


@dataclass(frozen=True)
class Judgement:
    """A verdict, what each number makes of it by name, and why it is not yes."""

    verdict: str
    components: dict[str, str] = field(default_factory=dict)
    reason: str = ""


def judge(criterion: Criterion, measurement: Measurement) -> Judgement:
    """Verdict of one measurement; docs/trust.md says when a number is right, in part, or wrong.

    One number that is surely wrong decides: the statement does not hold as printed, whatever
    becomes of the others; it holds in part if another one is right.
    """
    if criterion.untestable:
        return Judgement(NOT_TESTABLE, reason=criterion.untestable)
    grades, reasons = {}, []
    for name, allowed in criterion.allowed.items():
        estimate, lenient = measurement.numbers[name], criterion.lenient.get(name, allowed)
        grades[name] = _grade(estimate, bounds(allowed), bounds(lenient))
        if grades[name] != YES:
            reasons.append(f"{name}: {_reason(grades[name], estimate, allowed)}")
    of_all = set(grades.values())
    if NO in of_all:
        verdict = IN_PART if of_all & {YES, IN_PART} else NO
    else:
        verdict = next((grade for grade in (OPEN, IN_PART) if grade in of_all), YES)
    return Judgement(verdict, grades, "; ".join(reasons))


def _grade(estimate: Estimate, strict: tuple[float, float], lenient: tuple[float, float]) -> str:
    value, low, high = estimate.numbers
    if math.isnan(value) or math.isnan(low) or math.isnan(high):
        return OPEN
    if low >= strict[0] and high <= strict[1]:
        return YES
    if high < lenient[0] or low > lenient[1]:
        return NO
    if lenient == strict or low < lenient[0] or high > lenient[1]:
        return OPEN
    return YES if strict[0] <= value <= strict[1] else IN_PART


def _reason(grade: str, estimate: Estimate, allowed: Any) -> str:
    if math.isnan(estimate.value):
        return "not found"
    if grade == OPEN and estimate.runs == 1 and math.isinf(estimate.low):
        return f"{estimate.value:.3g} in one run, whose error is not known"
    words = f"{estimate.words}, {range_in_words(allowed)} allowed"
    if grade == OPEN and estimate.still_open:
        return f"{words}; {estimate.still_open} of {estimate.runs} runs must be longer to tell"
    return words


# --- words ----------------------------------------------------------------------------------------


def sentence(template: str, numbers: dict[str, Estimate]) -> str:
    """A sentence of the ledger with its numbers in place of {name}, {value name} and the like.

    In place of a sentence with a number that was not found stands what was not found.
    """
    sentences, missing = [], []
    for part in _NEXT_SENTENCE.split(template):
        absent = [name for name in names_in(part) if math.isnan(numbers[name].value)]
        missing += absent
        if not absent:
            sentences.append(_PLACE.sub(lambda place: _in_words(numbers[place[2]], place[1]), part))
    if missing:
        sentences.append(f"Not found: {'; '.join(dict.fromkeys(missing))}.")
    return " ".join(sentences)


def names_in(template: str) -> list[str]:
    """The numbers that a sentence of the ledger names."""
    return [name for _, name in _PLACE.findall(template)]


def _in_words(estimate: Estimate, form: str) -> str:
    value, low, high, runs = *estimate.numbers, estimate.runs
    if form == "count" and runs:
        number = round(value * runs)
        count = "none" if number == 0 else "all" if number == runs else number
        return f"{count} of {runs}{f' ({estimate.still_open} open)' * bool(estimate.still_open)}"
    if form in ("count", "percent"):
        text = f"{100 * value:.3g} %"
        exact = low == high or math.isnan(low) or math.isnan(high)
        return text if exact else f"{text} ({100 * low:.3g} to {100 * high:.3g} %)"
    words = f"{value:.3g}" if form == "value" else estimate.words
    # numbers from a thousand to a billion without powers of ten: 4,740 for 4.74e+03
    return re.sub(r"\d(\.\d+)?e\+0[3-8]", lambda number: f"{float(number[0]):,.0f}", words)


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


def show(value: Any) -> str:
    """A printed value as short text: "low to high" for pairs, "name: value; ..." for dicts."""
    if value is None:
        return ""
    if isinstance(value, dict):
        return "; ".join(f"{name}: {show(inner)}" for name, inner in value.items())
    if isinstance(value, list | tuple):
        return " to ".join(show(inner) for inner in value)
    return f"{value:.4g}"

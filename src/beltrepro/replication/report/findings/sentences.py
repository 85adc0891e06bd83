"""Sentences with places for numbers: `{r-jump: ratio}` is a number of a claim with its interval.

A place is a claim and the name of a number of it, in the reading that counts. `{r-jump}` is the
only one that decides, `{why r-jump}` why the claim does not hold, `{verdict r-jump}` its verdict. A
sentence with a number that was not measured is left out. `{=preset}` is a fact of the run, by name.
"""

import math
import re
from collections.abc import Iterable, Mapping

from beltrepro.replication.report.findings.results import Number, Reading, Results

_PLACE = re.compile(r"\{([^{}]+)\}")
MINUS = "\u2212"
Facts = Mapping[str, str]


def filled(template: str, results: Results, facts: Facts | None = None) -> str | None:
    """The sentence with its numbers and facts, None if one of them is not known."""
    facts = {f"={name}": text for name, text in (facts or {}).items()}
    found = {
        place: facts.get(place, "") if place.startswith("=") else _words(place, results)
        for place in places(template)
    }
    if not all(found.values()):
        return None
    return _PLACE.sub(lambda match: str(found[match[1]]), template)


def all_filled(templates: Iterable[str], results: Results, facts: Facts | None = None) -> list[str]:
    """Those of the sentences whose numbers and facts are known."""
    return [text for each in templates if (text := filled(each, results, facts))]


def places(template: str) -> list[str]:
    """The places of a sentence, as written."""
    return _PLACE.findall(template)


def place_of(place: str) -> tuple[str, str | None]:
    """Claim and name of the number of a place; None if it has no name."""
    claim, _, name = place.removeprefix("why ").removeprefix("verdict ").partition(": ")
    return claim, name or None


def _words(place: str, results: Results) -> str:
    claim, name = place_of(place)
    if claim not in results:
        return ""
    result = results[claim]
    if place.startswith("why "):
        return typeset(result.why)
    if place.startswith("verdict "):
        return result.verdict if result.measured else ""
    number = _number(result.counted, name)
    if number is None or math.isnan(number.estimate.value):
        return ""
    return typeset(number.words)


def _number(reading: Reading, name: str | None) -> Number | None:
    if name is not None:
        return reading.numbers.get(name)
    return reading.judged[0] if len(reading.judged) == 1 else None


def typeset(text: str) -> str:
    """Signs of negative numbers and exponents as minus signs."""
    text = re.sub(r"(?<![\w.)])-(?=[\d.])|(?<=\de)-(?=\d)", MINUS, text)
    return text.replace("-inf", f"{MINUS}∞")

"""Sentences with places for numbers: `{r-jump: ratio}` is a number of a claim with its interval.

A place is a claim and the name of a number of it, in the reading that counts. `{r-jump}` is the
only one that decides, `{why r-jump}` why the claim does not hold, `{verdict r-jump}` its verdict. A
sentence with a number that was not measured is left out. `{=preset}` is a fact of the run, by name.
"""

import math
import re
from collections.abc import Iterable, Mapping

from beltrepro.replication.report.claim_results import Results

_PLACE = re.compile(r"\{([^{}]+)\}")
MINUS = "\u2212"


def filled(template: str, results: Results, facts: Mapping[str, str] | None = None) -> str | None:
    """The sentence with its numbers and facts, None if one of them is not known."""
    texts = {place: _text(place, results, facts or {}) for place in places(template)}
    if not all(texts.values()):
        return None
    return _PLACE.sub(lambda match: texts[match[1]], template)


def all_filled(
    templates: Iterable[str], results: Results, facts: Mapping[str, str] | None = None
) -> list[str]:
    """Those of the sentences whose numbers and facts are known."""
    return [text for template in templates if (text := filled(template, results, facts))]


def places(template: str) -> list[str]:
    """The places of a sentence, as written."""
    return _PLACE.findall(template)


def place_of(place: str) -> tuple[str, str | None]:
    """Claim and name of the number of a place; None if it has no name."""
    claim, _, name = place.removeprefix("why ").removeprefix("verdict ").partition(": ")
    return claim, name or None


def _text(place: str, results: Results, facts: Mapping[str, str]) -> str:
    if place.startswith("="):
        return facts.get(place[1:], "")
    claim, name = place_of(place)
    if claim not in results:
        return ""
    result = results[claim]
    if place.startswith("why "):
        return typeset(result.counted.why)
    if place.startswith("verdict "):
        return result.verdict if result.measured else ""
    judged = result.counted.judged
    if name is None and len(judged) == 1:
        name = judged[0].name
    number = result.counted.numbers.get(name) if name is not None else None
    if number is None or math.isnan(number.estimate.value):
        return ""
    return typeset(number.words)


def typeset(text: str) -> str:
    """Signs of negative numbers and exponents as minus signs."""
    text = re.sub(r"(?<![\w.)])-(?=[\d.])|(?<=\de)-(?=\d)", MINUS, text)
    return text.replace("-inf", f"{MINUS}∞")

"""Sentences with places for numbers: `{u-critical: critical}` is a number of a claim.

It is that of the reading that `replicated` judges; `{robust u-critical: critical}` is that of
`robust`. A claim alone means its only number that decides. Before it may stand `value`, `percent`
or `count`, as in the ledger. `{=preset}` is a fact of the run, by name.
"""

import math
import re
from collections.abc import Mapping

from beltrepro.replication.report.claim_results import Number, Results
from beltrepro.replication.verdicts import criteria
from beltrepro.replication.verdicts.criteria import QUESTIONS

MINUS = "\u2212"


def filled(template: str, results: Results, facts: Mapping[str, str] | None = None) -> str | None:
    """The sentence with its numbers and facts, None if one of them is not known."""
    numbers = {}
    for place in criteria.names_in(template):
        if place.startswith("="):
            if not (facts or {}).get(place[1:]):
                return None
            template = template.replace(f"{{{place}}}", facts[place[1:]])
        elif number := number_at(place, results):
            numbers[place] = number.estimate
        else:
            return None
    return typeset(criteria.sentence(template, numbers))


def place_of(place: str) -> tuple[str, str, str]:
    """Question, claim and name of the number of a place; the name may be empty."""
    robust = place.startswith("robust ")
    claim, _, name = place.removeprefix("robust ").partition(": ")
    return QUESTIONS[robust], claim, name


def number_at(place: str, results: Results) -> Number | None:
    """The number of a place, if it was found."""
    question, claim, name = place_of(place)
    if claim not in results:
        return None
    answer = results[claim].answers[question]
    if not name and len(answer.judged) == 1:
        name = answer.judged[0].name
    number = answer.numbers.get(name)
    return None if number is None or math.isnan(number.estimate.value) else number


def typeset(text: str) -> str:
    """Signs of negative numbers and exponents as minus signs."""
    text = re.sub(r"(?<![\w.)])-(?=[\d.])|(?<=\de)-(?=\d)", MINUS, text)
    return text.replace("-inf", f"{MINUS}∞")


def as_sentence(text: str) -> str:
    """With a full stop, and a capital for words, not for symbols."""
    text = text.strip()
    if not text:
        return ""
    begin = text[0].upper() if re.match(r"[a-z]{3}", text) else text[0]
    return begin + text[1:] + ("" if text.endswith((".", "?", "!", ".”")) else ".")

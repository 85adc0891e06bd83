"""What was found, in a few sentences that people wrote, each watched by its conditions.

A place like `{u-critical: critical}` is a number of a claim, of the reading that `replicated`
judges; `{robust u-critical: critical}` is that of `robust`. Before it may stand `value`, `percent`
or `count`, as in the ledger.
"""

import functools
import math
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from beltrepro.base.errors import InputError
from beltrepro.replication.report.claim_results import Results
from beltrepro.replication.verdicts import criteria
from beltrepro.replication.verdicts.ledger import read_yaml
from beltrepro.stats.estimates import Estimate, absent

_ROBUST = "robust "
WAYS = ("scheme", "exact", "starts")
WHY = "fall"  # the part with the paragraphs on why r falls, named after its study


class Finding(NamedTuple):
    """A finding and what a run makes of it."""

    topic: str  # title that says nothing of the outcome
    text: str  # with the numbers of the run
    figure: str  # name of the picture that shows it
    unmet: list[str]  # conditions that this run does not meet

    @property
    def parts(self) -> tuple[str, str]:
        """Its first sentence, and the others."""
        first, _, others = self.text.partition(". ")
        return f"{first}.", others


@functools.cache
def words() -> dict[str, Any]:
    """Findings, paragraphs on why r falls, and the table, as they stand in the file."""
    return read_yaml("beltrepro.replication.report", "findings.yaml")


def findings_of(results: Results, part: str = "findings") -> list[Finding]:
    """All of a part, `findings` or those of a study, whether they hold in this run or not."""
    return [_finding(results, **entry) for entry in words().get(part, [])]


def check(results: Results) -> None:
    """Raise InputError for the first sentence that does not hold in a run."""
    for finding in findings_of(results) + findings_of(results, WHY):
        if finding.unmet:
            raise InputError(
                f"{finding.text!r} is not what this run found: {'; '.join(finding.unmet)}; "
                "change findings.yaml in beltrepro/replication/report"
            )


def printed_and_measured(results: Results) -> Iterator[tuple[str, ...]]:
    """Rows of the table, whose columns stand in the file."""
    for entry in words()["numbers"]:
        cells = (number_at(entry[way], results).words if way in entry else "" for way in WAYS)
        claim = results.get(entry["claim"])
        verdict = claim.verdicts[criteria.QUESTIONS[1]] if claim else ""
        yield tuple(map(typeset, (entry["what"], entry["printed"], *cells, verdict)))


def filled(template: str, results: Results) -> str:
    """A sentence with its numbers."""
    numbers = {place: number_at(place, results) for place in criteria.names_in(template)}
    return typeset(criteria.sentence(template, numbers))


def number_at(place: str, results: Results) -> Estimate:
    """The number of a place; an absent one where the run has none."""
    claim, _, name = place.removeprefix(_ROBUST).partition(": ")
    if claim not in results:  # of a run by another version
        return absent()
    numbers = results[claim].answers[criteria.QUESTIONS[place.startswith(_ROBUST)]].numbers
    return numbers[name].estimate if name in numbers else absent()


def typeset(text: str) -> str:
    """Signs of negative numbers and exponents as minus signs."""
    return re.sub(r"(?<![\w.)])-(?=[\d.])|(?<=\de)-(?=\d)", "\u2212", text)


def _finding(
    results: Results, topic: str, text: str, figure: str, verdicts: dict, numbers: dict
) -> Finding:
    answers = {claim: results[claim].verdicts if claim in results else {} for claim in verdicts}
    unmet = [
        f"{claim} is {answers[claim].get(question, 'missing')} as {question}, not {verdict}"
        for claim, wanted in verdicts.items()
        for question, verdict in wanted.items()
        if answers[claim].get(question) != verdict
    ]
    if any(math.isnan(number_at(place, results).value) for place in criteria.names_in(text)):
        unmet.insert(0, "a number in it was not found")
    for place, allowed in numbers.items():
        estimate, (low, high) = number_at(place, results), criteria.bounds(allowed)
        if not low <= estimate.low <= estimate.high <= high:
            unmet.append(f"{place} is {estimate.words}, not {criteria.range_in_words(allowed)}")
    return Finding(topic, filled(text, results), figure, unmet)

"""What was found, in a few sentences that people wrote, each watched by its conditions."""

import functools
from dataclasses import dataclass
from typing import Any

from beltrepro.base.errors import InputError
from beltrepro.replication.report.claim_results import Result, Results
from beltrepro.replication.report.sentences import filled, number_at, place_of
from beltrepro.replication.verdicts.criteria import NO, YES, bounds, range_in_words
from beltrepro.replication.verdicts.ledger import read_yaml


@dataclass(frozen=True)
class Finding:
    """A finding and what a run makes of it."""

    topic: str  # title that says nothing of the outcome
    text: str  # with the numbers of the run; as it was written if the run lacks one
    figure: str  # name of the picture that shows it
    unmet: tuple[str, ...]  # conditions that this run does not meet
    results: tuple[Result, ...]  # the claims on which it rests


@functools.cache
def words() -> dict[str, list[dict[str, Any]]]:
    """The findings, and the numbers of the table below them, as they stand in the file."""
    return read_yaml("beltrepro.replication.report", "findings.yaml")


def findings_of(results: Results) -> list[Finding]:
    """All findings, whether they hold in this run or not."""
    return [_finding(**entry, results=results) for entry in words()["findings"]]


def check(results: Results) -> None:
    """Raise InputError for the first sentence that does not hold in a run."""
    for finding in findings_of(results):
        if finding.unmet:
            raise InputError(
                f"{finding.text!r} is not what this run found: {'; '.join(finding.unmet)}; "
                "change findings.yaml in beltrepro/replication/report"
            )


def _finding(
    results: Results, topic: str, text: str, figure: str, verdicts: dict, numbers: dict
) -> Finding:
    sentence = filled(text, results)
    unmet = [] if sentence else ["a number in it was not found"]
    missed = [
        missed_verdict(results, claim, question, word_of(word))
        for claim, wanted in verdicts.items()
        for question, word in wanted.items()
    ]
    missed += [missed_range(results, place, allowed) for place, allowed in numbers.items()]
    unmet += [reason for reason in missed if reason]
    claims = dict.fromkeys([*verdicts, *(place_of(place)[1] for place in numbers)])
    rests_on = tuple(results[name] for name in claims if name in results)
    return Finding(topic, sentence or text, figure, tuple(unmet), rests_on)


def missed_verdict(results: Results, claim: str, question: str, wanted: str) -> str | None:
    """In words, that a claim has another verdict; None if it has this one."""
    verdict = results[claim].verdicts[question] if claim in results else "missing"
    return None if verdict == wanted else f"{claim} is {verdict} as {question}, not {wanted}"


def missed_range(results: Results, place: str, allowed: Any) -> str | None:
    """In words, that the interval of a number leaves a range; None if it lies in it."""
    number, (low, high) = number_at(place, results), bounds(allowed)
    if number and low <= number.estimate.low <= number.estimate.high <= high:
        return None
    words_of_number = number.words if number else "not found"
    return f"{place} is {words_of_number}, not {range_in_words(allowed)}"


def word_of(verdict: str | bool) -> str:
    """A verdict of the file, where YAML takes a bare yes or no for a truth value."""
    return {True: YES, False: NO}.get(verdict, verdict)

"""What was found, in a few sentences that people wrote, each watched by its conditions."""

import functools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from beltrepro.base.errors import InputError
from beltrepro.replication.report.claim_results import Result, Results
from beltrepro.replication.report.sentences import filled, number_at, place_of, typeset
from beltrepro.replication.verdicts.criteria import NO, YES, bounds, range_in_words
from beltrepro.replication.verdicts.ledger import printed, read_yaml


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


def printed_and_measured(results: Results) -> Iterator[tuple[str, str, str, str]]:
    """What a number is, what the paper prints, and what each question gives where they differ."""
    for entry in words()["numbers"]:
        _, claim, name = place_of(entry["place"])
        replicated = number_at(entry["place"], results)
        robust = number_at(f"robust {entry['place']}", results)
        if replicated and robust and replicated.words == robust.words:
            robust = None
        paper = printed(claim)
        paper = entry.get("printed") or f"{paper[name] if isinstance(paper, dict) else paper:g}"
        measured = (number.words if number else "" for number in (replicated, robust))
        yield tuple(map(typeset, (entry["what"], paper, *measured)))


def _finding(
    results: Results, topic: str, text: str, figure: str, verdicts: dict, numbers: dict
) -> Finding:
    sentence = filled(text, results)
    unmet = [] if sentence else ["a number in it was not found"]
    wanted = [
        (claim, question, word_of(word))
        for claim, words_of_claim in verdicts.items()
        for question, word in words_of_claim.items()
    ]
    unmet += missed(results, wanted, numbers.items())
    claims = dict.fromkeys([*verdicts, *(place_of(place)[1] for place in numbers)])
    rests_on = tuple(results[name] for name in claims if name in results)
    return Finding(topic, sentence or text, figure, tuple(unmet), rests_on)


def missed(
    results: Results, verdicts: Iterable[tuple[str, str, str]], ranges: Iterable[tuple[str, Any]]
) -> Iterator[str]:
    """In words, each verdict that is another one, and each number whose interval leaves its range.

    verdicts : claim, question and the verdict wanted; ranges : place of the number and its range.
    """
    for claim, question, wanted in verdicts:
        verdict = results[claim].verdicts[question] if claim in results else "missing"
        if verdict != wanted:
            yield f"{claim} is {verdict} as {question}, not {wanted}"
    for place, allowed in ranges:
        number, (low, high) = number_at(place, results), bounds(allowed)
        if not (number and low <= number.estimate.low <= number.estimate.high <= high):
            measured = number.words if number else "not found"
            yield f"{place} is {measured}, not {range_in_words(allowed)}"


def word_of(verdict: str | bool) -> str:
    """A verdict of the file, where YAML takes a bare yes or no for a truth value."""
    return {True: YES, False: NO}.get(verdict, verdict)

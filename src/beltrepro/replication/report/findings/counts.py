"""How many claims have each verdict."""

from collections.abc import Iterable
from dataclasses import dataclass

from beltrepro.replication.report.findings.results import Result
from beltrepro.replication.verdicts.criteria import NOT_TESTABLE, VERDICTS


@dataclass(frozen=True)
class Counts:
    """Claims that could come out otherwise, by verdict; and those true by construction.

    by_verdict : number of claims with each of VERDICTS.
    construction : claims that are true because the model is built so.
    """

    by_verdict: dict[str, int]
    construction: int

    @property
    def total(self) -> int:
        """Claims that could come out otherwise."""
        return sum(self.by_verdict.values())

    @property
    def testable(self) -> int:
        """Those of them that a simulation can test."""
        return self.total - self.by_verdict[NOT_TESTABLE]


def count(results: Iterable[Result]) -> Counts:
    """Count the claims of a run."""
    results = list(results)
    findings = [each.verdict for each in results if each.claim.finding]
    return Counts(
        {verdict: findings.count(verdict) for verdict in VERDICTS}, len(results) - len(findings)
    )

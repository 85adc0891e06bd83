"""What a finished run found, in sentences that take every number from its tables of claims."""

from beltrepro.replication.report.findings.counts import Counts, count
from beltrepro.replication.report.findings.results import Number, Reading, Result, Results, read
from beltrepro.replication.report.findings.topics import Finding, chosen

__all__ = [
    "Counts",
    "Finding",
    "Number",
    "Reading",
    "Result",
    "Results",
    "chosen",
    "count",
    "read",
]

"""What a finished run found, in sentences that take every number from its tables of claims."""

from beltrepro.findings.counts import Counts, count
from beltrepro.findings.results import Number, Reading, Result, Results, read
from beltrepro.findings.topics import Finding, chosen

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

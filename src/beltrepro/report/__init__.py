"""The report: one HTML page with verdicts, figures and what was run, that needs no network."""

from beltrepro.report.agreement import Tables as AgreementTables
from beltrepro.report.rendering import render

__all__ = ["AgreementTables", "render"]

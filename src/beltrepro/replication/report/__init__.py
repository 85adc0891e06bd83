"""The report: one HTML page with verdicts, figures and what was run, that needs no network."""

from beltrepro.replication.report.material import Material
from beltrepro.replication.report.rendering import part, render

__all__ = ["Material", "part", "render"]

"""What method, time step, length, transient and initial state make of the claims that matter."""

from beltrepro.replication.report.findings.readings import CHANGES, shifts

TITLE = "Sensitivity"
ANCHOR = "sensitivity"
NEEDS = ("claims", "estimates")


def gather(material) -> dict:
    """Rows by what is changed, and what no reading of these claims changes."""
    rows = shifts(material.claims)
    groups = {what: [row for row in rows if row.what == what] for what in CHANGES}
    return {
        "groups": {what: own for what, own in groups.items() if own},
        "untried": [what for what, own in groups.items() if not own],
    }

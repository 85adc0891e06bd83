"""The table of claims, with a link from each to its figure."""

from beltrepro.claims.criteria import VERDICTS
from beltrepro.report.sections.summary import count_verdicts

TITLE = "Claims"
ANCHOR = "claims"
NEEDS = ("claims",)


def gather(material) -> dict:
    """Claims, verdicts with their counts, and the anchors of figures by their number."""
    return {
        "claims": material.claims,
        "verdicts": VERDICTS,
        "counts": count_verdicts(material.claims),
        "anchors": {each["number"]: each["name"] for each in material.pictures if each["number"]},
    }

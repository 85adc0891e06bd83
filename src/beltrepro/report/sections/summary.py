"""Above everything: what was done, what came out, and how far it can be trusted."""

from beltrepro.claims.criteria import VERDICTS
from beltrepro.findings import chosen, count
from beltrepro.findings.reliability import trust
from beltrepro.report.sections.figures import on_page

MOST, SENTENCES = 5, 4  # findings on the first screen, and sentences of each


def gather(material) -> dict:
    """What was run in numbers, findings, number of claims with each verdict, and trust."""
    return {
        "preset": material.preset,
        "datasets": len(material.datasets),
        "pictures": len(material.pictures_of("Figures of the paper")),
        "findings": chosen(material.claims)[:MOST],
        "shown": SENTENCES,
        "drawn": {each["name"] for each in on_page(material)},
        "verdicts": VERDICTS,
        "counts": count(material.claims.values()),
        "trust": trust(material.claims, material.settings, material.comparison),
    }

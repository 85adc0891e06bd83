"""Above everything: what was done, what came out, and how far it can be trusted."""

from beltrepro.replication.report.findings import chosen, count
from beltrepro.replication.report.findings.reliability import trust
from beltrepro.replication.report.sections.figures import on_page
from beltrepro.replication.verdicts.criteria import VERDICTS

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

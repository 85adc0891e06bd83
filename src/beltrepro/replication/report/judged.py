"""Sections on what was judged: summary, claims, their readings, and other runs."""

from beltrepro.replication.report.claim_results import Result, count
from beltrepro.replication.report.findings import findings_of
from beltrepro.replication.report.material import Material
from beltrepro.replication.report.readings import depends_on_reading, differing, printed, shifts
from beltrepro.replication.report.trust import trust
from beltrepro.replication.verdicts.criteria import VERDICTS
from beltrepro.replication.verdicts.ledger import SECTIONS, read_yaml

TABLES = ("claims", "estimates")  # files that these sections need
MOST, SENTENCES = 5, 4  # findings on the first screen, and sentences of each
WORDS = read_yaml("beltrepro.replication.report", "page.yaml")
BUILT_SO = "True because the model is built so"
SHOWN_BY = {claim: name for name, claims in WORDS["shown_by"].items() for claim in claims}


def summary(material: Material) -> dict:
    """What was run in numbers, findings, number of claims with each verdict, and trust."""
    return {
        "preset": material.preset,
        "datasets": len(material.datasets),
        "pictures": sum(bool(picture["number"]) for picture in material.pictures),
        "findings": findings_of(material.claims)[:MOST],
        "shown": SENTENCES,
        "drawn": set(material.images),
        "verdicts": VERDICTS,
        "counts": count(material.claims),
        "trust": list(trust(material.claims, material.settings, material.others)),
    }


def cards(material: Material) -> dict:
    """Claims by group, with their pictures; verdicts with their counts."""
    titles = WORDS["groups"]
    groups: dict[str, list] = {title: [] for title in (*map(titles.get, SECTIONS), BUILT_SO)}
    for result in material.claims.values():
        group = titles[result.claim.section] if result.claim.finding else BUILT_SO
        groups[group].append(_card(result, material.pictures))
    return {
        "groups": {title: group for title, group in groups.items() if group},
        "verdicts": VERDICTS,
        "counts": count(material.claims),
    }


def sensitivity(material: Material) -> dict:
    """Rows by what is changed, and what no reading of these claims changes."""
    by_change = shifts(material.claims)
    return {
        "groups": {what: rows for what, rows in by_change.items() if rows},
        "untried": [what for what, rows in by_change.items() if not rows],
    }


def open_points(material: Material) -> dict:
    """Printed numbers beside what the readings span; points of the model, and of claims."""
    results = list(material.claims.values())
    return {
        "printed": printed(results),
        "model": WORDS["model"],
        "claims": [(result, depends_on_reading(result)) for result in results if result.claim.open],
    }


def presets(material: Material) -> dict:
    """Other runs, and the claims that any two runs judge differently."""
    rows = differing(material.claims, material.others)
    return {"others": material.others, "rows": rows, "preset": material.preset}


def _card(result: Result, pictures: list[dict]) -> dict:
    """The result, the figure of its number, and another picture that shows it, if there is one."""
    number = "" if result.claim.figure is None else str(result.claim.figure)
    figure = next((picture for picture in pictures if number and picture["number"] == number), None)
    shown = shown_by(result, pictures, figure)
    other = shown if shown is not figure else None
    return {"result": result, "number": number, "figure": figure, "shown": other}


def shown_by(result: Result, pictures: list[dict], figure: dict | None = None) -> dict | None:
    """The picture that shows a claim best, its figure, or what shares most datasets with it."""
    for picture in pictures:
        if picture["name"] == SHOWN_BY.get(result.id):
            return picture
    if figure:
        return figure
    used = set(result.dataset.split(", "))

    def shared(picture: dict) -> tuple[int, int]:
        return len(used & set(picture["uses"])), -len(picture["uses"])

    best = max(pictures, key=shared, default=None)
    return best if best and shared(best)[0] else None

"""Sections on what was judged: first screen, claims, dates of their criteria, and other runs."""

from beltrepro.replication.report import trust
from beltrepro.replication.report.claim_results import Result, count
from beltrepro.replication.report.findings import findings_of
from beltrepro.replication.report.material import Material
from beltrepro.replication.verdicts.criteria import QUESTIONS
from beltrepro.replication.verdicts.ledger import SEEN, read_yaml

TABLES = ("claims", "estimates")  # files that these sections need
WORDS = read_yaml("beltrepro.replication.report", "page.yaml")


def summary(material: Material) -> dict:
    """What was run in numbers, findings, claims counted by both verdicts, and trust."""
    results = material.claims
    return {
        "preset": material.preset,
        "datasets": len(material.datasets),
        "pictures": sum(bool(picture["number"]) for picture in material.pictures),
        "findings": findings_of(results),
        "drawn": set(material.images),
        "first": [one for one in material.pictures if one["name"] in WORDS["first"]],
        "counts": count(results),
        "trust": [*trust.trust(results, material.settings, material.others), trust.dates(results)],
    }


def cards(material: Material) -> dict:
    """Claims by group, those that are counted apart last, with their pictures; counts."""
    titles = WORDS["groups"]
    groups: dict[str, list] = {title: [] for title in titles.values()}
    for result in material.claims.values():
        claim = result.claim
        group = titles[claim.section if claim.finding else claim.kind]
        groups[group].append(_card(result, material.pictures))
    return {
        "groups": {title: group for title, group in groups.items() if group},
        "counts": count(material.claims),
    }


def dates(material: Material) -> dict:
    """How many criteria are from after which runs, and those from after the published one."""
    after = trust.dated(material.claims, SEEN[-1])
    return {"sentence": trust.dates(material.claims), "seen": SEEN[-1], "after": after}


def open_points(material: Material) -> dict:
    """Points that the paper leaves open: of the model, and of claims."""
    claims = [result for result in material.claims.values() if result.claim.open]
    return {"model": WORDS["model"], "claims": claims}


def presets(material: Material) -> dict:
    """How far other runs agree with this one, and the claims that both decide differently."""
    results = material.claims
    return {
        "preset": material.preset,
        "others": [
            {
                "name": other.name,
                "agreement": {q: other.agreement(results, q) for q in QUESTIONS},
                "differing": [
                    (name, question, *pair)
                    for question in QUESTIONS
                    for name, pair in other.pairs(results, question).items()
                    if pair[0] != pair[1]
                ],
            }
            for other in material.others
        ],
    }


def _card(result: Result, pictures: list[dict]) -> dict:
    """The result, the figure of its number, and other pictures that show a number of it."""
    number = "" if result.claim.figure is None else str(result.claim.figure)
    figure = next((picture for picture in pictures if number and picture["number"] == number), None)
    shown = [picture for picture in pictures if picture["name"] in result.figures]
    others = [picture for picture in shown if picture is not figure]
    return {"result": result, "number": number, "figure": figure, "shown": others}

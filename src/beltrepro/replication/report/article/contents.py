"""What the article says, as plain values for its template."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from beltrepro.replication.plan import registry
from beltrepro.replication.report import findings
from beltrepro.replication.report.findings import Finding, Result, Results
from beltrepro.replication.report.findings.reliability import (
    DECIDING,
    PAPER_DURATION,
    length,
    trust,
)
from beltrepro.replication.report.findings.sentences import all_filled, typeset
from beltrepro.replication.verdicts import packaged
from beltrepro.replication.verdicts.criteria import FAILS, NOT_MEASURED, PARTLY, UNDECIDED

TITLE = "Chaos on the conveyor belt"
KEYWORDS = ("spring-block model", "stick-slip motion", "avalanches", "chaos", "replication")
MOST_FIGURES = 5


@dataclass(frozen=True)
class Material:
    """What the article is made from."""

    settings: Mapping[str, Any]
    claims: Path
    estimates: Path
    figures: Mapping[str, Path]
    authors: tuple[str, ...]


def content(material: Material) -> dict[str, Any]:
    """All words and numbers of the article, as JSON has them."""
    results = findings.read(material.claims, material.estimates)
    chosen = findings.chosen(results)
    judged = [each for each in results.values() if each.claim.finding]
    told = facts(results, material.settings, _origin(material.claims))
    sections = {
        name: _paragraphs(paragraphs, results, told) for name, paragraphs in _texts().items()
    }
    sections["abstract"] += [" ".join(each.heading for each in chosen)]
    return {
        "title": f"[Re] {TITLE}",
        "authors": list(material.authors),
        "keywords": list(KEYWORDS),
        **sections,
        "findings": _with_figures(chosen, material.figures),
        "trust": typeset(" ".join(trust(results, material.settings))),
        "failing": [_short(each) for each in judged if each.verdict in (FAILS, PARTLY)],
        "undecided": [_short(each) for each in judged if each.verdict in (UNDECIDED, NOT_MEASURED)],
        "claims": [_row(each) for each in judged],
        "construction": [each.id for each in results.values() if not each.claim.finding],
    }


def facts(
    results: Results, settings: Mapping[str, Any], origin: Mapping[str, Any]
) -> dict[str, str]:
    """Facts of the run as short texts by name; those that are not known lack."""
    counts = findings.count(results.values())
    found = {name: str(number) for name, number in counts.by_verdict.items()}
    found |= {"testable": str(counts.testable), "preset": settings["preset"]}
    found |= {name: f"{value:g}" for name, value in settings.get("model", {}).items()}
    found |= {name: f"{settings['defaults'][name]:g}" for name in ("time_step", "seed")
              if name in settings["defaults"]}  # fmt: skip
    deciding = settings.get("datasets", {}).get(DECIDING)
    if deciding:
        found |= {name: length(float(deciding[name])) for name in ("duration", "transient")}
        found["replicates"] = str(len(deciding["replicate"]))
        if deciding["duration"] < PAPER_DURATION:
            found["shorter"] = found["duration"]
    if origin:
        libraries = json.loads(origin["library_versions"])
        found["code_version"] = origin["code_version"]
        found["libraries"] = ", ".join(f"{name} {number}" for name, number in libraries.items())
    return found


def name_of(author: Mapping[str, str]) -> str:
    """Name of an author of CITATION.cff, a person or a group."""
    parts = (author.get("given-names"), author.get("family-names"))
    return author.get("name") or " ".join(filter(None, parts))


def _texts() -> dict[str, list[list[str]]]:
    return packaged.read_yaml("beltrepro.replication.report.article", "text.yaml")


def _paragraphs(paragraphs: list[list[str]], results: Results, told: dict[str, str]) -> list[str]:
    """Paragraphs without the sentences that lack a number; those without any sentence are gone."""
    found = (" ".join(all_filled(each, results, told)) for each in paragraphs)
    return [each for each in found if each]


def _origin(claims: Path) -> dict[str, Any]:
    """What made the table of claims, as the file beside it says; empty if there is none."""
    path = claims.with_name(f"{claims.name}-metadata.json")
    if not path.is_file():
        return {}
    return json.loads(path.read_text(encoding="utf-8"))["beltrepro:origin"]


def _with_figures(chosen: list[Finding], figures: Mapping[str, Path]) -> list[dict[str, Any]]:
    """Findings, the first ones with their figure."""
    entries = registry.figures()
    found, shown = [], 0
    for each in chosen:
        picture = None
        if shown < MOST_FIGURES and each.figure in figures:
            shown += 1
            entry = entries[each.figure]
            number = f" (Fig. {entry.number} of the paper)" if entry.number else ""
            caption = f"{entry.title.removesuffix('.')}{number}."
            picture = {"file": f"{each.figure}.png", "alt": entry.alt, "caption": caption}
        found.append(
            {
                "topic": each.topic,
                "verdict": each.verdict,
                "heading": each.heading,
                "text": " ".join(each.sentences),
                "figure": picture,
                "claims": [{"id": result.id, "verdict": result.verdict} for result in each.results],
            }
        )
    return found


def _short(result: Result) -> dict[str, str]:
    """A claim that does not hold, and why in words; its numbers stand in the table."""
    return {
        "id": result.id,
        "verdict": result.verdict,
        "statement": result.claim.statement,
        "why": typeset(result.counted.said),
    }


def _row(result: Result) -> dict[str, Any]:
    """A row of the table of claims."""
    return {
        "id": result.id,
        "figure": str(result.claim.figure or ""),
        "verdict": result.verdict,
        "numbers": [
            {
                "name": typeset(each.name),
                "words": typeset(each.words),
                "allowed": typeset(each.allowed_words),
                "verdict": each.verdict,
            }
            for each in result.counted.judged
        ],
    }

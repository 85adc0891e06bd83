"""The article: a short account of a run as PDF, each number from its tables of claims."""

import json
import shutil
import tempfile
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import typst

from beltrepro.base.atomic import replacing
from beltrepro.replication.plan import registry
from beltrepro.replication.report.claim_results import Answer, Result, Results, count
from beltrepro.replication.report.findings import Finding, findings_of
from beltrepro.replication.report.material import Material
from beltrepro.replication.report.sentences import as_sentence, filled, typeset
from beltrepro.replication.report.trust import (
    DECIDING,
    PAPER_DURATION,
    dated,
    dates,
    length,
    trust,
)
from beltrepro.replication.verdicts import ledger
from beltrepro.replication.verdicts.criteria import IN_PART, NO, OPEN

KEYWORDS = ("spring-block model", "stick-slip motion", "avalanches", "chaos", "replication")
MOST_FIGURES = 5
TEMPLATE = "article.typ"
_ROOM = "beltrepro.replication.report"


def write(output: Path, material: Material, authors: list[str]) -> None:
    """Set the article as PDF/UA (tagged for screen readers); the same content, the same bits."""
    article = content(material, authors)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)  # all that the typesetter sees
        template = resources.files(_ROOM).joinpath(TEMPLATE).read_bytes()
        (folder / TEMPLATE).write_bytes(template)
        (folder / "content.json").write_text(json.dumps(article), encoding="utf-8")
        for figure in (finding["figure"] for finding in article["findings"]):
            if figure:
                shutil.copyfile(material.images[figure["name"]], folder / figure["file"])
        pdf = typst.compile(
            folder / TEMPLATE, root=folder, ignore_system_fonts=True, pdf_standards=["ua-1"]
        )
    with replacing(output) as unfinished:
        unfinished.write_bytes(pdf)


def name_of(author: Mapping[str, str]) -> str:
    """Name of an author of CITATION.cff, a person or a group."""
    parts = (author.get("given-names"), author.get("family-names"))
    return author.get("name") or " ".join(filter(None, parts))


def content(material: Material, authors: list[str]) -> dict[str, Any]:
    """All words and numbers of the article, as JSON has them."""
    results = material.claims
    findings = [finding for finding in findings_of(results) if not finding.unmet]
    about = facts(results, material.settings, _origin(material.file("claims")))
    sections: dict[str, list[str]] = {}
    for name, paragraphs in texts().items():
        filled_texts = (
            [filled(text, results, about) for text in sentences] for sentences in paragraphs
        )
        # a sentence without its number is left out, and so is a paragraph without any sentence
        sections[name] = [
            words for texts in filled_texts if (words := " ".join(filter(None, texts)))
        ]
    sections["abstract"] += [" ".join(finding.text for finding in findings)]
    return {
        "title": "[Re] Chaos on the conveyor belt",
        "authors": authors,
        "keywords": list(KEYWORDS),
        **sections,
        "findings": _with_figures(findings, material.images),
        "trust": typeset(" ".join(trust(results, material.settings))),
        "dates": dates(results),
        "after": [result.id for result in dated(results, ledger.SEEN[-1])],
        "against": _listed(results, NO, IN_PART),
        "open": _listed(results, OPEN),
        "claims": [_row(result) for result in results.values() if result.claim.finding],
        "apart": [
            {"id": result.id, "kind": result.claim.kind, "verdict": result.verdicts["replicated"]}
            for result in results.values()
            if not result.claim.finding
        ],
    }


def _listed(results: Results, *verdicts: str) -> list[dict[str, Any]]:
    """Statements that have one of these verdicts, with what was found for the questions that do."""
    listed = []
    for result in results.values():
        sentences = {
            question: typeset(as_sentence(answer.found))
            for question, answer in result.answers.items()
            if answer.verdict in verdicts
        }
        if sentences and result.claim.finding:
            statement = {"id": result.id, "statement": result.claim.statement}
            listed.append(statement | result.verdicts | {"found": _once(sentences)})
    return listed


def _once(texts: dict[str, str]) -> dict[str, str]:
    """Texts by question; one without a question if all are the same."""
    same = len(texts) > 1 and len({*texts.values()}) == 1
    return {"": next(iter(texts.values()))} if same else texts


def facts(
    results: Results, settings: Mapping[str, Any], origin: Mapping[str, Any]
) -> dict[str, str]:
    """Facts of the run as short texts by name; those that are not known lack."""
    counts = count(results)
    about = {"testable": str(counts.testable), "preset": settings["preset"]}
    for question, numbers in counts.verdicts.items():
        about |= {f"{question} {verdict}": str(number) for verdict, number in numbers.items()}
    defaults = settings["defaults"]
    constants = settings.get("model", {}) | {
        name: defaults[name] for name in ("time_step", "seed") if name in defaults
    }
    about |= {name: f"{value:g}" for name, value in constants.items()}
    deciding = settings.get("datasets", {}).get(DECIDING)
    if deciding:
        about |= {name: length(float(deciding[name])) for name in ("duration", "transient")}
        about["replicates"] = str(len(deciding["replicate"]))
        if more := deciding.get("more_runs"):
            about["replicates"] += f" to {more['up_to']}"
        if deciding["duration"] < PAPER_DURATION:
            about["shorter"] = about["duration"]
    if origin:
        libraries = json.loads(origin["library_versions"])
        about["code_version"] = origin["code_version"]
        about["libraries"] = ", ".join(f"{name} {number}" for name, number in libraries.items())
    return about


def texts() -> dict[str, list[list[str]]]:
    """Sentences of the article, by section and paragraph."""
    return ledger.read_yaml(_ROOM, "article.yaml")


def _origin(table: Path) -> dict[str, Any]:
    """What made the table of claims, as the file beside it says; empty if there is none."""
    path = table.with_name(f"{table.name}-metadata.json")
    if not path.is_file():
        return {}
    return json.loads(path.read_text(encoding="utf-8"))["beltrepro:origin"]


def _with_figures(findings: list[Finding], images: Mapping[str, Path]) -> list[dict[str, Any]]:
    """Findings, the first ones with their figure."""
    first = {finding.figure: finding for finding in reversed(findings) if finding.figure in images}
    pictured = [finding for finding in findings if finding is first.get(finding.figure)]
    pictured = pictured[:MOST_FIGURES]
    return [
        {
            "topic": finding.topic,
            "text": finding.text,
            "figure": _figure(finding.figure) if finding in pictured else None,
            "claims": [{"id": result.id, **result.verdicts} for result in finding.results],
        }
        for finding in findings
    ]


def _figure(name: str) -> dict[str, str]:
    entry = registry.figures()[name]
    number = f" (Fig. {entry.number} of the paper)" if entry.number else ""
    caption = f"{entry.title.removesuffix('.')}{number}."
    return {"name": name, "file": f"{name}.png", "alt": entry.alt, "caption": caption}


def _row(result: Result) -> dict[str, Any]:
    """A row of the table of claims; numbers once where both questions judge the same ones."""
    numbers = {question: _numbers(answer) for question, answer in result.answers.items()}
    about = {"id": result.id, "figure": str(result.claim.figure or ""), **result.verdicts}
    return about | {"numbers": _once({name: text for name, text in numbers.items() if text})}


def _numbers(answer: Answer) -> str:
    """The numbers that decide, with the ranges that are allowed."""
    numbers = (f"{n.name} {n.words} [{n.allowed_words}]" for n in answer.judged)
    return typeset("; ".join(numbers))

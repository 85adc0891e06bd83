"""`beltrepro claims`: the verdicts of a run in the terminal."""

from __future__ import annotations

import argparse
import json
import shutil
import textwrap
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltrepro.base.errors import InputError
from beltrepro.cli import options as shared

if TYPE_CHECKING:
    from beltrepro.replication.report.claim_results import Answer, Result, Results

QUESTIONS = ("replicated", "robust")


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "print the verdicts of a run on the claims of the paper",
        "Print each claim of the paper with two verdicts, and what was found: whether it is "
        "replicated by the authors' protocol, and whether it is robust.",
    )
    option = parser.add_argument
    option("--preset", default="standard", metavar="NAME", help="run to read: results/NAME")
    option("--results", type=Path, metavar="FOLDER", help="another folder than results/NAME")
    for question in QUESTIONS:
        text = f"only claims with this verdict as {question}: yes, in-part, no, open, not-testable"
        option(f"--{question}", metavar="WORD", help=text)
    option("--json", action="store_true", help="print everything as JSON")


def run(options: argparse.Namespace) -> None:
    """Print the table."""
    from beltrepro.replication.report.claim_results import count, read

    results = read(options.results or _made(options.preset))
    shown = results
    for question in QUESTIONS:
        if word := getattr(options, question):
            shown = _with_verdict(shown, question, word.replace("-", " "))
    if options.json:
        print(json.dumps([_plain(result) for result in shown.values()], indent=1))
        return
    print(_table(shown))
    for question, numbers in count(results).items():
        words = ", ".join(f"{number} {verdict}" for verdict, number in numbers.items() if number)
        print(f"\n{question}: {words}", end="")
    print()


def _with_verdict(results: Results, question: str, word: str) -> Results:
    verdicts = {result.verdicts[question] for result in results.values()}
    if word not in verdicts:
        has = ", ".join(sorted(verdicts)) or "none"
        raise InputError(f"--{question} {word}: no claim has it; there are {has}")
    return {name: result for name, result in results.items() if result.verdicts[question] == word}


def _plain(result: Result) -> dict[str, Any]:
    """A claim as plain values; JSON has no infinity and no NaN, so such an end is null."""
    about = {
        "id": result.id,
        "figure": result.claim.figure,
        "kind": result.claim.kind,
        "says": result.claim.says,
        "statement": result.claim.statement,
        "paper": result.paper,
        "seen": result.claim.seen,
        "note": result.note,
    }
    return about | {question: _answer(answer) for question, answer in result.answers.items()}


def _answer(answer: Answer) -> dict[str, Any]:
    """A verdict as plain values, with the numbers of its reading."""
    numbers = []
    for number in answer.numbers.values():
        ends = dict(zip(("allowed_low", "allowed_high"), number.allowed, strict=True))
        values = asdict(number.estimate) | ends
        del values["still_open"]  # not in the tables
        finite = {k: None if v is None or not isfinite(v) else v for k, v in values.items()}
        numbers.append({"name": number.name} | finite | {"verdict": number.verdict})
    texts = {name: text for name, text in vars(answer).items() if name != "numbers"}
    return texts | {"estimates": numbers}


def _made(preset: str) -> Path:
    """The folder of a run by the name of its preset."""
    folder = Path("results", preset)
    if not folder.exists():
        published = Path("docs", "results", preset)
        other = f"; to read the published one: --results {published}" if published.is_dir() else ""
        raise InputError(
            f"preset = {preset!r}: {folder} is not made yet: "
            f"snakemake --cores 2 --config preset={preset}{other}"
        )
    return folder


def _table(results: Results) -> str:
    from tabulate import tabulate

    width = max(30, shutil.get_terminal_size((110, 24)).columns - 60)
    rows = []
    for result in results.values():
        sentences = dict.fromkeys(
            answer.found for answer in result.answers.values() if answer.found
        )
        lines = "\n".join(
            textwrap.fill(text, width) for text in sentences or [result.claim.statement]
        )
        rows.append((result.id, result.claim.figure, *result.verdicts.values(), lines))
    headers = ("claim", "figure", *QUESTIONS, "what was found")
    return tabulate(rows, headers=headers, tablefmt="simple")

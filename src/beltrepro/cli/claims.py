"""`beltrepro claims`: the verdicts of a run in the terminal."""

from __future__ import annotations

import argparse
import json
import shutil
import textwrap
from collections import Counter
from dataclasses import asdict
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltrepro.base.errors import InputError
from beltrepro.cli import options as shared

if TYPE_CHECKING:
    from beltrepro.replication.report.claim_results import Result


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        "claims",
        run,
        "print the verdicts of a run on the claims of the paper",
        "Print each claim of the paper with its verdict and the numbers it rests on: "
        "95 % intervals, and in brackets the allowed ranges.",
    )
    option = parser.add_argument
    option("--preset", default="standard", metavar="NAME", help="run to read: results/NAME")
    option("--results", type=Path, metavar="FOLDER", help="another folder than results/NAME")
    option("--verdict", metavar="WORD", help="only claims with this verdict, as fails")
    option("--json", action="store_true", help="print everything as JSON")


def run(options: argparse.Namespace) -> None:
    """Print the table."""
    from beltrepro.replication.report.claim_results import read

    folder = options.results or Path("results", options.preset)
    results = list(read(folder).values())
    if options.verdict:
        verdicts = {result.verdict for result in results}
        if options.verdict not in verdicts:
            raise InputError(
                f"--verdict {options.verdict}: no claim of {folder} has it; "
                f"they have {', '.join(sorted(verdicts))}"
            )
        results = [result for result in results if result.verdict == options.verdict]
    if options.json:
        print(json.dumps([_plain(result) for result in results], indent=1))
        return
    print(_table(results))
    counts = Counter(result.verdict for result in results)
    print("\n" + ", ".join(f"{count} {verdict}" for verdict, count in counts.most_common()))


def _plain(result: Result) -> dict[str, Any]:
    """A claim as plain values; JSON has no infinity and no NaN, so such an end is null."""
    numbers = []
    for number in result.counted.numbers.values():
        ends = dict(zip(("allowed_low", "allowed_high"), number.allowed or (nan, nan), strict=True))
        values = asdict(number.estimate) | ends
        del values["still_open"]  # not in the tables
        finite = {k: None if v is None or not isfinite(v) else v for k, v in values.items()}
        numbers.append({"name": number.name} | finite | {"verdict": number.verdict})
    return {
        "id": result.id,
        "figure": result.claim.figure,
        "kind": result.claim.kind,
        "statement": result.claim.statement,
        "paper": result.paper,
        "criterion": result.criterion,
        "verdict": result.verdict,
        "reason": result.counted.reason,
        "note": result.counted.note,
        "estimates": numbers,
    }


def _table(results: list[Result]) -> str:
    from tabulate import tabulate

    width = max(30, shutil.get_terminal_size((110, 24)).columns - 50)
    rows = []
    for result in results:
        parts = [
            (f"{number.name}: " if number.name else "")
            + number.words
            + (f" [{number.allowed_words}]" if number.allowed_words else "")
            for number in result.counted.numbers.values()
        ] or [result.counted.note]
        lines = "\n".join(textwrap.fill(part, width) for part in parts)
        rows.append((result.id, result.claim.figure, result.verdict, lines))
    return tabulate(rows, headers=("claim", "figure", "verdict", "measured"), tablefmt="simple")

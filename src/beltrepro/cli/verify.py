"""`beltrepro verify`: results compared with the published list."""

import argparse
import sys
from collections import Counter
from pathlib import Path
from typing import Any

from beltrepro.base.errors import InputError
from beltrepro.cli import options as shared


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "check results of the workflow, and compare them with the published list",
        "Check that every dataset and table of a run is whole, and compare it with a list of "
        "checksums: bit by bit if the processor, its instructions and the libraries are those of "
        "the list, otherwise within bounds (docs/workflow.md). Exit status 1 if anything is "
        "wrong; each line of it says how to repair it.",
    )
    option = parser.add_argument
    option("results", type=Path, help="folder of a run, as results/smoke")
    option("--list", type=Path, metavar="FILE", help="the list (docs/results/NAME.json)")
    option("--write", action="store_true", help="write the list from these results instead")


def run(options: argparse.Namespace) -> int:
    """Compare, and print what differs."""
    from beltrepro.extras import verification

    path = options.list or Path("docs", "results", f"{options.results.name}.json")
    if options.write:
        count = verification.write_list(path, options.results)
        print(f"{path}: {count} datasets")
        return 0
    if not options.results.is_dir():
        raise InputError(f"{options.results}: no such folder")
    findings = list(verification.compare(options.results, verification.read_list(path)))
    wrong = [finding for finding in findings if finding.outcome == verification.WRONG]
    for finding in wrong:
        print(f"error: {finding.words}", file=sys.stderr)
    counts = Counter(finding.outcome for finding in findings)
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    print(verification.conclusion(findings))
    return int(bool(wrong))

"""`beltrepro publish`: results of a run in docs/results, and their numbers in README.md."""

import argparse
from pathlib import Path
from typing import Any

from beltrepro.cli import options as shared


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "copy report, article, figures and tables of a run to docs/results",
        "Copy report, article, figures (PNG), tables of claims and a list of checksums "
        "of a finished run to docs/results, and write its main numbers into README.md. In a clone "
        "only. At most 20 MB.",
    )
    option = parser.add_argument
    option("results", type=Path, metavar="FOLDER", help="the run: results/paper")


def run(options: argparse.Namespace) -> None:
    """Publish."""
    from beltrepro.replication.report import publishing

    folder = publishing.publish(options.results)
    publishing.write_block(Path("README.md"))
    print(f"{folder}: {publishing.size(folder) / 1e6:.1f} MB; README.md has its numbers")

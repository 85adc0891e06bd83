"""`beltrepro bench`: the speed of the integrators."""

import argparse
import json
from pathlib import Path
from typing import Any

from beltrepro.base.errors import InputError
from beltrepro.cli import options as shared


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "measure the speed of the integrators",
        "Measure, in one interleaved run: nanoseconds per chain and unit of model time, beside "
        "plain loops and solve_ivp; scaling with chains, blocks and cores; peak memory; time "
        "to the first step. A few minutes; best on a machine that does nothing else.",
        epilog="Competitors: numba and c (a plain loop over one chain), scipy (solve_ivp, only "
        "without noise), steps (verlet without leaps; only without noise), verlet, "
        "event, tangent (event with a deviation vector). What cannot run here is n/a: c without a "
        "compiler.",
    )
    option = parser.add_argument
    option("--rounds", type=int, default=5, help="timings of each quantity; the median counts")
    option("--quick", action="store_true", help="few cases, short timings: to see that it works")
    words = "some competitors; the loop in numba is always there"
    option("--only", metavar="NAME,NAME", help=words)
    words = "another source tree: only verlet and event, here and there in turns"
    option("--against", type=Path, metavar="FOLDER", help=words)
    option("--json", action="store_true", help="print every timing as JSON instead of tables")
    shared.add_output(parser, "write the tables to this Markdown file, .md")


def run(options: argparse.Namespace) -> None:
    """Measure, and print or write the tables."""
    if options.against and options.output:
        raise InputError("output: not with --against, which prints its table")
    shared.check_output(options, ".md")
    from beltrepro.extras.bench import measuring, table

    settings = {
        "rounds": options.rounds,
        "quick": options.quick,
        "only": [name.strip() for name in options.only.split(",")] if options.only else None,
        "progress": shared.progress_of("bench"),
    }
    if options.against:
        result: Any = measuring.compare(options.against, **settings)
        text = table.comparison(result, str(options.against))
    else:
        result = measuring.measure(**settings)
        text = table.as_text(result)
    if options.output:
        options.output.write_text(table.as_markdown(result), encoding="utf-8")
    print(json.dumps(result, indent=2) if options.json else text)

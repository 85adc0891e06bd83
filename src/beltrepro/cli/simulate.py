"""`beltrepro simulate`: one run of one chain."""

import argparse
import sys
from pathlib import Path
from typing import Any

from beltrepro.base.checks import positive
from beltrepro.cli import options as shared
from beltrepro.cli.options import CHAIN

_FILE = """ The file of --output holds time (T), positions, velocities and friction (T, N) of the
samples, in the laboratory frame, and the events; groups initial_state and final_state; and the
settings as attributes. In Python: beltrepro.Run.load(FILE)."""


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "simulate one chain",
        "Simulate one chain from all blocks stuck and undeformed springs.",
        epilog=shared.UNITS + _FILE,
    )
    option = parser.add_argument
    shared.add_run(parser)
    option("--sample-interval", type=float, default=0.1, help="time between samples in --output")
    words = "go on where the run in this file, written by --output, has ended, with the chain of "
    words += "the options"
    option("--from-state", type=Path, metavar="FILE", help=words)
    shared.add_output(parser, "write the run to this .h5 file, see below")


def run(options: argparse.Namespace) -> None:
    """Simulate, print r and write the run."""
    chain = shared.chain_of(options)
    shared.check_output(options, ".h5")
    positive("sample_interval", options.sample_interval)  # also where there are no samples
    from beltrepro import Run, simulate

    before = Run.load(options.from_state) if options.from_state else None
    if before and before.parameters != chain:
        pairs = {name: (getattr(before.parameters, name), getattr(chain, name)) for name in CHAIN}
        words = [f"{name} {old} -> {new}" for name, (old, new) in pairs.items() if old != new]
        print(
            f"warning: not the chain of {options.from_state}: {', '.join(words)}", file=sys.stderr
        )
    made = simulate(
        chain,
        **shared.settings_of(options),
        initial_state=before.final_state if before else None,
        sample_interval=options.sample_interval if options.output else None,
    )
    assert isinstance(made, Run)  # as it was one chain
    if options.output:
        made.save(options.output)
    names = (*shared.NUMERICS, "seed", "replicate")
    measured = ("disorder_parameter", "mean_length", "energy_residual", "sum_rule_residual")
    result = shared.of_chain(chain)
    result |= {name: getattr(made, name) for name in (*names, *measured)}
    if made.tolerance is None:
        del result["tolerance"]
    shared.print_result(result | {"events": len(made.events)}, options.json)

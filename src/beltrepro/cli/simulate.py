"""`beltrepro simulate`: one run of one chain."""

import argparse
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

from beltrepro.base.checks import positive
from beltrepro.cli import options as shared
from beltrepro.model import ChainParameters

_FILE = """

The file of --output holds time (T), positions, velocities and friction (T, N) of the samples, in
the laboratory frame, and the events; groups initial_state and final_state; and the settings as
attributes. In Python: beltrepro.Run.load(FILE)."""


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


def _tell_differences(path: Path, before: ChainParameters, chain: ChainParameters) -> None:
    """Say in a line what of the chain is not as in the run that is gone on with."""
    pairs = {
        field.name: (getattr(before, field.name), getattr(chain, field.name))
        for field in fields(chain)
    }
    changed = [f"{name} {old} -> {new}" for name, (old, new) in pairs.items() if old != new]
    if changed:
        print(f"warning: not the chain of {path}: {', '.join(changed)}", file=sys.stderr)


def run(options: argparse.Namespace) -> None:
    """Simulate, print r and write the run."""
    chain = shared.chain_of(options)
    shared.check_output(options, ".h5")
    positive("sample_interval", options.sample_interval)  # also where there are no samples
    from beltrepro.simulation import Run, simulate

    before = Run.load(options.from_state) if options.from_state else None
    if before:
        _tell_differences(options.from_state, before.parameters, chain)
    made = simulate(
        chain,
        **shared.settings_of(options),
        initial_state=before.final_state if before else None,
        sample_interval=options.sample_interval if options.output else None,
    )
    assert isinstance(made, Run)  # as it was one chain
    if options.output:
        made.save(options.output)
    names = ("duration", "transient", "method", "time_step", "tolerance", "seed", "replicate")
    measured = ("disorder_parameter", "mean_length", "energy_residual", "sum_rule_residual")
    result = shared.of_chain(chain)
    result |= {name: getattr(made, name) for name in (*names, *measured)}
    if made.tolerance is None:
        del result["tolerance"]
    shared.print_result(result | {"events": len(made.events)}, options.json)

"""`beltrepro scan`: r over a grid of chains."""

import argparse
from typing import Any

from beltrepro.base.errors import needing
from beltrepro.cli import options as shared

_CHAIN = ("n_blocks", "belt_velocity", "noise", *shared.LAW)
_SETTINGS = ("duration", "transient", "method", "time_step", "tolerance", "seed", "initial_spread")
_SHOWN = ("disorder_parameter", "mean_length", "section_count", "laminar_fraction")


def add(commands: Any) -> None:
    """Add the command."""
    scan = commands.add_parser(
        "scan",
        help="measure r over a grid of chains",
        description="Simulate chains at every combination of some values and measure r, the mean "
        "length, slips and laminar phases of each. A quantity of the chain is a number, a list "
        "1,2,5 or a range START:STOP:STEP with both ends.",
        epilog="All numbers are in model units, as in `beltrepro simulate --help`. In Python: "
        "beltrepro.scan and beltrepro.Grid.",
    )
    shared.add_chain(scan, shared.whole_grid, shared.grid)
    shared.add_numerics(scan)
    option = scan.add_argument
    option("--seed", type=int, default=1, help="fixes the random numbers (1)")
    option("--replicates", type=int, default=1, help="runs at each combination (1)")
    option(
        "--initial-spread",
        type=float,
        default=0.0,
        help="standard deviation of random displacements of the blocks at the start (0); "
        "replicate 0 has none",
    )
    option("--json", action="store_true", help="print the table as JSON")
    shared.add_output(scan, "write the table to this .csv file, or all arrays to this .h5 file")
    scan.set_defaults(action=run)


def run(options: argparse.Namespace) -> int:
    """Scan a grid, and print or write the table."""
    shared.check_output(options, ".csv", ".h5")
    from beltrepro.simulation import Grid, scan

    if options.json or options.output is None or options.output.suffix.lower() == ".csv":
        with needing("a table"):  # before hours of computing
            import pandas  # noqa: F401
    grid = Grid(**{name: getattr(options, name) for name in (*_CHAIN, "replicates")})
    settings = {name: getattr(options, name) for name in _SETTINGS}
    results = scan(grid, **settings, section_values=0, progress=shared.progress_of("scan"))
    if options.output:
        results.save(options.output)
    if options.json:
        print(results.table().to_json(orient="records", indent=2, double_precision=15))
    elif options.output:
        print(f"{options.output}: {len(grid)} points")
    else:
        table = results.table()[[*results.axes, *_SHOWN]]
        print(table.to_string(index=False, float_format="{:.6g}".format))
    return 0

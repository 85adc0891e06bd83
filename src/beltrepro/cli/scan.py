"""`beltrepro scan`: r over a grid of chains."""

import argparse
from typing import Any

from beltrepro.base.errors import needing
from beltrepro.cli import options as shared

_SHOWN = ("disorder_parameter", "mean_length", "section_count", "laminar_fraction")


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "measure r over a grid of chains",
        "Simulate chains at every combination of some values and measure r, the mean length, slips "
        "and laminar phases of each. A quantity of the chain is a number, a list 1,2,5 or a range "
        "START:STOP:STEP with both ends.",
        epilog="All numbers are in model units, as in `beltrepro simulate --help`. In Python: "
        "beltrepro.scan and beltrepro.Grid.",
    )
    option = parser.add_argument
    shared.add_chain(parser, shared.whole_grid, shared.grid)
    shared.add_numerics(parser)
    option("--seed", type=int, default=1, help="fixes the random numbers (1)")
    option("--replicates", type=int, default=1, help="runs at each combination (1)")
    shared.add_spread(parser)
    option("--workers", type=int, help="cores to use; all of them if not given")
    option("--json", action="store_true", help="print the table as JSON")
    shared.add_output(parser, "write the table to this .csv file, or all arrays to this .h5 file")


def run(options: argparse.Namespace) -> None:
    """Scan a grid, and print or write the table."""
    shared.check_output(options, ".csv", ".h5")
    from beltrepro import Grid, scan

    if options.json or options.output is None or options.output.suffix.lower() == ".csv":
        with needing("a table"):  # before hours of computing
            import pandas  # noqa: F401
    grid = Grid(**{name: getattr(options, name) for name in (*shared.CHAIN, "replicates")})
    settings = {name: getattr(options, name) for name in (*shared.NUMERICS, "seed")}
    settings |= {"initial_spread": options.initial_spread, "workers": options.workers}
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

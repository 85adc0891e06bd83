"""`beltrepro plot`: the picture of a run."""

import argparse
from pathlib import Path
from typing import Any

from beltrepro.base.errors import needing
from beltrepro.cli import options as shared


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "draw a run",
        "Draw x_N(t), r as it settles, and the slips of each block, of a run that "
        "`beltrepro simulate --output` wrote. In Python: beltrepro.Run.plot.",
    )
    option = parser.add_argument
    option("run", type=Path, help="the file of the run, .h5")
    words = "write the figure, .png, .pdf or .svg; without it a window opens, or the figure is "
    words += "written beside the run as .png where there is no display"
    shared.add_output(parser, words)


def run(options: argparse.Namespace) -> None:
    """Draw the run."""
    shared.check_output(options, ".png", ".pdf", ".svg")
    from beltrepro import Run

    drawn = Run.load(options.run)
    with needing("a picture of a run"):
        from beltrepro.simulation import picture
    if options.output is None and not picture.display():
        options.output = options.run.with_suffix(".png")
        shared.check_output(options)
        print(f"no display: the figure is written to {options.output}")
    drawn.plot(options.output)

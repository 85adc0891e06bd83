"""`beltrepro track`: the white block in a video."""

import argparse
from pathlib import Path
from typing import Any

from beltrepro.cli import options as shared


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "track the white block in a video of known scale",
        "Find the white block in each frame of a video from straight above the belt. The scale and "
        "the zero of the video must be known (docs/experiment.md).",
    )
    option = parser.add_argument
    option("video", type=Path, help="the video, in any format that FFmpeg reads")
    shared.add_output(parser, "write time_s, x_m to this CSV file", required=True)
    option("--scale", type=float, metavar="METRES_PER_PIXEL", help="scale of the picture")
    option("--zero", type=float, metavar="PIXEL", help="column of the point where x is 0")
    option(
        "--support", default="left", help="side where the chain is held: left (as usual) or right"
    )
    option("--json", action="store_true", help=shared.JSON)


def run(options: argparse.Namespace) -> None:
    """Track, and write the table."""
    shared.check_output(options, ".csv")
    from beltrepro.replication.camera.track import track

    settings = {name: getattr(options, name) for name in ("scale", "zero", "support")}
    tracked = track(options.video, **settings)
    tracked.save(options.output)
    result = {
        "output": str(options.output),
        "frames": len(tracked.time_s),
        "seconds": float(tracked.time_s[-1] - tracked.time_s[0]),
        "angle": tracked.angle,
        "lost_s": tracked.lost_s.tolist(),
    }
    if not options.json:
        stretches = ", ".join(f"{begin:.2f} to {end:.2f}" for begin, end in result["lost_s"])
        result["lost_s"] = stretches or "none"
    shared.print_result(result, options.json)

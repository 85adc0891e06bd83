"""`beltrepro track`: the white block in a video."""

import argparse
from dataclasses import fields
from pathlib import Path
from typing import Any

from beltrepro.cli import options as shared
from beltrepro.replication.camera.scene import TAPE_HEIGHT_ERROR, Scene

_SIZES = ("block_length", "block_width", "mark_spacing")


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "track the white block in a video",
        "Find the white block in each frame of a video from above the belt. Belt and scale are "
        "found by a tape measure beside the chain (docs/experiment.md). A picture beside the table "
        "(.check.png) shows the marks that were read, the zero and the block: look at it.",
    )
    option = parser.add_argument
    option("video", type=Path, help="the video, in any format that FFmpeg reads")
    shared.add_output(parser, "write time_s, x_m, error_m to this CSV file", required=True)
    words = "scale, if there is no tape"
    option("--scale", type=float, metavar="METRES_PER_PIXEL", help=words)
    option("--first-mark", type=float, help="what the tape reads at the first mark seen, m")
    option(
        "--tape-height-error",
        type=float,
        default=TAPE_HEIGHT_ERROR,
        help="how far the tape's face may lie above or below the tops of the blocks: one standard "
        "error, m",
    )
    option("--support", default="auto", help="side where the chain is held: left, right or auto")
    for size in fields(Scene):
        if size.name in _SIZES:
            shared.add_field(parser, size, size.metadata["words"])
    option("--json", action="store_true", help=shared.JSON)


def run(options: argparse.Namespace) -> None:
    """Track, and write the table and the picture beside it."""
    shared.check_output(options, ".csv")
    from beltrepro.replication.camera import check_picture
    from beltrepro.replication.camera.tracking import track

    picture = options.output.with_suffix(check_picture.SUFFIX)
    shared.check_output(argparse.Namespace(output=picture, force=options.force))

    tracked = track(
        options.video,
        metres_per_pixel=options.scale,
        first_mark=options.first_mark,
        support=options.support,
        tape_height_error=options.tape_height_error,
        scene=Scene(**{name: getattr(options, name) for name in _SIZES}),
    )
    tracked.save(options.output)
    survey = tracked.survey
    assert survey is not None  # as it was tracked
    check_picture.write(survey, picture)
    zero = survey.in_picture(survey.zero, survey.measure.line if survey.measure else 0.0)
    result = {
        "output": str(options.output),
        "check_picture": str(picture),
        "frames": len(tracked.time_s),
        "seconds": float(tracked.time_s[-1] - tracked.time_s[0]),
        "metres_per_pixel": tracked.metres_per_pixel,
        "angle": tracked.angle,
        "tilt": survey.ruler.tilt,
        "misfit_of_marks_m": survey.ruler.misfit * survey.ruler.spacing_m,
        "zero_at_pixel": [round(place, 1) for place in zero],
        "error_m": float((tracked.error_m**2).mean() ** 0.5),
        "lost_s": tracked.lost_s.tolist(),
    }
    if not options.json:
        stretches = ", ".join(f"{begin:.2f} to {end:.2f}" for begin, end in result["lost_s"])
        result["lost_s"] = stretches or "none"
        result["zero_at_pixel"] = "({}, {}); x counts from there".format(*result["zero_at_pixel"])
    shared.print_result(result, options.json)

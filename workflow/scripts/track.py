"""Track the last block in a film."""

from pathlib import Path
from typing import TYPE_CHECKING

import cv2

from beltrepro.base.atomic import replacing
from beltrepro.replication.camera.tracking import track
from beltrepro.replication.plan import described, scripting

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

TITLE = "Place of the white block in each frame of a film."
COLUMNS = {
    "time_s": "instant of the frame, seconds from the beginning of the film",
    "x_m": "middle of the white block along the belt, metres from the zero of the tape",
    "error_m": "one standard error of x_m, of which some is common to all frames",
}


def place(video: Path, expected: dict, output: Path) -> None:
    """Track a film, and write the places and what they are.

    expected : what the film must say of itself. Where the places come from, the film says.
    """
    described.check(video, expected)
    origin = described.origin_of(video)
    with replacing(output) as unfinished:
        # the virtual camera's tape is as high as the blocks
        track(video, tape_height_error=0.0).save(unfinished)
    columns = [
        {"name": name, "datatype": "number", "dc:description": text}
        for name, text in COLUMNS.items()
    ]
    described.describe(
        output,
        title=TITLE,
        **origin,
        units="SI",
        dialect={"commentPrefix": "#"},
        tableSchema={"columns": columns},
    )


def main(job):
    cv2.setNumThreads(job.threads)  # by itself it takes all cores
    place(Path(job.input[0]), job.params.expected, Path(job.output.table))


if __name__ == "__main__":
    scripting.run(main, snakemake)

"""Track the last block in a film."""

from pathlib import Path
from typing import TYPE_CHECKING

import cv2

from beltrepro.base.atomic import replacing
from beltrepro.replication.camera.tracking import track
from beltrepro.replication.plan import scripting
from beltrepro.replication.plan.described import describe, origin_of

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

TITLE = "Place of the white block in each frame of a film."
COLUMNS = {
    "time_s": "instant of the frame, seconds from the beginning of the film",
    "x_m": "middle of the white block along the belt, metres from the zero of the tape",
    "error_m": "one standard error of x_m, of which some is common to all frames",
}


def place(video: Path, output: Path) -> None:
    """Track a film, and write the places and what they are; where they come from the film says."""
    origin = origin_of(video)
    with replacing(output) as unfinished:
        track(video).save(unfinished)
    columns = [
        {"name": name, "datatype": "number", "dc:description": text}
        for name, text in COLUMNS.items()
    ]
    describe(
        output,
        title=TITLE,
        **origin,
        units="SI",
        dialect={"commentPrefix": "#"},
        tableSchema={"columns": columns},
    )


def main(job):
    cv2.setNumThreads(job.threads)  # by itself it takes all cores
    place(Path(job.input[0]), Path(job.output.table))


if __name__ == "__main__":
    scripting.run(main, snakemake)

"""Film a dataset with the virtual camera."""

from pathlib import Path
from typing import TYPE_CHECKING

import cv2

from beltrepro.base.progress import Progress
from beltrepro.model.units import to_si
from beltrepro.replication.camera.camera import Movement, film
from beltrepro.replication.camera.scene import Camera
from beltrepro.replication.plan import inputs, scripting
from beltrepro.replication.plan.described import describe
from beltrepro.replication.plan.filming import FILM, NEEDED

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

TITLE = "Film of a simulated chain, by a virtual camera."


def take(paths: dict, expected: dict, spec: dict, output: Path) -> None:
    """Film the one dataset in `paths`; spec : what `PlannedFilm.spec` says."""
    data = inputs.load(paths, expected)
    (series,) = data.values()
    samples = {name: series.arrays[name][: spec["frames"]] for name in ("time", *NEEDED)}
    movement = Movement(
        to_si(samples["time"], "time"),
        to_si(samples["positions"], "length"),
        to_si(samples["velocities"], "velocity"),
    )
    progress = Progress(f"{spec['film']}: {len(movement.time_s)} frames")
    film(movement, output, camera=Camera(**spec["camera"]), progress=progress)
    sources = expected | {f"{spec['film']}{FILM}": spec}
    describe(output, title=TITLE, sources=sources, lineage=inputs.lineage(paths, data), units="SI")


def main(job):
    cv2.setNumThreads(job.threads)  # by itself it takes all cores
    spec, expected = job.params.spec, job.params.expected
    take(dict(job.input.items()), expected, spec, Path(job.output.video))


if __name__ == "__main__":
    scripting.run(main, snakemake)

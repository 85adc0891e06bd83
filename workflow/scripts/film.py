"""Film a dataset with the virtual camera, and track the last block in the film."""

from pathlib import Path

import cv2

from beltrepro.base.atomic import replacing
from beltrepro.base.progress import Progress
from beltrepro.model.units import to_si
from beltrepro.replication.camera.camera import Framing, Movement, film
from beltrepro.replication.camera.scene import Camera, Scene
from beltrepro.replication.camera.track import track
from beltrepro.replication.plan import inputs, scripting
from beltrepro.replication.plan.described import describe
from beltrepro.replication.plan.kinds import FILM, FILMED

COLUMNS = {
    "time_s": "instant of the frame, seconds from the beginning of the film",
    "x_m": "middle of the white block along the belt, metres from the fixed point",
}


def take(paths: dict, expected: dict, spec: dict, video: Path, table: Path) -> None:
    """Film the one dataset in `paths`, and track; spec : as in `Plan.films`."""
    data = inputs.load(paths, expected)
    (series,) = data.values()
    samples = {name: series.arrays[name] for name in ("time", *FILMED)}
    movement = Movement(
        to_si(samples["time"], "time"),
        to_si(samples["positions"], "length"),
        to_si(samples["velocities"], "velocity"),
    )
    camera = Camera(**spec["camera"])
    progress = Progress(f"{spec['film']}: {len(movement.time_s)} frames")
    film(movement, video, camera=camera, progress=progress)
    view = Framing.of(movement, Scene(), camera)
    with replacing(table) as unfinished:
        track(video, scale=view.metres_per_pixel, zero=view.zero[0]).save(unfinished)
    origin = {
        "sources": expected | {f"{spec['film']}{FILM}": spec},
        "lineage": inputs.lineage(paths, data),
        "units": "SI",
    }
    describe(video, title="Film of a simulated chain, by a virtual camera.", **origin)
    columns = [
        {"name": name, "datatype": "number", "dc:description": text}
        for name, text in COLUMNS.items()
    ]
    describe(
        table,
        title="Place of the white block in each frame of a film.",
        **origin,
        dialect={"commentPrefix": "#"},
        tableSchema={"columns": columns},
    )


def main(job):
    cv2.setNumThreads(job.threads)  # by itself it takes all cores
    video, table = Path(job.output.video), Path(job.output.table)
    take(dict(job.input.items()), job.params.expected, job.params.spec, video, table)


if __name__ == "__main__":
    scripting.run(main, snakemake)

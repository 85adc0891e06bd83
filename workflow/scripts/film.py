"""Film a dataset with the virtual camera, and track the last block in the film."""

import cv2

from beltrepro.base import seal
from beltrepro.base.atomic import replacing
from beltrepro.base.progress import Progress
from beltrepro.model.units import to_si
from beltrepro.replication.camera.camera import Framing, Movement, film
from beltrepro.replication.camera.scene import Camera, Scene
from beltrepro.replication.camera.track import track
from beltrepro.replication.plan import io, scripting

TITLE = "Place of the white block in each frame of a film."
COLUMNS = {
    "time_s": "instant of the frame, seconds from the beginning of the film",
    "x_m": "middle of the white block along the belt, metres from the fixed point",
}


def main(job):
    cv2.setNumThreads(job.threads)  # by itself it takes all cores
    data, sources = io.load(dict(job.input.items()))
    (series,) = data.values()
    movement = Movement(
        to_si(series.arrays["time"], "time"),
        to_si(series.arrays["positions"], "length"),
        to_si(series.arrays["velocities"], "velocity"),
    )
    spec = job.params.spec
    camera = Camera(**spec["camera"])
    view = Framing.of(movement, Scene(), camera)
    progress = Progress(f"{spec['film']}: {len(movement.time_s)} frames")
    about = io.about(TITLE, COLUMNS, sources) | {"units": "SI"} | spec
    with replacing(job.output.video) as video, replacing(job.output.table) as table:
        film(movement, video, camera=camera, progress=progress)
        tracked = track(video, scale=view.metres_per_pixel, zero=view.zero[0])
        tracked.save(table, **about)
        seal.put(video)
        seal.put(table)


if __name__ == "__main__":
    scripting.run(main, snakemake)

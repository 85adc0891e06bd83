"""A virtual experiment, and the measurement of a real one: camera, video, tracking (Sec. II).

`film` turns a run into a video as a camera above a treadmill would take it, and `track` finds the
white block in such a video, or in one of your own treadmill (docs/experiment.md). Lengths are in
metres and times in seconds.
"""

from beltrepro.replication.camera.camera import Camera, Movement, film
from beltrepro.replication.camera.scene import Scene
from beltrepro.replication.camera.tracking import Track, track

__all__ = ["Camera", "Movement", "Scene", "Track", "film", "track"]

"""The films of a preset: how the virtual camera is set, and what it films.

A film is made of a dataset and is none itself: it is a video (`replication.camera`), and what is
tracked in it is told the scale and the zero of the film, and nothing of the dataset.
"""

from dataclasses import dataclass, field
from typing import get_type_hints

from beltrepro.replication.camera.scene import Camera, camera_settings
from beltrepro.replication.plan.points import Described

FILM, TRACK = "_film", "_track"
"""Ends of the names by which tables, figures and claims ask for a film and for what is tracked."""

NEEDED = ("positions", "velocities")  # samples without which nothing can be filmed


CAMERA = {
    name: Described(
        name,
        get_type_hints(Camera)[name],
        setting.default,
        setting.metadata["limits"],
        description=setting.metadata["words"],
    )
    for name, setting in camera_settings().items()
}
"""Settings of the camera by name; its seed is that of the configuration."""


@dataclass(frozen=True)
class PlannedFilm:
    """A film before it is made."""

    name: str  # unique over all films
    dataset: str  # name of the series of one point that is filmed
    camera: dict = field(hash=False)  # settings of `camera.Camera`

    def spec(self) -> dict:
        """What the job of the film needs, as plain values."""
        return {"film": self.name, "camera": self.camera}

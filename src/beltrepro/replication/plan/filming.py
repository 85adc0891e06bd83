"""The films of a preset: how the virtual camera is set, and what it films.

A film is made of a dataset and is none itself: it is a video (`replication.camera`), and what is
tracked in it knows nothing of the dataset.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any, get_type_hints

from pydantic import Field, WrapValidator

from beltrepro.replication.camera.scene import Camera, camera_settings
from beltrepro.replication.plan.points import Described, Number, Whole

FILM, TRACK = "_film", "_track"
"""Ends of the names by which tables, figures and claims ask for a film and for what is tracked."""

NEEDED = ("positions", "velocities")  # samples without which nothing can be filmed


def _unchanged(value: object, check: Callable[[object], object]) -> object:
    """A film is known by a digest of its settings as text: 0 must not become 0.0."""
    check(value)
    return value


_TYPES: dict[Any, Any] = {float: Number, int: Whole, float | None: Number | None}
CAMERA = {
    name: Described(
        name=name,
        type=Annotated[
            _TYPES[get_type_hints(Camera)[name]],
            Field(**setting.metadata["limits"]),
            WrapValidator(_unchanged),
        ],
        symbol="",
        unit="1",
        description=setting.metadata["words"],
        default=setting.default,
    )
    for name, setting in camera_settings().items()
}
"""Settings of the camera by name; its seed is that of the configuration."""


@dataclass(frozen=True)
class PlannedFilm:
    """A film before it is made."""

    name: str  # unique over all films
    dataset: str  # name of the series of one point that is filmed
    frames: int | None  # how many instants of the series, from its first one on; None for all
    camera: dict = field(hash=False)  # settings of `camera.Camera`

    def spec(self) -> dict:
        """What the job of the film needs, as plain values."""
        return {"film": self.name, "frames": self.frames, "camera": self.camera}

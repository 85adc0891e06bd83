"""The films of a preset: how the virtual camera is set, and what it films.

A film is made of a dataset and is none itself: it is a video (`replication.camera`), and what is
tracked in it knows nothing of the dataset. Settings of the camera are those of `camera.Camera`;
here they have words and ranges for config.yaml.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated

from pydantic import Field, WrapValidator

from beltrepro.replication.plan import points
from beltrepro.replication.plan.points import About, Whole, described

FILM, TRACK = "_film", "_track"
"""Ends of the names by which tables, figures and claims ask for a film and for what is tracked."""

NEEDED = ("positions", "velocities")  # samples without which nothing can be filmed


def _unchanged(value: object, check: Callable[[object], object]) -> object:
    """A film is known by a digest of its settings as text: 0 must not become 0.0."""
    check(value)
    return value


Number = Annotated[points.Number, WrapValidator(_unchanged)]
_SIZE = Field(ge=16, le=8192, multiple_of=2)
_SHARE = Field(ge=0, le=1)


class CameraSettings:
    """How the camera is set; its seed is that of the configuration."""

    frames_per_second: Annotated[
        Number, About(" | 1 | Frames a second (Sec. II: 24).", 24.0), Field(gt=0)
    ]
    metres_per_pixel: Annotated[
        Number | None,
        About(
            " | 1 | Scale of the picture; null for the scale at which the whole film just fits.",
            None,
        ),
        Field(gt=0),
    ]
    width: Annotated[Whole, About(" | 1 | Of the picture, pixels.", 640), _SIZE]
    height: Annotated[Whole, About(" | 1 | Of the picture, pixels.", 96), _SIZE]
    exposure: Annotated[
        Number,
        About(
            " | 1 | Seconds for which the shutter is open, at most the time between frames.", 0.01
        ),
        Field(ge=0),
    ]
    blur: Annotated[
        Number,
        About(" | 1 | Standard deviation of the image of a point, pixels.", 0.7),
        Field(ge=0, le=20),
    ]
    sensor_noise: Annotated[
        Number,
        About(" | 1 | Standard deviation of the noise of a pixel, of 255 levels.", 2.0),
        Field(ge=0, le=255),
    ]
    light_unevenness: Annotated[
        Number,
        About(
            " | 1 | Share by which the light at one end of the picture exceeds that in its middle.",
            0.1,
        ),
        _SHARE,
    ]
    light_drift: Annotated[
        Number,
        About(" | 1 | Share by which the light waxes and wanes in a minute.", 0.05),
        _SHARE,
    ]
    angle: Annotated[
        Number,
        About(" | 1 | By which the belt is turned in the picture, degrees, clockwise.", 0.0),
        Field(ge=-45, le=45),
    ]
    dropped: Annotated[
        Number, About(" | 1 | Share of the frames that are lost.", 0.0), Field(ge=0, le=0.9)
    ]
    compression: Annotated[
        Whole,
        About(" | 1 | Constant rate factor of H.264, from 0 (lossless) to 51 (coarse).", 18),
        Field(ge=0, le=51),
    ]


CAMERA = described(CameraSettings)


@dataclass(frozen=True)
class PlannedFilm:
    """A film before it is made."""

    name: str  # unique over all films
    dataset: str  # name of the series of one point that is filmed
    frames: int | None  # how many instants of the series, from its first one on; None for all
    camera: dict = field(hash=False)  # settings of `camera.Camera`

    def told(self) -> dict:
        """What the job of the film needs, as plain values."""
        return {"film": self.name, "frames": self.frames, "camera": self.camera}

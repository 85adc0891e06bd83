"""The films of a preset: how the virtual camera is set, and what it films.

A film is made of a dataset and is none itself: it is a video (`replication.camera`), and what is
tracked in it is told the scale and the zero of the film, and nothing of the dataset.
"""

from dataclasses import dataclass, field

FILM, TRACK = "_film", "_track"
"""Ends of the names by which tables, figures and claims ask for a film and for what is tracked."""

NEEDED = ("positions", "velocities")  # samples without which nothing can be filmed


@dataclass(frozen=True)
class PlannedFilm:
    """A film before it is made."""

    name: str  # unique over all films
    dataset: str  # name of the series of one point that is filmed
    camera: dict = field(hash=False)  # settings of `camera.Camera`

    def spec(self) -> dict:
        """What the job of the film needs, as plain values."""
        return {"film": self.name, "camera": self.camera}

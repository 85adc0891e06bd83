"""The films of a preset: which datasets the virtual camera films, and how it is set.

A film is made of a dataset and is none itself: it is a video (`replication.camera`), and what is
tracked in it knows nothing of the dataset. Settings of the camera are those of
`experiment.Camera`; here they have words and ranges for config.yaml.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from beltrepro.model.units import TIME_S
from beltrepro.replication.plan.checking import complain
from beltrepro.replication.plan.kinds import Setting

FILM, TRACK = "_film", "_track"
"""Ends of the names by which tables, figures and claims ask for a film and for what is tracked."""

NEEDED = ("positions", "velocities")  # samples without which nothing can be filmed
_TOLERANCE = 1e-3  # of the time between frames, as in `experiment.film`
_SIZE = {"type": "integer", "minimum": 16, "maximum": 8192, "multipleOf": 2}
_SHARE = {"type": "number", "minimum": 0, "maximum": 1}

_CAMERA = (
    Setting(
        "frames_per_second",
        "",
        "1",
        "Frames a second (Sec. II: 24).",
        {"type": "number", "exclusiveMinimum": 0},
        24.0,
    ),
    Setting(
        "metres_per_pixel",
        "",
        "1",
        "Scale of the picture; null for the scale at which the whole film just fits.",
        {"type": ["number", "null"], "exclusiveMinimum": 0},
        None,
    ),
    Setting("width", "", "1", "Of the picture, pixels.", _SIZE, 640),
    Setting("height", "", "1", "Of the picture, pixels.", _SIZE, 96),
    Setting(
        "exposure",
        "",
        "1",
        "Seconds for which the shutter is open, at most the time between frames.",
        {"type": "number", "minimum": 0},
        0.01,
    ),
    Setting(
        "blur",
        "",
        "1",
        "Standard deviation of the image of a point, pixels.",
        {"type": "number", "minimum": 0, "maximum": 20},
        0.7,
    ),
    Setting(
        "sensor_noise",
        "",
        "1",
        "Standard deviation of the noise of a pixel, of 255 levels.",
        {"type": "number", "minimum": 0, "maximum": 255},
        2.0,
    ),
    Setting(
        "light_unevenness",
        "",
        "1",
        "Share by which the light at one end of the picture exceeds that in its middle.",
        _SHARE,
        0.1,
    ),
    Setting(
        "light_drift",
        "",
        "1",
        "Share by which the light waxes and wanes in a minute.",
        _SHARE,
        0.05,
    ),
    Setting(
        "angle",
        "",
        "1",
        "By which the belt is turned in the picture, degrees, clockwise.",
        {"type": "number", "minimum": -45, "maximum": 45},
        0.0,
    ),
    Setting(
        "dropped",
        "",
        "1",
        "Share of the frames that are lost.",
        {"type": "number", "minimum": 0, "maximum": 0.9},
        0.0,
    ),
    Setting(
        "compression",
        "",
        "1",
        "Constant rate factor of H.264, from 0 (lossless) to 51 (coarse).",
        {"type": "integer", "minimum": 0, "maximum": 51},
        18,
    ),
)
CAMERA = {each.name: each for each in _CAMERA}
"""Settings of the camera by name; its seed is that of the configuration."""


@dataclass(frozen=True)
class PlannedFilm:
    """A film before it is made."""

    name: str  # unique over all films
    dataset: str  # name of the series of one point that is filmed
    frames: int | None  # how many instants of the series, from its first one on; None for all
    camera: dict = field(hash=False)  # settings of `experiment.Camera`

    def told(self) -> dict:
        """What the job of the film needs, as plain values."""
        return {"film": self.name, "frames": self.frames, "camera": self.camera}


def planned_films(config: dict, datasets: Mapping, preset: str) -> dict[str, PlannedFilm]:
    """The films of a preset."""
    usual = {each.name: each.default for each in _CAMERA} | config.get("camera", {})
    _check_names(datasets)
    found = {}
    for name, entry in config.get("films", {}).items():
        camera = usual | entry.get("camera", {}) | {"seed": config["seed"]}
        _check_camera(name, camera)
        _check_dataset(name, entry["of"], datasets, camera["frames_per_second"], preset)
        seconds = entry.get("seconds")
        frames = None if seconds is None else round(seconds * camera["frames_per_second"])
        found[name] = PlannedFilm(name, entry["of"], frames, camera)
    return found


def _check_names(datasets: Mapping) -> None:
    for name in datasets:
        if name.endswith((FILM, TRACK)):
            raise complain(f"datasets.{name}: only films have names that end in {FILM} or {TRACK}")


def _check_camera(name: str, camera: dict) -> None:
    longest = 1 / camera["frames_per_second"]
    if camera["exposure"] > longest:
        text = f"exposure = {camera['exposure']:g}: must be at most {longest:.4g}, until the next"
        raise complain(f"films.{name}: {text} frame")


def _check_dataset(name: str, of: str, datasets: Mapping, rate: float, preset: str) -> None:
    """Refuse what is no series of one point, or is not sampled at the instants of the frames."""
    where = f"films.{name}.of = {of!r}"
    if of not in datasets:
        raise complain(f"{where}: preset {preset} has no such dataset", of, datasets)
    dataset = datasets[of]
    if dataset.kind.name != "series" or len(dataset.points) != 1:
        raise complain(f"{where}: must be a series of one point")
    missing = [each for each in NEEDED if each not in dataset.settings["samples"]]
    if missing:
        raise complain(f"{where}: its samples lack {', '.join(missing)}")
    interval, needed = dataset.settings["sample_interval"], 1 / rate / TIME_S
    if abs(interval / needed - 1) > _TOLERANCE:
        text = f"its sample_interval is {interval:g}, {rate:g} frames a second need {needed:.7g}"
        raise complain(f"{where}: {text}")

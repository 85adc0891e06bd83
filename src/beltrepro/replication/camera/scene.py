"""What lies on the belt, and how the camera above it is set, in SI (Sec. II)."""

from dataclasses import dataclass, field, fields
from typing import Any

from beltrepro.base import checks
from beltrepro.base.errors import InputError


def _setting(default: Any, words: str, **limits: float) -> Any:
    """A field with its words and limits, of which command and configuration make theirs."""
    return field(default=default, metadata={"words": words, "limits": limits})


def _size(default: float, words: str = "") -> Any:
    return _setting(default, words, gt=0)


def _light(default: float) -> Any:
    return _setting(default, "brightness", ge=0, le=255)


@dataclass(frozen=True)
class Scene:
    """Sizes of the things on the belt, in metres, and how bright they are.

    Brightness goes from 0 (black) to 255 (white). The support is at x = 0, and the chain extends to
    the right. The tape measure lies beside the chain and has its zero at the support.
    """

    block_length: float = _size(0.04, "of a block, along the belt, m")  # Sec. II: 4 cm and 8 cm
    block_width: float = _size(0.08, "of a block, across the belt, m")
    spring_width: float = _size(0.012)  # diameter of the springs
    coils: int = _size(8)  # turns of a spring
    tape_gap: float = _size(0.015)  # distance of the tape measure from the blocks, and its width
    tape_width: float = _size(0.02)
    mark_spacing: float = _size(0.01, "of the marks of the tape, m")  # every tenth is longer
    mark_width: float = _size(0.002)  # of a mark, along the belt, and across it
    mark_length: float = _size(0.008)
    long_mark_length: float = _size(0.014)
    belt: float = _light(28.0)
    block: float = _light(10.0)
    white_block: float = _light(235.0)
    spring: float = _light(90.0)
    support: float = _light(70.0)
    tape: float = _light(190.0)
    mark: float = _light(20.0)

    def __post_init__(self) -> None:
        _check(self)

    @property
    def width(self) -> float:
        """Of all there is, across the belt, from the edge of the blocks to that of the tape."""
        return self.block_width + self.tape_gap + self.tape_width


def lengths_of_blocks(n_blocks: int, block_length: float) -> float:
    """Lengths of blocks from the support to the middle of the last one.

    A tape along the chain reads them with x_N. In the model blocks are points, and x_N is of
    springs only.
    """
    return (n_blocks - 0.5) * block_length


@dataclass(frozen=True)
class Camera:
    """A camera that looks straight down on the belt."""

    frames_per_second: float = _setting(24.0, "Frames a second (Sec. II: 24).", gt=0)
    metres_per_pixel: float | None = _setting(
        None, "Scale of the picture; null for the scale at which the whole film just fits.", gt=0
    )
    width: int = _setting(640, "Of the picture, pixels.", ge=16, le=8192, multiple_of=2)
    height: int = _setting(96, "Of the picture, pixels.", ge=16, le=8192, multiple_of=2)
    # the instant of a frame is the middle of the exposure
    exposure: float = _setting(
        0.01, "Seconds for which the shutter is open, at most the time between frames.", ge=0
    )
    blur: float = _setting(0.7, "Standard deviation of the image of a point, pixels.", ge=0, le=20)
    sensor_noise: float = _setting(
        2.0, "Standard deviation of the noise of a pixel, of 255 levels.", ge=0, le=255
    )
    light_unevenness: float = _setting(
        0.1,
        "Share by which the light at one end of the picture exceeds that in its middle.",
        ge=0,
        le=1,
    )
    # the direction of the light turns meanwhile
    light_drift: float = _setting(
        0.05, "Share by which the light waxes and wanes in a minute.", ge=0, le=1
    )
    angle: float = _setting(
        0.0, "By which the belt is turned in the picture, degrees, clockwise.", ge=-45, le=45
    )
    dropped: float = _setting(0.0, "Share of the frames that are lost.", ge=0, le=0.9)
    compression: int = _setting(
        18, "Constant rate factor of H.264, from 0 (lossless) to 51 (coarse).", ge=0, le=51
    )
    seed: int = 1  # fixes the noise and which frames are lost

    def __post_init__(self) -> None:
        _check(self)
        checks.within("exposure", self.exposure, ge=0, le=1 / self.frames_per_second)
        checks.key("seed", self.seed)


def camera_settings() -> dict[str, Any]:
    """The fields of a camera that a user sets, by name; films take their seed from elsewhere."""
    return {setting.name: setting for setting in fields(Camera) if setting.name != "seed"}


def _check(settings: Any) -> None:
    """Refuse values beyond the limits of their fields."""
    for setting in fields(settings):
        name, value = setting.name, getattr(settings, setting.name)
        limits = setting.metadata.get("limits")
        if limits is None or (value is None and setting.default is None):
            continue
        if "le" in limits and isinstance(setting.default, int):
            checks.whole_number(name, value)
        if "le" in limits:
            checks.within(name, value, ge=limits["ge"], le=limits["le"])
        else:
            (checks.positive if "gt" in limits else checks.not_negative)(name, value)
        if "multiple_of" in limits and value % limits["multiple_of"]:
            raise InputError(f"{name} = {value}: must be an even number")

"""What lies on the belt, and how the camera above it is set, in SI (Sec. II)."""

from dataclasses import dataclass, field, fields
from typing import Any

from beltrepro.base import checks
from beltrepro.base.errors import InputError


@dataclass(frozen=True)
class Scene:
    """Sizes of the things on the belt, in metres, and how bright they are.

    Brightness goes from 0 (black) to 255 (white). The support is at x = 0, and the chain extends to
    the right. The tape measure lies beside the chain and has its zero at the support.
    """

    block_length: float = 0.04  # along the belt; Sec. II: 4 cm and 8 cm
    block_width: float = 0.08
    spring_width: float = 0.012
    coils: int = 8  # turns of a spring
    tape_gap: float = 0.015  # between the blocks and the tape
    tape_width: float = 0.02
    mark_spacing: float = 0.01  # every tenth mark is longer
    mark_width: float = 0.002  # along the belt; lengths are across it
    mark_length: float = 0.008
    long_mark_length: float = 0.014
    belt: float = 28.0
    block: float = 10.0
    white_block: float = 235.0
    spring: float = 90.0
    support: float = 70.0
    tape: float = 190.0
    mark: float = 20.0

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


def _setting(default: Any, words: str, **limits: float) -> Any:
    """A field with its words and limits, of which command and configuration make theirs."""
    return field(default=default, metadata={"words": words, "limits": limits})


@dataclass(frozen=True)
class Camera:
    """A camera that looks straight down on the belt."""

    frames_per_second: float = _setting(24.0, "Frames a second (Sec. II: 24).", gt=0)
    metres_per_pixel: float | None = _setting(
        None, "Scale of the picture; null for the scale at which the whole film just fits.", gt=0
    )
    width: int = _setting(640, "Of the picture, pixels.", ge=16, le=8192)
    height: int = _setting(96, "Of the picture, pixels.", ge=16, le=8192)
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
        for name, setting in camera_settings().items():
            value = getattr(self, name)
            if isinstance(setting.default, int):
                checks.whole_number(name, value)
            if value is not None or setting.default is not None:
                checks.within(name, value, **setting.metadata["limits"])
        for name in ("width", "height"):  # colours stand at every second pixel of a video
            if getattr(self, name) % 2:
                raise InputError(f"{name} = {getattr(self, name)}: must be an even number")
        checks.within("exposure", self.exposure, ge=0, le=1 / self.frames_per_second)
        checks.key("seed", self.seed)


def camera_settings() -> dict[str, Any]:
    """The fields of a camera that a user sets, by name; films take their seed from elsewhere."""
    return {setting.name: setting for setting in fields(Camera) if setting.name != "seed"}

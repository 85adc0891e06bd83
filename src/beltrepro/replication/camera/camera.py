"""A virtual camera above the belt: what it would take of a run, frame by frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError
from beltrepro.model.units import LENGTH_M, TIME_S, VELOCITY_M_S
from beltrepro.replication.camera.scene import Camera, Scene
from beltrepro.replication.camera.video import Frame, write_video

if TYPE_CHECKING:
    from beltrepro.simulation.run import Run

# Seen beyond the support and beyond the farthest place of the last block, in metres.
MARGIN = 0.03
_NOISE_PICTURES = 4
_TOGETHER = 64  # frames whose edges are drawn in one go
_DRIFT_PERIOD = 60.0  # seconds in which the light comes back to where it was


@dataclass(frozen=True, eq=False)
class Movement:
    """Where the blocks are at the instants of the frames, in SI."""

    time_s: np.ndarray  # instants
    x_m: np.ndarray  # positions of the blocks, from the support
    v_m_s: np.ndarray  # their velocities; within an exposure they count as constant

    @classmethod
    def of(cls, run: Run) -> Movement:
        """The movement that the samples of a run show."""
        if not hasattr(run, "positions"):
            raise InputError(f"motion = {shown(run)}: a Run or a Movement is needed")
        if not len(run.time):
            raise InputError("the run has no samples to film: simulate with a sample_interval")
        return cls(run.time * TIME_S, run.positions * LENGTH_M, run.velocities * VELOCITY_M_S)


def film(
    motion: Run | Movement,
    path: str | Path,
    *,
    scene: Scene | None = None,
    camera: Camera | None = None,
    progress: Callable[[float], None] | None = None,
) -> int:
    """Film a run: each sample becomes a frame, taken at its instant. Returns how many are written.

    For a film of 24 frames a second simulate with `sample_interval=1 / 24 / TIME_S`; method "event"
    is exact at any interval.
    """
    camera = camera or Camera()
    frames = pictures(motion, scene=scene, camera=camera, progress=progress)
    rate, compression = camera.frames_per_second, camera.compression
    return write_video(path, frames, frames_per_second=rate, compression=compression)


def pictures(
    motion: Run | Movement,
    *,
    scene: Scene | None = None,
    camera: Camera | None = None,
    progress: Callable[[float], None] | None = None,
) -> Iterator[Frame]:
    """The frames of a film, one by one."""
    scene, camera = scene or Scene(), camera or Camera()
    movement = motion if isinstance(motion, Movement) else Movement.of(motion)
    _check_instants(movement.time_s, camera.frames_per_second)
    view = Framing.of(movement, scene, camera)
    drawing, shutter = _Drawing(scene, view, camera.blur), _Shutter(camera, view)
    half, count = movement.v_m_s * camera.exposure / 2, len(movement.time_s)
    lights = drawing.frames(movement.x_m - half, movement.x_m + half)
    for index, light in enumerate(lights):
        time = float(movement.time_s[index] - movement.time_s[0])
        # The first one is kept: a video's time begins with it.
        if not (index and shutter.drops_frame()):
            yield Frame(time, shutter(light, time))
        if progress:
            progress((index + 1) / count)


@dataclass(frozen=True)
class Framing:
    """Which part of the scene the picture shows, before it is turned."""

    metres_per_pixel: float  # scale
    width: int  # of the picture, pixels
    height: int
    left: float  # place of the support along the belt, and of the upper edge of the blocks, pixels
    top: float
    zero: tuple[float, float]  # column and row of the pixel of x = 0 in the picture as it is turned

    @classmethod
    def of(cls, movement: Movement, scene: Scene, camera: Camera) -> Framing:
        """The view of a camera that is put up for a movement."""
        extent = movement.x_m.max() + scene.block_length / 2 + 2 * MARGIN
        scale = camera.metres_per_pixel
        if scale is None:
            scale = max(extent / camera.width, 1.1 * scene.width / camera.height)
        elif extent > scale * camera.width or scene.width > scale * camera.height:
            raise InputError(
                f"the chain needs {extent:.3g} m x {scene.width:.3g} m, the picture shows "
                f"{scale * camera.width:.3g} m x {scale * camera.height:.3g} m: "
                f"take a larger metres_per_pixel, width or height"
            )
        left, top = MARGIN / scale, (camera.height - scene.width / scale) / 2
        half = np.array([camera.width, camera.height]) / 2
        angle = np.radians(camera.angle)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        zero = half + turn @ ([left, top + scene.block_width / scale / 2] - half) - 0.5
        return cls(scale, camera.width, camera.height, left, top, tuple(zero.tolist()))

    def along(self, metres: Any) -> Any:
        """Places along the belt, in metres from the support, as pixels."""
        return self.left + metres / self.metres_per_pixel

    def across(self, metres: float) -> float:
        """A place across the belt, in metres from the upper edge of the blocks, as pixels."""
        return self.top + metres / self.metres_per_pixel


class _Drawing:
    """The light that reaches the picture, with exact coverage of each pixel, and the lens's blur.

    All edges lie along the belt or across it. So the picture is a sum of products of a column
    (which rows a band of the scene covers) and a row (the brightness along that band). The blur is
    that of the columns and the rows, each for itself, and it is the same in all directions: it may
    come before the picture is turned.
    """

    def __init__(self, scene: Scene, view: Framing, blur: float) -> None:
        self._scene, self._view, self._blur = scene, view, blur
        middle = scene.block_width / 2
        spring = middle - scene.spring_width / 2, middle + scene.spring_width / 2
        bands = [(0.0, scene.block_width), spring]
        rows = [band(view.across(a), view.across(b), view.height) for a, b in bands]
        self._rows = self._blurred(np.stack(rows, axis=1), (0, 1))
        self._still = self._blurred(_still_picture(scene, view), (1, 1))

    def frames(self, begin: np.ndarray, end: np.ndarray) -> Iterator[np.ndarray]:
        """Brightness (H, W) of each frame, with blocks (T, N) from `begin` to `end`, in metres."""
        for first in range(0, len(begin), _TOGETHER):
            together = slice(first, first + _TOGETHER)
            for profiles in self._profiles(begin[together], end[together]):
                light = self._rows @ profiles
                light += self._still
                yield light

    def _profiles(self, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Brightness (T, 2, W) along the lane of the blocks and along that of the springs."""
        # (2, T, N) pixels of the edges of all blocks, at the beginning and end of the exposure
        places, length = np.stack([begin, end]), self._scene.block_length
        left, right = (self._view.along(places + side * length) for side in (-0.5, 0.5))
        # Where the model's blocks, which are points, come too near, the outer one hides the inner.
        right[..., :-1] = np.minimum(right[..., :-1], left[..., 1:])
        bright = np.full(begin.shape[1], self._scene.block - self._scene.belt)
        bright[-1] = self._scene.white_block - self._scene.belt
        blocks = _changes(left, right, bright, self._view.width)
        # The springs, as so many turns each, from the support to the last block.
        number = np.arange(self._scene.coils)
        support = np.full_like(left[..., :1], self._view.left)
        begin = np.concatenate([support, right[..., :-1]], axis=-1)[..., np.newaxis]
        turn = (left[..., np.newaxis] - begin) / self._scene.coils
        shape = (*left.shape[:2], -1)
        first, last = ((begin + (number + part) * turn).reshape(shape) for part in (0.3, 0.7))
        turns = np.full(left.shape[-1] * number.size, self._scene.spring - self._scene.belt)
        springs = _changes(first, last, turns, self._view.width)
        changes = np.stack([blocks, springs], axis=1)
        rows = changes.cumsum(axis=-1).reshape(-1, self._view.width)
        return self._blurred(rows, (1, 0)).reshape(changes.shape)

    def _blurred(self, light: np.ndarray, ways: tuple[int, int]) -> np.ndarray:
        """An array, blurred along its rows (1, 0), its columns (0, 1) or both."""
        light = light.astype(np.float32)
        if not self._blur:
            return light
        size = [2 * int(np.ceil(4 * self._blur)) + 1 if way else 1 for way in ways]
        return cv2.GaussianBlur(light, size, self._blur, borderType=cv2.BORDER_REPLICATE)


def _changes(left: np.ndarray, right: np.ndarray, bright: np.ndarray, count: int) -> np.ndarray:
    """Changes from pixel to pixel of the brightness of things from `left` to `right`, (2, T, M)."""
    edges = np.concatenate([left, right], axis=-1)
    return step_changes(edges[0], edges[1], np.concatenate([bright, -bright]), count)


def _still_picture(scene: Scene, view: Framing) -> np.ndarray:
    """Belt, support and tape measure: brightness (H, W)."""
    picture = np.full((view.height, view.width), float(scene.belt))

    def across(begin: float, width: float) -> np.ndarray:
        return band(view.across(begin), view.across(begin + width), view.height)

    support = band(0, view.left, view.width)
    picture += (scene.support - scene.belt) * np.outer(across(0, scene.block_width), support)

    edge = scene.block_width + scene.tape_gap
    # The tape begins a little before its zero mark, and goes on beyond the picture.
    tape = band(view.along(-0.3 * scene.mark_spacing), view.width, view.width)
    picture += (scene.tape - scene.belt) * np.outer(across(edge, scene.tape_width), tape)

    short, long = across(edge, scene.mark_length), across(edge, scene.long_mark_length)
    count = int((view.width - view.left) * view.metres_per_pixel / scene.mark_spacing)
    for number in range(count):
        middle, half = number * scene.mark_spacing, scene.mark_width / 2
        columns = band(view.along(middle - half), view.along(middle + half), view.width)
        rows = short if number % 10 else long
        picture += (scene.mark - scene.tape) * np.outer(rows, columns)
    return picture


class _Shutter:
    """What direction, lamp, sensor and recorder make of the light."""

    def __init__(self, camera: Camera, view: Framing) -> None:
        self._camera = camera
        self._random = np.random.default_rng(camera.seed)
        middle = ((view.width - 1) / 2, (view.height - 1) / 2)
        # Each frame takes its noise from a random place of this store: to draw it anew would take
        # longer than all the rest.
        store = _NOISE_PICTURES * view.width * view.height
        self._noise = self._random.standard_normal(store, dtype=np.float32)
        self._turn = cv2.getRotationMatrix2D(middle, -camera.angle, 1.0) if camera.angle else None
        self._along = np.linspace(-1, 1, view.width, dtype=np.float32)
        self._across = np.linspace(-1, 1, view.height, dtype=np.float32)[:, np.newaxis]

    def drops_frame(self) -> bool:
        """Whether the next frame is lost."""
        return bool(self._camera.dropped) and self._random.random() < self._camera.dropped

    def __call__(self, light: np.ndarray, time: float) -> np.ndarray:
        """The recorded picture (H, W), 8 bit."""
        camera = self._camera
        if self._turn is not None:
            size = light.shape[::-1]
            light = cv2.warpAffine(light, self._turn, size, borderMode=cv2.BORDER_REPLICATE)
        if camera.light_unevenness or camera.light_drift:
            light *= self._lamp(time)
        begin = self._random.integers(self._noise.size - light.size)
        noise = self._noise[begin : begin + light.size].reshape(light.shape)
        # rounds, and cuts at black and white
        return cv2.addWeighted(light, 1.0, noise, camera.sensor_noise, 0.0, dtype=cv2.CV_8U)

    def _lamp(self, time: float) -> np.ndarray:
        """How bright it is in each pixel (H, W) at an instant, 1 on average."""
        camera = self._camera
        phase = 2 * np.pi * time / _DRIFT_PERIOD
        turned = camera.light_drift * phase
        brightness = 1 + camera.light_drift * np.sin(phase)
        slope = np.float32(brightness * camera.light_unevenness)
        along = np.float32(brightness) + slope * np.float32(np.cos(turned)) * self._along
        return along + slope * np.float32(np.sin(turned)) * self._across


def _check_instants(time: np.ndarray, frames_per_second: float) -> None:
    """Refuse samples at another distance than that of the frames."""
    gaps = np.diff(time) * frames_per_second
    if gaps.size and np.abs(gaps - 1).max() > 1e-3:
        raise InputError(
            f"the samples are {gaps.mean() / frames_per_second:.4g} s apart, the frames "
            f"{1 / frames_per_second:.4g} s: simulate with sample_interval = "
            f"{1 / frames_per_second / TIME_S:.10g}"
        )


# --- how much of each pixel lies beyond an edge, exactly, also while the edge moves ---


def band(low: float, high: float, count: int) -> np.ndarray:
    """Share (count,) of each pixel between two places; pixel j reaches from j to j + 1."""
    ends = np.arange(count + 1)
    return np.diff(np.clip(ends, low, max(low, high)))


def step_changes(begin: np.ndarray, end: np.ndarray, heights: np.ndarray, count: int) -> np.ndarray:
    """Changes from pixel to pixel of the sum of steps that move while the shutter is open.

    A step is 0 before its edge and `height` behind it. Pixel j shows its mean from j to j + 1, and
    over all places from `begin` to `end`, which the edge passes at constant velocity. The sum of
    the changes up to pixel j is the brightness there.
    """
    # Few pixels see an edge: those it passes, and one more on either side.
    first = np.floor(np.minimum(begin, end)).astype(int) - 1
    reach = int(np.ceil(np.abs(end - begin).max(initial=0.0))) + 3
    pixels = first[..., np.newaxis] + np.arange(reach)
    seen = _behind(pixels, begin[..., np.newaxis], end[..., np.newaxis])
    changes = np.diff(seen, axis=-1, prepend=0) * heights[:, np.newaxis]
    inside = pixels < count
    frames = len(begin)
    # Frame after frame in one long row of pixels.
    places = np.maximum(pixels, 0) + count * np.arange(frames)[:, np.newaxis, np.newaxis]
    summed = np.bincount(places[inside], changes[inside], minlength=frames * count)
    return summed.reshape(frames, count)


def _behind(pixel: np.ndarray, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Share of a pixel behind an edge, mean over its way."""
    # So short a way leaves digits enough in the difference.
    half = np.maximum(np.abs(end - begin) / 2, 1e-6)
    middle = pixel + 1 - (begin + end) / 2
    return (_integral(middle + half) - _integral(middle - half)) / (2 * half)


def _integral(distance: np.ndarray) -> np.ndarray:
    """Integral from minus infinity of clip(s, 0, 1) over s."""
    inside = np.minimum(np.maximum(distance, 0), 1)
    return inside * (distance - inside / 2)

"""A virtual camera above the belt: what it would take of a run, frame by frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from beltrepro.base.errors import InputError
from beltrepro.model.units import LENGTH_M, TIME_S, VELOCITY_M_S
from beltrepro.replication.camera.scene import Camera, Scene
from beltrepro.replication.camera.video import Frame, write_video

if TYPE_CHECKING:
    from beltrepro.simulation.run import Run

SCENE, CAMERA = Scene(), Camera()
_MARGIN = 0.03  # seen beyond the support and the farthest place of the last block, metres
_COARSER = 50  # scales that are tried, each by 2 %, until a turned belt fits
_NOISE_PICTURES = 4
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
        if len(run.time) < 2:
            many = f"{len(run.time)} samples to film, two are needed"
            raise InputError(f"the run has {many}: simulate longer, with a sample_interval")
        return cls(run.time * TIME_S, run.positions * LENGTH_M, run.velocities * VELOCITY_M_S)


def film(
    movement: Movement,
    path: str | Path,
    *,
    scene: Scene = SCENE,
    camera: Camera = CAMERA,
    progress: Callable[[float], None] | None = None,
) -> int:
    """Each sample becomes a frame, taken at its instant. Returns how many are written.

    For a film of 24 frames a second simulate with `sample_interval=1 / 24 / TIME_S`; method "event"
    is exact at any interval.
    """
    frames = pictures(movement, scene=scene, camera=camera, progress=progress)
    rate, compression = camera.frames_per_second, camera.compression
    return write_video(path, frames, frames_per_second=rate, compression=compression)


def pictures(
    movement: Movement,
    *,
    scene: Scene = SCENE,
    camera: Camera = CAMERA,
    progress: Callable[[float], None] | None = None,
) -> Iterator[Frame]:
    """The frames of a film, one by one."""
    times = movement.time_s - movement.time_s[0]
    gaps, between = np.diff(movement.time_s), 1 / camera.frames_per_second
    if gaps.size and np.abs(gaps / between - 1).max() > 1e-3:
        raise InputError(
            f"the samples are {gaps.mean():.4g} s apart, the frames {between:.4g} s: simulate with "
            f"sample_interval = {between / TIME_S:.10g}"
        )
    view = Framing.of(movement, scene, camera)
    light, shutter = _Light(scene, view, camera.blur), _Shutter(camera, view)
    way = np.multiply.outer([-camera.exposure / 2, camera.exposure / 2], movement.v_m_s)
    places = movement.x_m + way
    for index, time in enumerate(times.tolist()):
        # The first one is kept: a video's time begins with it.
        if not (index and shutter.drops_frame()):
            yield Frame(time, shutter(light(places[:, index]), time))
        if progress:
            progress((index + 1) / len(times))


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
        extent = movement.x_m.max() + scene.block_length / 2 + 2 * _MARGIN
        scale = camera.metres_per_pixel
        if scale is None:
            finest = max(extent / camera.width, 1.1 * scene.width / camera.height)
            scales = finest * 1.02 ** np.arange(_COARSER if camera.angle else 1)
        elif extent > scale * camera.width or scene.width > scale * camera.height:
            raise InputError(
                f"the chain needs {extent:.3g} m x {scene.width:.3g} m, the picture shows "
                f"{scale * camera.width:.3g} m x {scale * camera.height:.3g} m: "
                f"take a larger metres_per_pixel, width or height"
            )
        else:
            scales = np.array([scale])
        half, angle = np.array([camera.width, camera.height]) / 2, np.radians(camera.angle)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        last, length = movement.x_m[:, -1], scene.block_length
        way = np.array([last.min() - length / 2, last.max() + length / 2])
        for scale in scales.tolist():
            left, top = _MARGIN / scale, (camera.height - scene.width / scale) / 2
            middle = top + scene.block_width / scale / 2
            zero = half + turn @ ([left, middle] - half) - 0.5
            edges = left + way / scale, (top, top + scene.block_width / scale)
            corners = np.stack(np.meshgrid(*edges), axis=-1).reshape(-1, 2)
            corners = half + (corners - half) @ turn.T
            if not camera.angle or np.all((corners > 1) & (corners < 2 * half - 1)):
                return cls(scale, camera.width, camera.height, left, top, tuple(zero.tolist()))
        raise InputError(
            f"angle = {camera.angle:g}: turns the last block out of the picture, "
            f"{camera.width} x {camera.height} pixels: take a larger height"
        )

    def along(self, metres: Any) -> Any:
        """Places along the belt, in metres from the support, as pixels."""
        return self.left + metres / self.metres_per_pixel

    def columns(self, begin: float, end: float) -> np.ndarray:
        """Share (W,) of each column between two places along the belt, in metres."""
        return band(self.along(begin), self.along(end), self.width)

    def rows(self, begin: float, width: float) -> np.ndarray:
        """Share (H,) of each row in a band across the belt, metres from the blocks' upper edge."""
        low, high = (self.top + edge / self.metres_per_pixel for edge in (begin, begin + width))
        return band(low, high, self.height)


class _Light:
    """The light that reaches the picture, with exact coverage of each pixel, and the lens's blur.

    All edges lie along the belt or across it. So the picture is a sum of products of a column
    (which rows a band of the scene covers) and a row (the brightness along that band). The blur is
    that of the columns and the rows, each for itself, and it is the same in all directions: it may
    come before the picture is turned.
    """

    def __init__(self, scene: Scene, view: Framing, blur: float) -> None:
        self._scene, self._view, self._blur = scene, view, blur
        blocks = view.rows(0.0, scene.block_width)
        springs = view.rows((scene.block_width - scene.spring_width) / 2, scene.spring_width)
        self._rows = self._blurred(np.stack([blocks, springs], axis=1), (0, 1))
        self._still = self._blurred(_still_picture(scene, view), (1, 1))

    def __call__(self, places: np.ndarray) -> np.ndarray:
        """Brightness (H, W) of a frame; blocks (2, N) at begin and end of the exposure, metres."""
        return self._rows @ self._blurred(self._lanes(places), (1, 0)) + self._still

    def _lanes(self, places: np.ndarray) -> np.ndarray:
        """Brightness (2, W) along the lane of the blocks and along that of the springs."""
        scene, view = self._scene, self._view
        left, right = (view.along(places + side * scene.block_length) for side in (-0.5, 0.5))
        # Where the model's blocks, which are points, come too near, the outer one hides the inner.
        right[:, :-1] = np.minimum(right[:, :-1], left[:, 1:])
        bright = np.full(places.shape[1], scene.block - scene.belt)
        bright[-1] = scene.white_block - scene.belt
        # The springs, as so many turns each, from the support to the last block.
        begin = np.column_stack([[view.left, view.left], right[:, :-1]])[..., np.newaxis]
        turn = (left[..., np.newaxis] - begin) / scene.coils
        number = np.arange(scene.coils)
        first, last = ((begin + (number + part) * turn).reshape(2, -1) for part in (0.3, 0.7))
        turns = np.full(first.shape[1], scene.spring - scene.belt)
        blocks = lane(left, right, bright, view.width)
        return np.stack([blocks, lane(first, last, turns, view.width)])

    def _blurred(self, light: np.ndarray, ways: tuple[int, int]) -> np.ndarray:
        """An array, blurred along its rows (1, 0), its columns (0, 1) or both."""
        light = light.astype(np.float32)
        if not self._blur:
            return light
        size = [2 * int(np.ceil(4 * self._blur)) + 1 if way else 1 for way in ways]
        return cv2.GaussianBlur(light, size, self._blur, borderType=cv2.BORDER_REPLICATE)


def _still_picture(scene: Scene, view: Framing) -> np.ndarray:
    """Belt, support and tape measure: brightness (H, W)."""
    support = np.outer(view.rows(0, scene.block_width), view.columns(-np.inf, 0))
    picture = scene.belt + (scene.support - scene.belt) * support
    edge = scene.block_width + scene.tape_gap
    # The tape begins a little before its zero mark, and goes on beyond the picture.
    length = view.columns(-0.3 * scene.mark_spacing, np.inf)
    picture += (scene.tape - scene.belt) * np.outer(view.rows(edge, scene.tape_width), length)
    short, long = view.rows(edge, scene.mark_length), view.rows(edge, scene.long_mark_length)
    for number in range(int((view.width - view.left) * view.metres_per_pixel / scene.mark_spacing)):
        middle, half = number * scene.mark_spacing, scene.mark_width / 2
        mark = np.outer(short if number % 10 else long, view.columns(middle - half, middle + half))
        picture += (scene.mark - scene.tape) * mark
    return picture


class _Shutter:
    """What direction, lamp, sensor and recorder make of the light."""

    def __init__(self, camera: Camera, view: Framing) -> None:
        self._camera = camera
        self._random = np.random.default_rng(camera.seed)
        # Each frame takes its noise from a random place of this store: to draw it anew would take
        # longer than all the rest.
        store = _NOISE_PICTURES * view.width * view.height
        self._noise = self._random.standard_normal(store, dtype=np.float32)
        middle = ((view.width - 1) / 2, (view.height - 1) / 2)
        self._turn = cv2.getRotationMatrix2D(middle, -camera.angle, 1.0)
        self._along = np.linspace(-1, 1, view.width, dtype=np.float32)
        self._across = np.linspace(-1, 1, view.height, dtype=np.float32)[:, np.newaxis]

    def drops_frame(self) -> bool:
        """Whether the next frame is lost."""
        return bool(self._camera.dropped) and self._random.random() < self._camera.dropped

    def __call__(self, light: np.ndarray, time: float) -> np.ndarray:
        """The recorded picture (H, W), 8 bit."""
        if self._camera.angle:
            size = light.shape[::-1]
            light = cv2.warpAffine(light, self._turn, size, borderMode=cv2.BORDER_REPLICATE)
        light *= self._lamp(time)
        begin = self._random.integers(self._noise.size - light.size)
        noise = self._noise[begin : begin + light.size].reshape(light.shape)
        # rounds, and cuts at black and white
        return cv2.addWeighted(light, 1.0, noise, self._camera.sensor_noise, 0.0, dtype=cv2.CV_8U)

    def _lamp(self, time: float) -> np.ndarray:
        """How bright it is in each pixel (H, W) at an instant, 1 on average."""
        phase = 2 * np.pi * time / _DRIFT_PERIOD
        turned = self._camera.light_drift * phase
        brightness = 1 + self._camera.light_drift * np.sin(phase)
        slope = np.float32(brightness * self._camera.light_unevenness)
        along = np.float32(brightness) + slope * np.float32(np.cos(turned)) * self._along
        return along + slope * np.float32(np.sin(turned)) * self._across


# --- how much of each pixel lies beyond an edge, exactly, also while the edge moves ---------------


def band(low: float, high: float, count: int) -> np.ndarray:
    """Share (count,) of each pixel between two places; pixel j reaches from j to j + 1."""
    return np.diff(np.clip(np.arange(count + 1), low, max(low, high)))


def lane(left: np.ndarray, right: np.ndarray, bright: np.ndarray, count: int) -> np.ndarray:
    """Brightness (count,) along a lane with things between edges (2, M) that move.

    An edge is at the first of its two places when the shutter opens and at the second when it
    closes. Each pixel shows its mean over all places between.
    """
    edges, steps = np.hstack([left, right]), np.concatenate([bright, -bright])
    middle, half = edges.mean(axis=0), np.abs(np.diff(edges, axis=0)[0]) / 2
    # Few pixels see an edge: those it passes, and one more on either side.
    first = np.floor(edges.min(axis=0)).astype(int) - 1
    pixels = first + np.arange(int(np.ceil(2 * half.max())) + 3)[:, np.newaxis]
    half = np.maximum(half, 1e-6)  # so short a way leaves digits enough in the difference
    beyond = pixels + 1 - middle
    behind = (_integral(beyond + half) - _integral(beyond - half)) / (2 * half)
    changes = np.diff(behind, axis=0, prepend=0) * steps
    inside = pixels < count
    return np.bincount(np.maximum(pixels, 0)[inside], changes[inside], count).cumsum()


def _integral(distance: np.ndarray) -> np.ndarray:
    """Integral from minus infinity of clip(s, 0, 1) over s."""
    inside = np.clip(distance, 0, 1)
    return inside * (distance - inside / 2)

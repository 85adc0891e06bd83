"""What the beginning of a video tells of all of it: direction, scale, zero, side of the support."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import cv2
import numpy as np

from beltrepro.base.errors import InputError
from beltrepro.replication.camera import tape, white_block
from beltrepro.replication.camera.scene import Scene
from beltrepro.replication.camera.white_block import Place, Region

SUPPORTS = ("left", "right", "auto")
# Things narrower than so many pixels across the belt are wiped off to free the block of them.
_OPENINGS = (0, 6, 12, 24, 48)
# Size of the block in the picture over the one that the scale leads to expect, and by how many
# pixels edges change it. Its top is nearer to the camera than the tape, so it may look larger.
_SMALLER, _LARGER, _EDGES = 0.88, 1.15, 1.0
# A spring varies across the belt by so much more than the bare belt beyond the block, and by so
# many levels of brightness more.
_SPRING_FACTOR, _SPRING_LEVELS = 2.0, 0.5


@dataclass(frozen=True)
class Survey:
    """Where things are in a video that was taken by a camera at rest."""

    metres_per_pixel: float  # scale
    angle: float  # by which the belt is turned in the picture, degrees, clockwise
    # place of the first mark or of the edge, pixels from the middle of the picture, along the
    # belt, away from the support
    zero: float
    towards: int  # 1 if the chain extends to the right, -1 if to the left
    along: float  # sides of the white block, pixels
    across: float
    middle: tuple[float, float]  # of the picture, pixels

    @classmethod
    def of(
        cls,
        pictures: list[np.ndarray],
        scene: Scene,
        metres_per_pixel: float | None,
        first_mark: float | None,
        support: str,
        name: str,
    ) -> Survey:
        """The survey of some frames."""
        mean = np.stack(pictures).mean(axis=0, dtype=np.float32)
        angle = tape.direction(mean)
        ratio = scene.block_length / scene.block_width
        regions = [_candidates(picture, angle, ratio) for picture in pictures]
        measure, scale = _scale(mean, angle, regions, scene, metres_per_pixel, name)
        blocks = _one_each(pictures, regions, angle, scale, scene, name)
        along, across = scene.block_length / scale, scene.block_width / scale
        _check_size(blocks, scale, scene, name)
        towards = {"left": 1, "right": -1}.get(support) or _side(
            pictures, blocks, angle, (along, across), name
        )
        if measure and towards == -1:
            measure = tape.find_tape(mean[::-1, ::-1], angle, measure.spacing)
        if measure and not measure.begins and first_mark is None:
            edge, other = ("left", "right")[::towards]
            raise InputError(
                f"{name}: the tape measure goes on beyond the {edge} edge of the "
                f"picture, where the chain is held: give what it reads at the first mark there, "
                f"--first-mark in metres; or --support {other}, if it is held there"
            )
        height, width = mean.shape
        middle = ((width - 1) / 2, (height - 1) / 2)
        zero = measure.first if measure else -middle[0]
        return cls(scale, angle, zero, towards, along, across, middle)

    def along_belt(self, place: Place) -> float:
        """Pixels from the first mark, along the belt, away from the support."""
        return self.towards * self._projected(place, 0.0) - self.zero

    def across_belt(self, place: Place | Region) -> float:
        """Pixels from the middle of the picture, across the belt."""
        return self._projected(place, 90.0)

    def _projected(self, place: Place | Region, turn: float) -> float:
        direction = np.radians(self.angle + turn)
        x, y = place.x - self.middle[0], place.y - self.middle[1]
        return float(np.cos(direction) * x + np.sin(direction) * y)


def _check_size(blocks: list[Region | None], scale: float, scene: Scene, name: str) -> None:
    """Refuse a scale at which the block has another size: of a tape with other marks, mostly."""
    sides = np.median([(block.along, block.across) for block in blocks if block], axis=0)
    sizes = np.array([scene.block_length, scene.block_width])
    seen, expected = np.sqrt(sides.prod()), np.sqrt(sizes.prod()) / scale
    if not _SMALLER * expected - _EDGES < seen < _LARGER * expected + _EDGES:
        length, width = 100 * scale * sides
        raise InputError(
            f"{name}: at {scale:.3g} m per pixel the white block has {length:.1f} x {width:.1f} "
            f"cm, and not {100 * sizes[0]:g} x {100 * sizes[1]:g}: give the distance of the marks, "
            f"--mark-spacing, or the sizes of the block, --block-length and --block-width, in "
            f"metres"
        )


def _side(
    pictures: list[np.ndarray],
    blocks: list[Region | None],
    angle: float,
    sides: tuple[float, float],
    name: str,
) -> int:
    """1 if the chain extends to the right, -1 if to the left: the white block is the last one."""
    along, across = sides
    half, rows = int(np.ceil(1.5 * along)), max(2, int(0.45 * across))
    beside = max(2, int(0.4 * along))  # columns; between them and the block there may be a rim
    # Pictures of the block and its surroundings are laid over each other. The spring stays where it
    # is. What moves otherwise, as a glare that the block passes, is there in fewer than half.
    pairs = zip(pictures, blocks, strict=True)
    around = np.stack([_around(seen, block, angle, half, rows) for seen, block in pairs if block])
    left, right = (
        float(np.median(part.mean(axis=2), axis=0).std())
        for part in (around[:, :, :beside], around[:, :, -beside:])
    )
    for here, there, towards in ((left, right, 1), (right, left, -1)):
        if here > _SPRING_FACTOR * there + _SPRING_LEVELS:
            return towards
    raise InputError(
        f"{name}: no spring is seen on just one side of the white block: give the side of the "
        f"picture where the chain is held, --support left or right"
    )


def _around(picture: np.ndarray, block: Region, angle: float, half: int, rows: int) -> np.ndarray:
    """The surroundings of a block (2 rows + 1, 2 half + 1), straightened."""
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[cosine, -sine], [sine, cosine]])
    corner = np.array([block.x, block.y]) - turn @ (half, rows)
    return cv2.warpAffine(
        picture,
        np.column_stack([turn, corner]),
        (2 * half + 1, 2 * rows + 1),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    ).astype(np.float32)


def _candidates(picture: np.ndarray, angle: float, ratio: float) -> list[Region]:
    """What may be the white block in a picture, of any size."""
    regions: list[Region] = []
    for opening in _OPENINGS:
        if opening < picture.shape[0] / 2 and not regions:
            regions = list(white_block.bright_rectangles(picture, angle, ratio, opening))
    return sorted(regions, key=lambda region: -region.along * region.across)


def _scale(
    mean: np.ndarray,
    angle: float,
    regions: list[list[Region]],
    scene: Scene,
    scale: float | None,
    name: str,
) -> tuple[tape.Tape | None, float]:
    """The tape, if there is one, and metres per pixel."""
    if scale is not None:
        return tape.find_tape(mean, angle, scene.mark_spacing / scale), scale
    area = scene.block_length * scene.block_width
    sizes = [np.sqrt(region.along * region.across / area) for seen in regions for region in seen]
    if not sizes:
        raise InputError(
            f"{name}: no white block found: a bright rectangle across the belt, which must run "
            f"from left to right"
        )
    # Each size leads to expect a distance of the marks; that with the clearest marks counts. Sizes
    # within a tenth are one, and the rare ones are not tried.
    often = Counter(np.round(np.log(sizes) * 10).astype(int).tolist()).most_common(6)
    rounded = np.round(np.log(sizes) * 10)
    guesses = [float(np.median(np.array(sizes)[rounded == size])) for size, _ in often]
    seen = [tape.find_tape(mean, angle, pixels * scene.mark_spacing) for pixels in guesses]
    tapes = [measure for measure in seen if measure]
    if not tapes:
        size = guesses[0] * scene.block_length, guesses[0] * scene.block_width
        raise InputError(
            f"{name}: no tape measure with a mark every {100 * scene.mark_spacing:g} cm found: if "
            f"the white block is a rectangle of {size[0]:.0f} x {size[1]:.0f} pixels, give the "
            f"scale, about {1 / guesses[0]:.2g} m per pixel; if not, film a white block and a tape"
        )
    best = max(tapes, key=lambda measure: measure.clearness)
    return best, scene.mark_spacing / best.spacing


def _one_each(
    pictures: list[np.ndarray],
    regions: list[list[Region]],
    angle: float,
    scale: float,
    scene: Scene,
    name: str,
) -> list[Region | None]:
    """The block in each picture; refuse a film without one of the right size, or with several."""
    along, across = scene.block_length / scale, scene.block_width / scale
    blocks = [
        [
            region
            for region in candidates
            if white_block.has_size(region, along, across)
            and white_block.place_block(picture, region, angle, along, across)
        ]
        for picture, candidates in zip(pictures, regions, strict=True)
    ]
    seen = [one for one in blocks if one]
    if not seen:
        raise InputError(
            f"{name}: no white block found: at {scale:.4g} m per pixel it would be a bright "
            f"rectangle of {along:.0f} x {across:.0f} pixels"
        )
    several = [one for one in seen if len(one) > 1]
    if 2 * len(several) > len(seen):
        places = " and ".join(f"({block.x:.0f}, {block.y:.0f})" for block in several[0][:2])
        raise InputError(
            f"{name}: {len(several[0])} white blocks found, at the pixels {places}; "
            f"one is needed: cover the other"
        )
    return [one[0] if len(one) == 1 else None for one in blocks]

"""What the beginning of a video tells of all of it: direction, scale, zero, side of the support."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from beltrepro.base.errors import InputError
from beltrepro.replication.camera import tape, white_block
from beltrepro.replication.camera.following import Follower
from beltrepro.replication.camera.ruler import Ruler
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

_AT_REST = 0.3  # pixels by which pictures may be shifted to be of a camera at rest
_TRIED = 4  # pictures of a camera that moves in which the tape is looked for
_MISFIT = 0.25  # of the distance of the marks: how far they may lie off a projective map
# What moves in this share of the width of the block on either side of its middle, in so many marks
# before the zero, at least by this share of what the chain does there beyond it.
_LANE, _BEFORE, _MOVES, _COLUMNS = 0.3, (2, 10), 0.15, 6
# The zero is known if so many of so many first marks are clear, and the second so near the map.
_CLEAR, _FIRST, _BESIDE = 3, 5, 0.2


@dataclass(frozen=True, eq=False)
class Survey:
    """Where things are in a picture of the beginning, and what is measured by it."""

    picture: np.ndarray  # (H, W) brightness, to which all other pictures are compared
    measure: tape.Tape | None  # its tape; None where the scale was given and there is none
    ruler: Ruler  # metres along the belt
    angle: float  # by which the belt is turned in the picture, degrees, clockwise
    towards: int  # 1 if the chain extends to the right, -1 if to the left
    along: float  # sides of the white block, pixels
    across: float
    frame: np.ndarray  # (H, W) one of the pictures, in which the tape is where it is in `picture`
    block: Region  # the white block in it
    sides_m: tuple[float, float]  # of the white block, as they were told

    @classmethod
    def of(
        cls,
        pictures: list[np.ndarray],
        scene: Scene,
        metres_per_pixel: float | None = None,
        first_mark: float | None = None,
        support: str = "auto",
    ) -> Survey:
        """The survey of some frames."""
        picture, angle, regions, measure, scale = _reference(pictures, scene, metres_per_pixel)
        sides_m = scene.block_length, scene.block_width
        along, across = (side / scale for side in sides_m)
        blocks = _one_each(pictures, regions, angle, along, across)
        _check_size(blocks, scale, sides_m)
        seen = [(one, block) for one, block in zip(pictures, blocks, strict=True) if block]
        towards = {"left": 1, "right": -1}.get(support) or _side(seen, angle, along, across)
        if measure and towards == -1:
            measure = tape.find_tape(picture, angle + 180, measure.spacing, tape.BENDS)
        ruler = _ruler(measure, scene, metres_per_pixel, first_mark, picture.shape[1], towards)
        frame, block = min(seen, key=lambda pair: float(np.abs(pair[0] - picture).mean()))
        survey = cls(picture, measure, ruler, angle, towards, along, across, frame, block, sides_m)
        if measure and first_mark is None and _at_rest(pictures, picture, measure):
            _check_zero(survey, pictures, [block for _, block in seen])
        return survey

    @property
    def turn(self) -> float:
        """Degrees by which the picture is turned for the chain to extend to the right."""
        return self.angle + (0.0 if self.towards == 1 else 180.0)

    @property
    def zero(self) -> float:
        """Where x = 0 is, pixels from the middle of the picture along the belt."""
        return float(self.ruler.places(np.array([-self.ruler.first_m / self.ruler.spacing_m]))[0])

    def along_belt(self, place: Place | Region) -> float:
        """Pixels from the middle of the picture, along the belt, away from the support."""
        return self._projected(place, self.turn)

    def across_belt(self, place: Place | Region) -> float:
        """Pixels from the middle of the picture, across the belt."""
        return self._projected(place, self.turn + 90.0)

    def in_picture(self, along: float, across: float) -> tuple[float, float]:
        """The pixel at such a place."""
        height, width = self.picture.shape
        cosine, sine = np.cos(np.radians(self.turn)), np.sin(np.radians(self.turn))
        return (
            float((width - 1) / 2 + cosine * along - sine * across),
            float((height - 1) / 2 + sine * along + cosine * across),
        )

    def _projected(self, place: Place | Region, angle: float) -> float:
        direction = np.radians(angle)
        height, width = self.picture.shape
        x, y = place.x - (width - 1) / 2, place.y - (height - 1) / 2
        return float(np.cos(direction) * x + np.sin(direction) * y)


def _reference(
    pictures: list[np.ndarray], scene: Scene, metres_per_pixel: float | None
) -> tuple[np.ndarray, float, list[list[Region]], tape.Tape | None, float]:
    """A picture that shows the tape, the direction of the belt in it, what may be the block in all
    pictures, the tape, and metres per pixel.

    It is the mean of all pictures where the camera is at rest; where it is not, one of them.
    """
    mean: np.ndarray = np.asarray(np.mean(pictures, axis=0, dtype=np.float32))
    angle = tape.direction(mean)
    ratio, failure = scene.block_length / scene.block_width, None
    regions = [_candidates(one, angle, ratio) for one in pictures]
    for picture in (mean, *pictures[:: max(1, len(pictures) // _TRIED)]):
        try:
            measure, scale = _scale(picture, angle, regions, scene, metres_per_pixel)
        except InputError as reason:
            failure = failure or reason
        else:
            if picture is not mean or measure is None or _at_rest(pictures, mean, measure):
                return picture.astype(np.float32), angle, regions, measure, scale
    raise failure or InputError("the camera moves too much: no picture shows the tape")


def _at_rest(pictures: list[np.ndarray], mean: np.ndarray, measure: tape.Tape) -> bool:
    """Whether the tape is in all pictures where it is in their mean."""
    follower = Follower(mean, measure)
    moved = np.array([follower(picture).values for picture in pictures])
    return bool(np.nanmax(np.abs(moved), initial=0.0) < _AT_REST)


def _ruler(
    measure: tape.Tape | None,
    scene: Scene,
    metres_per_pixel: float | None,
    first_mark: float | None,
    width: int,
    towards: int,
) -> Ruler:
    """The ruler of a tape, or one of a scale that was given."""
    edge, other = ("left", "right")[::towards]
    if measure is None:
        if first_mark is None or metres_per_pixel is None:
            raise InputError(
                f"no tape measure found, so the zero is not known: give the distance of the {edge} "
                f"edge of the picture from the support, --first-mark in metres"
            )
        return Ruler.even(metres_per_pixel, width, first_mark)
    if not measure.begins and first_mark is None:
        raise InputError(
            f"the tape measure goes on beyond the {edge} edge of the picture, where the chain is "
            f"held: give what it reads at the first mark there, --first-mark in metres; or "
            f"--support {other}, if it is held there"
        )
    ruler = Ruler.of(measure, width, scene.mark_spacing, first_mark or 0.0)
    if not ruler.misfit < _MISFIT:
        raise InputError(
            f"the marks of the tape lie {ruler.misfit:.2f} of their distance beside those of a "
            f"straight tape, {_MISFIT:g} is allowed: film from straight above, and let nothing "
            f"cover the tape"
        )
    # The first mark may lie beside the map, as the end of the tape moves it: the second may not, or
    # what seems to be marks is what a codec or a cloth puts there.
    second = np.abs(ruler.residuals[measure.numbers == 1])
    if np.sum(measure.numbers < _FIRST) < _CLEAR or not np.any(second < _BESIDE):
        raise InputError(
            "the first marks of the tape are not clear, so its zero is not known: film it from its "
            "beginning, uncovered"
        )
    first, every = measure.long or (0, 10)
    if first and first_mark is None:
        reads = (every - first) * scene.mark_spacing
        raise InputError(
            f"the first mark seen is not the zero of the tape: by the long marks it reads "
            f"{reads:g} m or {reads + every * scene.mark_spacing:g} m and so on: give what it "
            f"reads, --first-mark in metres"
        )
    return ruler if metres_per_pixel is None else ruler.with_scale(metres_per_pixel)


def _check_zero(survey: Survey, pictures: list[np.ndarray], blocks: list[Region]) -> None:
    """Refuse a zero before which the chain moves: it is held there."""
    height, width = survey.picture.shape
    row, half = survey.across_belt(blocks[0]) + height / 2, _LANE * survey.across
    lane = slice(max(0, int(row - half)), int(row + half) + 1)
    turned = np.stack([tape.straightened(one, survey.turn)[0][lane] for one in pictures])
    # a hand is there in fewer than half of the pictures, and what changes behind the block is noise
    changes = np.median(np.abs(turned - np.median(turned, axis=0)), axis=0).mean(axis=0)
    place = np.arange(width) - (width - 1) / 2
    farthest = max(survey.along_belt(block) for block in blocks) + survey.along
    marks = (survey.zero - place) / (survey.ruler.spacing_m / survey.ruler.metres_per_pixel)
    before, behind = (marks > _BEFORE[0]) & (marks < _BEFORE[1]), place > farthest
    chain = (marks < 0) & (place < farthest - 2 * survey.along)
    if min(part.sum() for part in (before, behind, chain)) < _COLUMNS:
        return
    moves, noise, moving = (float(np.median(changes[part])) for part in (before, behind, chain))
    if moving > 2 * noise and moves > noise + _MOVES * (moving - noise):
        raise InputError(
            "the chain moves before the first mark that is seen of the tape, so that is not zero: "
            "give what it reads, --first-mark in metres"
        )


def _check_size(blocks: list[Region | None], scale: float, sides_m: tuple[float, float]) -> None:
    """Refuse a scale at which the block has another size: of a tape with other marks, mostly."""
    sides = np.median([(block.along, block.across) for block in blocks if block], axis=0)
    sizes = np.array(sides_m)
    seen, expected = np.sqrt(sides.prod()), np.sqrt(sizes.prod()) / scale
    if not _SMALLER * expected - _EDGES < seen < _LARGER * expected + _EDGES:
        length, width = 100 * scale * sides
        raise InputError(
            f"at {scale:.3g} m per pixel the white block has {length:.1f} x {width:.1f} cm, and "
            f"not {100 * sizes[0]:g} x {100 * sizes[1]:g}: give the distance of the marks, "
            f"--mark-spacing, or the sizes of the block, --block-length and --block-width, in "
            f"metres"
        )


def _side(seen: list[tuple[np.ndarray, Region]], angle: float, along: float, across: float) -> int:
    """1 if the chain extends to the right, -1 if to the left: the white block is the last one."""
    half, rows = int(np.ceil(1.5 * along)), max(2, int(0.45 * across))
    beside = max(2, int(0.4 * along))  # columns; between them and the block there may be a rim
    # Pictures of the block and its surroundings are laid over each other. The spring stays where it
    # is. What moves otherwise, as a glare that the block passes, is there in fewer than half.
    around = np.stack([white_block.around(*pair, angle, half, rows) for pair in seen])
    left, right = (
        float(np.median(part.mean(axis=2), axis=0).std())
        for part in (around[:, :, :beside], around[:, :, -beside:])
    )
    for here, there, towards in ((left, right, 1), (right, left, -1)):
        if here > _SPRING_FACTOR * there + _SPRING_LEVELS:
            return towards
    raise InputError(
        "no spring is seen on just one side of the white block: give the side of the picture where "
        "the chain is held, --support left or right"
    )


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
) -> tuple[tape.Tape | None, float]:
    """The tape, if there is one, and metres per pixel."""
    if scale is not None:
        return tape.find_tape(mean, angle, scene.mark_spacing / scale, tape.BENDS), scale
    area = scene.block_length * scene.block_width
    sizes = np.sqrt([region.along * region.across / area for seen in regions for region in seen])
    if not sizes.size:
        raise InputError(
            "no white block found: a bright rectangle across the belt, which must run from left to "
            f"right{_advice(mean)}"
        )
    # Each size leads to expect a distance of the marks; that with the clearest marks counts. Sizes
    # within a tenth are one, and the rare ones are not tried.
    rounded = np.round(np.log(sizes) * 10)
    often = Counter(rounded.tolist()).most_common(6)
    guesses = [float(np.median(sizes[rounded == size])) for size, _ in often]
    for bends in (tape.BENDS[:1], tape.BENDS[1:]):
        seen = [tape.find_tape(mean, angle, one * scene.mark_spacing, bends) for one in guesses]
        if tapes := [measure for measure in seen if measure]:
            best = max(tapes, key=lambda measure: measure.clearness)
            return best, scene.mark_spacing / best.spacing
    raise InputError(
        f"no tape measure with a mark every {100 * scene.mark_spacing:g} cm found{_advice(mean)}: "
        f"film a white block and a tape; or give both the scale and the zero, --scale in metres "
        f"per pixel and --first-mark in metres"
    )


def _advice(picture: np.ndarray) -> str:
    """What to do with a film in which the belt runs from top to bottom."""
    return "; turn the film by a quarter" if tape.lies_on_its_side(picture) else ""


def _one_each(
    pictures: list[np.ndarray],
    regions: list[list[Region]],
    angle: float,
    along: float,
    across: float,
) -> list[Region | None]:
    """The block in each picture; refuse a film without one of the right size, or with several."""
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
            f"no white block found: it would be a bright rectangle of {along:.0f} x {across:.0f} "
            f"pixels"
        )
    several = [one for one in seen if len(one) > 1]
    if 2 * len(several) > len(seen):
        places = " and ".join(f"({block.x:.0f}, {block.y:.0f})" for block in several[0][:2])
        raise InputError(
            f"{len(several[0])} white blocks found, at the pixels {places}; "
            f"one is needed: cover the other"
        )
    return [one[0] if len(one) == 1 else None for one in blocks]

"""What the tape reads beside the block: the line of the block's edges is followed to the tape."""

from __future__ import annotations

import numpy as np
import scipy

from beltrepro.base.errors import InputError
from beltrepro.replication.camera import following
from beltrepro.replication.camera.ruler import Ruler
from beltrepro.replication.camera.survey import Survey
from beltrepro.replication.camera.track_file import Track
from beltrepro.replication.camera.white_block import Place

# Lines across the belt lean by hundredths where the camera is tilted, at either end of the picture
# another way: one standard deviation in the middle, and of the change to the end.
_LEAN, _FAN = 0.2, 0.1
_LEAN_ERROR = 0.001  # what remains: pixels are squares, and light comes from one side
_ALIKE = 8  # neighbouring frames that share their error
_OUTLIER = 4.0  # standard deviations
_NEAR = 1e-9  # metres: a block that stays there has no slope
# The size of the block is measured where it moves less from frame to frame, pixels, in so many
# frames at least, if it is so long.
_STILL, _FEWEST, _SHORTEST = 1.0, 3, 15.0
_SIZE = 0.0125  # share by which the block may look larger or smaller than it is
_FINEST = 0.0075  # share of its size that uneven light, shadows and codecs change
_SQUARE = 0.2  # share by which its sides must differ: edges change both alike


def read(
    survey: Survey,
    time_s: np.ndarray,
    lost_s: np.ndarray,
    blocks: list[Place],
    moved: np.ndarray,
    moved_error: np.ndarray,
    tape_height_error: float,
) -> Track:
    """Read the tape beside blocks in pictures that have moved by (T, 5), with errors (T, 5).

    A tape beside which the block has another size than was told is refused.
    """
    ruler, half = survey.ruler, survey.ruler.half_width
    along = np.array([survey.along_belt(block) for block in blocks])
    across = np.array([survey.across_belt(block) for block in blocks])
    error = _edge_error(blocks, along / half)
    to_tape, lean, lean_covariance = np.zeros_like(along), np.zeros_like(along), np.zeros((2, 2))
    if survey.measure:
        to_tape = survey.measure.line + following.across(moved, along, half) - across
        # A picture that is turned turns the lines, too.
        turned = moved[:, following.TURN] / half
        seen = np.array([block.lean for block in blocks]) + turned
        lean, lean_covariance = _lean(seen, along / half)
        lean = lean - turned
    foot = along + lean * to_tape
    place = foot - following.along(moved, foot, half)
    place = foot - following.along(moved, place, half)
    x, scale = ruler.metres(place), np.abs(ruler.scale(place))
    shaken = np.sqrt(following.along(moved_error**2, np.abs(place), half))
    variance, scale_error, zero_error = np.zeros_like(x), np.nan, np.nan
    if survey.measure:
        variance, scale_error, zero_error = _common(
            ruler, x, place, to_tape * scale, lean_covariance
        )
    # A tape that lies deeper or higher than the top of the block gives another scale, about the
    # point below the camera, which is taken to be in the middle of the picture.
    off, middle = _off_size(survey, blocks, place, scale), ruler.metres(np.zeros(1))[0]
    if survey.measure:  # the size of the block does not tell a height of some millimetres
        off = float(np.hypot(off, tape_height_error / ruler.distance_m))
    variance += (off * (x - middle)) ** 2
    level = across - following.across(moved, along, half)
    slope = 0.0  # degrees between the way of the block, if it is long, and the lines of the survey
    if place.std() >= survey.along / 2:
        slope = float(np.degrees(np.arctan(np.polyfit(place, level, 1)[0])))
    return Track(
        time_s=time_s,
        x_m=x,
        error_m=np.sqrt(scale**2 * (error**2 + shaken**2) + variance),
        metres_per_pixel=ruler.metres_per_pixel,
        angle=survey.angle + slope,
        lost_s=lost_s,
        scale_error=float(np.hypot(scale_error, off)),
        zero_error_m=float(np.hypot(zero_error, off * middle)),
        survey=survey,
    )


def _off_size(survey: Survey, blocks: list[Place], place: np.ndarray, scale: np.ndarray) -> float:
    """By what share the block looks larger by the tape than was told; 0 where it cannot be seen.

    Blur and the camera's idea of brightness make both sides longer by the same. So the difference
    of width and length counts, in frames in which the block hardly moves.
    """
    length, width = survey.sides_m
    if survey.along < _SHORTEST or abs(width - length) < _SQUARE * max(width, length):
        return 0.0
    along, across = np.transpose([block.sides for block in blocks])
    difference = survey.ruler.scale_across(place) * across - scale * along
    difference /= width - length
    still = np.abs(np.gradient(place)) < _STILL
    difference = difference[still & np.isfinite(difference)]
    if difference.size < _FEWEST:
        return 0.0
    size = float(np.median(difference))
    spread = 1.4826 * float(np.median(np.abs(difference - size)))
    error = spread * float(np.sqrt(np.pi / 2 / difference.size))
    if abs(size - 1) > _SIZE + error:
        sides = " x ".join(f"{100 * side * size:.2f}" for side in survey.sides_m)
        raise InputError(
            f"by the tape the white block has {sides} cm, so the tape lies higher or deeper than "
            f"its top: lay it as high; or the block has another size: give it to a tenth of a "
            f"millimetre, --block-length and --block-width in metres"
        )
    return size - 1 if abs(size - 1) > _FINEST + 2 * error else 0.0


def _edge_error(blocks: list[Place], place: np.ndarray) -> np.ndarray:
    """One standard error of the places along the belt, pixels.

    Where something hides an edge of the block, its length changes by twice the error of its middle.
    """
    error = np.array([block.error for block in blocks])
    length = np.array([block.length for block in blocks])
    terms = np.column_stack([np.ones_like(place), place])
    _, off, spread = _fitted_line(terms, length, np.zeros((2, 2)))
    return np.hypot(error, np.where(off > _OUTLIER * spread, off / 2, 0.0))


def _lean(lean: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A straight line (T,) through the leans of the block at places, and the covariance (2, 2)."""
    terms = np.column_stack([np.ones_like(place), place])
    prior = np.diag([_LEAN**-2, _FAN**-2])
    line, _, spread = _fitted_line(terms, lean, prior)
    information = terms.T @ terms / spread**2
    covariance = np.linalg.inv(information / _ALIKE + prior)
    return terms @ line, covariance + np.diag([_LEAN_ERROR**2, 0.0])


def _fitted_line(
    terms: np.ndarray, values: np.ndarray, prior: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Coefficients (2,) of a line without outliers, distances (T,) from it, and their spread."""
    off, spread = np.zeros(len(values)), 1.0
    for _ in range(4):  # a glare, a shadow or a hand changes the edges in some frames
        kept = off <= _OUTLIER * spread
        information = terms[kept].T @ terms[kept] / spread**2 + prior + 1e-9 * np.eye(2)
        line = np.linalg.solve(information, terms[kept].T @ values[kept] / spread**2)
        off = np.abs(values - terms @ line)
        spread = max(1.4826 * float(np.median(off)), 1e-4)
    return line, off, spread


def _common(
    ruler: Ruler,
    x: np.ndarray,
    place: np.ndarray,
    to_tape_m: np.ndarray,
    lean_covariance: np.ndarray,
) -> tuple[np.ndarray, float, float]:
    """Variances (T,) of the errors that all frames have in common, of the map and of the lean, and
    the errors of scale and zero that they make."""
    changes = np.column_stack(
        [ruler.slopes(place), to_tape_m, to_tape_m * place / ruler.half_width]
    )
    covariance = scipy.linalg.block_diag(ruler.covariance, lean_covariance)
    variance = np.einsum("ti,ij,tj->t", changes, covariance, changes)
    centred = x - x.mean()
    by_scale = centred @ changes / max(float(centred @ centred), _NEAR**2)
    by_zero = changes.mean(axis=0) - by_scale * x.mean()
    scale, zero = (float(np.sqrt(one @ covariance @ one)) for one in (by_scale, by_zero))
    return variance, scale, zero

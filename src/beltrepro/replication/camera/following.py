"""How the picture moves when the camera is shaken or pushed: the tape is followed in each frame."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np

from beltrepro.replication.camera import tape

# Along the belt the picture is shifted, stretched and bent, across it shifted and turned: each in
# pixels, at the right edge of the picture.
SHIFT, STRETCH, BEND, ACROSS, TURN = range(5)
_PARTS = 24  # of the tape, at most, each of which tells where it is
_MARKS = 6  # in a part, at least
_MARGIN = 1.25  # rows beside those of the marks, as a share of them: edges and numbers of the tape
_LIGHT = 4.0  # squared levels of brightness: what noise and codec change anyway
_DARKEST = 0.2  # share of its light that a part has left unless something covers it
_ALIKE = 0.5  # correlation of a part with itself in another frame, at least
_OUTLIER = 4.0  # standard errors
_NEAR, _STEPS = 0.1, 8  # pixels: where the search ends; and how often it goes on
_WORSE = 0.03  # lack of likeness that calls for a look at the whole picture
# By what share of the shift of its middle more the edge of a picture moves when a camera is turned,
# if its lens is that of a phone: the square of half the width over the focal length.
_SWING = 0.4
_FRAMES_ALIKE = 2.0  # squared errors of neighbouring pixels that a codec treats as one


class Motion(NamedTuple):
    """Where the picture has gone since the survey."""

    values: np.ndarray  # (5,) pixels; nan if the tape is not seen
    errors: np.ndarray  # (5,) one standard error of each


def along(values: np.ndarray, place: np.ndarray, half_width: float) -> np.ndarray:
    """By how many pixels (T,) a place along the belt has moved; values are (T, 5)."""
    u = place / half_width
    return values[..., SHIFT] + values[..., STRETCH] * u + values[..., BEND] * u**2


def across(values: np.ndarray, place: np.ndarray, half_width: float) -> np.ndarray:
    """The same across the belt."""
    return values[..., ACROSS] + values[..., TURN] * place / half_width


class Follower:
    """Finds the tape in each frame, from where it was in the frame before."""

    def __init__(self, picture: np.ndarray, measure: tape.Tape) -> None:
        height, width = picture.shape
        self._turn, self._spacing, self._half = measure.turn, measure.spacing, width / 2
        margin = max(2, round(_MARGIN * (measure.rows.stop - measure.rows.start)))
        self._top = max(0, measure.rows.start - margin)
        rows = np.arange(self._top, min(height, measure.rows.stop + margin), dtype=np.float32)
        self._middle = (width - 1) / 2, (height - 1) / 2
        self._place = np.arange(width, dtype=np.float32) - np.float32(self._middle[0])
        self._row = rows[:, np.newaxis] - self._middle[1]
        self._count = int(np.clip(width / max(16, _MARKS * measure.spacing), 3, _PARTS))
        size = width // self._count
        first = (width - self._count * size) // 2
        self._columns = slice(first, first + self._count * size)
        self._u = self._parts(self._place[np.newaxis]).mean(axis=1) / self._half
        self._last, self._usual = np.zeros(5), 1.0
        self._strip, _ = self._seen(picture, self._last)
        self._learn()

    def __call__(self, picture: np.ndarray) -> Motion:
        """How the picture has moved since the survey."""
        motion, likeness, mistaken = self._from(picture, self._last)
        leap = np.abs(motion.values - self._last).sum()
        if mistaken or likeness < self._usual - _WORSE or not leap < self._spacing / 4:
            for start in self._wide(picture):
                other, other_likeness, _ = self._from(picture, start)
                if other_likeness > likeness:
                    motion, likeness = other, other_likeness
        if not likeness > self._usual / 2:
            return Motion(np.full(5, np.nan), np.full(5, np.nan))
        self._last = motion.values
        # What is usual is learned slowly, as light, sharpness and codec change.
        self._usual += 0.05 * (likeness - self._usual)
        return motion

    def _parts(self, strip: np.ndarray) -> np.ndarray:
        """A strip (R, W) as its parts (K, R w)."""
        rows = strip.shape[0]
        cut = strip[:, self._columns].reshape(rows, self._count, -1)
        return cut.transpose(1, 0, 2).reshape(self._count, -1)

    def _along(self, parts: np.ndarray) -> np.ndarray:
        """What varies along the rows of parts (K, R w): the edges of the tape do not tell marks."""
        rows = parts.reshape(self._count, len(self._row), -1)
        return (rows - rows.mean(axis=2, keepdims=True)).reshape(self._count, -1)

    def _learn(self) -> None:
        """What a small shift of each part would change."""
        strip = self._strip
        slope_along, slope_across = _slope(strip), _slope(strip.T).T
        one = np.ones_like(strip)
        self._changes = np.stack(
            [self._parts(change) for change in (-slope_along, -slope_across, strip, one)], axis=2
        )  # (K, R w, 4)
        information = np.einsum("kna,knb->kab", self._changes, self._changes)
        information[:, (0, 1), (0, 1)] += _LIGHT
        information[:, (2, 3), (2, 3)] += 1e-3
        inverse = np.linalg.inv(information)
        self._solver = np.einsum("kab,knb->kan", inverse, self._changes)
        self._unit = np.sqrt(inverse[:, (0, 1), (0, 1)])  # (K, 2) errors where noise is one level
        pixels = np.arange(strip.shape[1], dtype=np.float32)
        moved = [
            np.array([np.interp(pixels + marks * self._spacing, pixels, row) for row in strip])
            for marks in (0, 1, -1)
        ]
        shapes = np.stack([self._along(self._parts(one)) for one in moved])
        self._shapes = shapes / (np.linalg.norm(shapes, axis=2, keepdims=True) + 1e-6)

    def _seen(self, picture: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The strip of the tape (R, W), as it has moved, and which columns (W,) are seen."""
        u = self._place / self._half
        place = self._place + values[SHIFT] + values[STRETCH] * u + values[BEND] * u**2
        row = self._row + (values[ACROSS] + values[TURN] * u)
        cosine, sine = np.cos(np.radians(self._turn)), np.sin(np.radians(self._turn))
        x = np.float32(self._middle[0]) + cosine * place - sine * row
        y = np.float32(self._middle[1]) + sine * place + cosine * row
        height, width = picture.shape
        top, bottom = np.clip([int(y.min()) - 1, int(y.max()) + 3], 0, height)
        if bottom - top < 2:
            return np.zeros_like(y), np.zeros(width, bool)
        window = picture[top:bottom].astype(np.float32)
        strip = cv2.remap(
            window, x.astype(np.float32), (y - top).astype(np.float32), cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        inside = (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)
        return strip, inside.all(axis=0)

    def _from(self, picture: np.ndarray, start: np.ndarray) -> tuple[Motion, float, bool]:
        """Where the tape is near a start, how alike it is, and whether a mark off it is more so."""
        values, errors = start, np.full(5, np.nan)
        for _ in range(_STEPS):
            strip, seen = self._seen(picture, values)
            step, errors, likeness, mistaken = self._step(strip, seen)
            values = values + step
            if not np.abs(step).sum() > _NEAR:
                break
        return Motion(values, errors), likeness if np.isfinite(step).all() else 0.0, mistaken

    def _step(
        self, strip: np.ndarray, seen: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, float, bool]:
        """How far off (5,) the strip is, the errors, how alike it is, if by a mark it is more."""
        parts = self._parts(strip)
        shown = self._parts(seen[np.newaxis]).all(axis=1)
        varying = self._along(parts)
        alike = np.einsum("skn,kn->sk", self._shapes, varying)  # (3, K)
        alike /= np.linalg.norm(varying, axis=1) + 1e-6
        likeness = alike[:, shown].mean(axis=1) if shown.any() else np.zeros(3)
        fit = np.einsum("kan,kn->ka", self._solver, parts)
        left = parts - np.einsum("kna,ka->kn", self._changes, fit)
        noise = np.sqrt((left**2).mean(axis=1) * _FRAMES_ALIKE) + 0.1
        light = np.maximum(fit[:, 2], _DARKEST)
        shift, error = fit[:, :2] / light[:, np.newaxis], self._unit * (noise / light)[:, None]
        whole = ((parts - parts.mean(axis=1, keepdims=True)) ** 2).sum(axis=1) + 1e-6
        explained = 1 - (left**2).sum(axis=1) / whole
        good = shown & (fit[:, 2] > _DARKEST) & (explained > _ALIKE**2)
        good &= np.abs(shift[:, 0]) < self._spacing / 2
        step, errors = np.zeros(5), np.full(5, np.nan)
        if good.sum() >= 3:
            for axis, terms in ((0, (SHIFT, STRETCH, BEND)), (1, (ACROSS, TURN))):
                powers = self._u[:, np.newaxis] ** np.arange(len(terms))
                answer = _robust(powers[good], shift[good, axis], error[good, axis])
                step[list(terms)], errors[list(terms)] = answer
        return step, errors, float(likeness[0]), bool(likeness[0] < likeness[1:].max())

    def _wide(self, picture: np.ndarray) -> Iterator[np.ndarray]:
        """Where in the whole picture the tape may be: at a place, or a mark beside it."""
        turned = tape.straightened(picture, self._turn)[0]
        # What the margins cannot show is unlike the tape, so the nearest of alike places counts.
        margin = turned.shape[1] // 4
        turned = cv2.copyMakeBorder(turned, 0, 0, margin, margin, cv2.BORDER_REPLICATE)
        likeness = cv2.matchTemplate(turned, self._strip, cv2.TM_CCOEFF_NORMED)
        row, column = np.unravel_index(np.argmax(likeness), likeness.shape)
        for marks in (0, 1, -1):
            shift = column - margin + marks * self._spacing
            for bend in (_SWING * shift, 0.0):  # a camera that is turned, or moved aside
                yield np.array([shift, 0.0, bend, row - self._top, 0.0])


def settled(values: np.ndarray, errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Motions (T, 5) and their errors, without what is only noise.

    The more the motions vary, compared with their errors, the more they count. Frames in which the
    tape is not seen are taken to lie between those before and after.
    """
    seen = np.isfinite(values[:, 0])
    if not seen.any():
        return np.zeros_like(values), np.zeros_like(values)
    frames = np.arange(len(values))
    filled, known = np.empty_like(values), np.empty_like(values)
    before = np.clip(np.searchsorted(np.flatnonzero(seen), frames, "right") - 1, 0, None)
    after = np.clip(before + 1, None, seen.sum() - 1)
    for term in range(5):
        kept = values[seen, term]
        noise = float(np.mean(errors[seen, term] ** 2))
        signal = max(0.0, float(kept.var()) - noise)
        weight = signal / (signal + noise + 1e-12)
        middle = float(np.median(kept))
        kept = middle + weight * (kept - middle)
        filled[:, term] = np.interp(frames, np.flatnonzero(seen), kept)
        known[:, term] = np.sqrt(weight * noise)
        known[~seen, term] += np.abs(kept[after] - kept[before])[~seen] / 2
    return filled, known


def _slope(light: np.ndarray) -> np.ndarray:
    """Derivative along the rows: of fourth order, as marks may be five pixels apart."""
    padded = np.pad(light, ((0, 0), (2, 2)), mode="edge")
    near, far = padded[:, 3:-1] - padded[:, 1:-3], padded[:, 4:] - padded[:, :-4]
    return (8 * near - far) / 12


def _robust(
    powers: np.ndarray, shift: np.ndarray, error: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of a polynomial through shifts, without outliers, and their errors."""
    weight = 1 / error**2
    for _ in range(3):
        inverse = np.linalg.inv((powers.T * weight) @ powers + 1e-9 * np.eye(powers.shape[1]))
        values = inverse @ (powers.T @ (weight * shift))
        off = np.abs(shift - powers @ values)
        spread = max(1.4826 * float(np.median(off / error)), 1.0)
        outlier = off > _OUTLIER * spread * error
        weight = np.where(outlier, 1e-6, 1 / error**2)
        if not outlier.any():
            break
    return values, spread * np.sqrt(np.diag(inverse))

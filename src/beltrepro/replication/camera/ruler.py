"""Metres along the belt at a place in the picture: a projective map that follows the marks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from beltrepro.base.errors import InputError
from beltrepro.replication.camera.tape import WIDE_GAP, Tape

# What cameras are like, where few marks tell little: tilts of some degrees, lenses that move the
# end of the picture by some hundredths. One standard deviation of c and k.
_TILT, _LENS = 0.05, 0.02
_ALIKE = 4  # neighbouring marks that share their error
_LEAST = 0.005  # error of a mark's place, in their distances
# Other numbers that are tried beyond a wide gap; the best must fit so many times better than the
# next one.
_SHIFTS, _CLEAR = range(-5, 6), 2.0
_FOCAL = 1.6  # focal length of a phone's camera in half widths of the picture


@dataclass(frozen=True, eq=False)
class Ruler:
    """The number of marks n = (a v + b) / (c v + 1) at v = u + k u^3.

    u is the place along the belt from the middle of the picture, in half widths. The fraction is
    what a camera sees that looks along any direction, and k is the distortion of its lens.
    """

    half_width: float  # pixels
    values: np.ndarray  # (4,) a, b, c, k
    covariance: np.ndarray  # (4, 4) of their errors
    spacing_m: float  # metres from mark to mark
    first_m: float  # what the tape reads at the first mark
    residuals: np.ndarray  # (M,) of the marks, in their distances

    @classmethod
    def of(cls, tape: Tape, width: int, spacing_m: float, first_m: float) -> Ruler:
        """The ruler that follows the marks of a tape; refuses one with a gap too wide to count."""
        half = width / 2
        places, gap = tape.places / half, np.diff(tape.numbers)
        beyond = np.arange(len(places)) > int(np.argmax(gap))
        shifts = _SHIFTS if gap.max() > WIDE_GAP else (0,)
        fits = [
            _fitted(places, tape.numbers + shift * beyond, half / tape.spacing) for shift in shifts
        ]
        fits.sort(key=lambda fit: fit[2])
        values, residuals, error = fits[0]
        if len(fits) > 1 and fits[1][2] < _CLEAR * error:
            raise InputError(
                f"{gap.max() - 1:.0f} marks of the tape are hidden side by side, too many to "
                f"count: uncover the tape"
            )
        information = _slopes(values, places) / (error * np.sqrt(_ALIKE))
        prior = np.diag([0.0, 0.0, _TILT**-2, _LENS**-2])
        covariance = np.linalg.inv(information.T @ information + prior)
        return cls(half, values, covariance, spacing_m, first_m, residuals)

    @classmethod
    def even(cls, metres_per_pixel: float, width: int, edge_m: float) -> Ruler:
        """A ruler without a tape, which reads `edge_m` at the left edge of the picture."""
        half = width / 2
        values = np.array([half, half - 0.5, 0.0, 0.0])  # the edge is the middle of the first pixel
        none = np.full((4, 4), np.nan)
        return cls(half, values, none, metres_per_pixel, edge_m, np.empty(0))

    def with_scale(self, metres_per_pixel: float) -> Ruler:
        """The same with another scale in the middle of the picture."""
        factor = metres_per_pixel / self.metres_per_pixel
        return replace(self, spacing_m=factor * self.spacing_m)

    def metres(self, place: np.ndarray) -> np.ndarray:
        """What the ruler reads at places in pixels from the middle of the picture."""
        return self.first_m + self.spacing_m * _numbers(self.values, place / self.half_width)

    def slopes(self, place: np.ndarray) -> np.ndarray:
        """Changes (T, 4) of what it reads with a, b, c, k."""
        return self.spacing_m * _slopes(self.values, place / self.half_width)

    def scale(self, place: np.ndarray) -> np.ndarray:
        """Metres per pixel at places."""
        return (self.metres(place + 0.5) - self.metres(place - 0.5)) / 1.0

    def scale_across(self, place: np.ndarray) -> np.ndarray:
        """Metres per pixel across the belt at places, where nothing is seen obliquely."""
        a, b, c, k = self.values
        u = place / self.half_width
        scale = self.spacing_m * (a - b * c) / self.half_width
        return scale * (1 + k * u**2) / (1 + c * (u + k * u**3))

    @property
    def metres_per_pixel(self) -> float:
        """Scale in the middle of the picture."""
        return float(self.scale(np.zeros(1))[0])

    @property
    def distance_m(self) -> float:
        """From the camera to the tape, if its lens is that of a phone."""
        return _FOCAL * self.half_width * self.metres_per_pixel

    @property
    def tilt(self) -> float:
        """Degrees by which the camera is tilted along the belt, if its lens is that of a phone."""
        return float(np.degrees(np.arctan(self.values[2] * _FOCAL)))

    @property
    def misfit(self) -> float:
        """How far the marks lie off the map, as a share of their distance."""
        return float(np.sqrt(np.mean(self.residuals**2))) if self.residuals.size else np.nan

    def places(self, numbers: np.ndarray) -> np.ndarray:
        """Where the map has marks of these numbers, pixels from the middle."""
        pixels = np.linspace(-1.2, 1.2, 2401)
        return self.half_width * np.interp(numbers, _numbers(self.values, pixels), pixels)


def _fitted(
    places: np.ndarray, numbers: np.ndarray, density: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """The map (4,) through marks of given numbers, their residuals, and the scatter of these."""

    def misfits(values: np.ndarray) -> np.ndarray:
        """Those of the marks in units of their error, and what makes a camera unusual."""
        marks = (numbers - _numbers(values, places)) / (error * np.sqrt(_ALIKE))
        return np.append(marks, [values[2] / _TILT, values[3] / _LENS])

    start = np.array([density, 0.0, 0.0, 0.0])
    start[1] = np.median(numbers - density * places)
    error = 0.05
    for _ in range(2):  # the scatter of the marks is their error
        values = scipy.optimize.least_squares(misfits, start, loss="soft_l1").x
        residuals = numbers - _numbers(values, places)
        error = max(_LEAST, 1.4826 * float(np.median(np.abs(residuals))))
    return values, residuals, error


def _numbers(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Marks from the first one to places in half widths."""
    a, b, c, k = values
    seen = places + k * places**3
    return (a * seen + b) / (1 + c * seen)


def _slopes(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Derivatives (M, 4) of these numbers by a, b, c and k."""
    a, b, c, k = values
    seen = places + k * places**3
    below = 1 + c * seen
    number = (a * seen + b) / below
    by_seen = (a - c * number) / below
    return np.column_stack([seen, np.ones_like(seen), -number * seen, by_seen * places**3]) / (
        np.column_stack([below, below, below, np.ones_like(below)])
    )

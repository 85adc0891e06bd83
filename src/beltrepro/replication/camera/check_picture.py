"""A picture by which somebody sees whether a film was measured right.

Above a frame with the marks of the tape, every tenth with its number, the zero and the white block;
below how far each mark lies from where the camera's map has it.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from beltrepro.base.atomic import replacing
from beltrepro.replication.camera.survey import Survey

SUFFIX = ".check.png"
_WIDEST = 1600  # pixels up to which a frame is enlarged
_MARK, _ZERO, _BLOCK = (60, 170, 0), (40, 40, 230), (220, 120, 0)  # blue, green, red
_PANEL = 120  # rows of the residuals, of marks up to a quarter of their distance away
_REACH = 0.25


def write(survey: Survey, path: Path) -> None:
    """Write the picture of a survey as PNG."""
    frame = survey.frame
    enlarged = max(1, _WIDEST // frame.shape[1])
    page = cv2.cvtColor(
        cv2.resize(frame, None, fx=enlarged, fy=enlarged, interpolation=cv2.INTER_NEAREST),
        cv2.COLOR_GRAY2BGR,
    )
    sheet = _Sheet(survey, page, enlarged)
    sheet.marks()
    sheet.line(survey.zero, 2.0, _ZERO, "0")
    sheet.block()
    rows = np.vstack([page, _residuals(survey, page.shape[1], enlarged)])
    content = cv2.imencode(".png", rows)[1].tobytes()
    with replacing(path) as part:
        part.write_bytes(content)


class _Sheet:
    """The enlarged frame, drawn on at places along and across the belt."""

    def __init__(self, survey: Survey, page: np.ndarray, enlarged: int) -> None:
        self._survey, self._page, self._enlarged = survey, page, enlarged

    def _pixel(self, along: float, across: float) -> tuple[int, int]:
        x, y = self._survey.in_picture(along, across)
        return round(self._enlarged * (x + 0.5)), round(self._enlarged * (y + 0.5))

    def line(self, along: float, blocks: float, colour: tuple, word: str) -> None:
        """A line across the belt at the tape, so many widths of the block long, and a word."""
        survey = self._survey
        middle = survey.measure.line if survey.measure else survey.across_belt(survey.block)
        half = blocks * survey.across / 2
        near, far = (self._pixel(along, middle + sign * half) for sign in (-1, 1))
        cv2.line(self._page, near, far, colour, 1)
        if word:
            x, y = self._pixel(along, middle - half)
            _write(self._page, word, (x + 2, min(max(y, 12), self._page.shape[0] - 4)), colour)

    def marks(self) -> None:
        """Marks that were seen; every tenth is longer and has its number."""
        survey = self._survey
        if survey.measure is None:
            return
        for place, number in zip(survey.measure.places, survey.measure.numbers, strict=True):
            tenth = number % 10 == 0
            self.line(place, 0.4 if tenth else 0.1, _MARK, f"{number:.0f}" if tenth else "")

    def block(self) -> None:
        """The outline of the white block."""
        survey, block = self._survey, self._survey.block
        middle = survey.along_belt(block), survey.across_belt(block)
        sides = survey.along / 2, survey.across / 2
        corners = [
            self._pixel(middle[0] + one * sides[0], middle[1] + other * sides[1])
            for one, other in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        cv2.polylines(self._page, [np.array(corners, np.int32)], True, _BLOCK, 1)


def _residuals(survey: Survey, width: int, enlarged: int) -> np.ndarray:
    """A panel (rows, W, 3) with a bar for each mark, below the mark."""
    panel = np.full((_PANEL, width, 3), 255, np.uint8)
    cv2.line(panel, (0, _PANEL // 2), (width, _PANEL // 2), (180, 180, 180), 1)
    ruler = survey.ruler
    if survey.measure is None:
        _write(panel, "no tape: scale and zero are those that were given", (6, 16), (0,) * 3)
        return panel
    for place, residual in zip(survey.measure.places, ruler.residuals, strict=True):
        x = round(enlarged * (survey.in_picture(place, survey.measure.line)[0] + 0.5))
        high = round(_PANEL / 2 * (1 - np.clip(residual / _REACH, -1, 1)))
        cv2.line(panel, (x, _PANEL // 2), (x, high), _MARK, max(1, enlarged))
    reach, misfit = 1e3 * _REACH * ruler.spacing_m, 1e3 * ruler.misfit * ruler.spacing_m
    words = (
        f"marks beside the map of the camera, from -{reach:.3g} to {reach:.3g} mm; "
        f"rms {misfit:.2g} mm; tilt {ruler.tilt:.1f} degrees"
    )
    _write(panel, words, (6, 16), (0,) * 3)
    return panel


def _write(page: np.ndarray, words: str, place: tuple[int, int], colour: tuple) -> None:
    cv2.putText(page, words, place, cv2.FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv2.LINE_AA)

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
_MARK, _ZERO, _BLOCK = (60, 170, 0), (40, 40, 230), (220, 120, 0)  # green, red, blue
_PANEL = 120  # rows of the residuals, of marks up to a quarter of their distance away
_REACH = 0.25


def write(survey: Survey, path: Path) -> None:
    """Write the picture of a survey as PNG."""
    height, width = survey.frame.shape
    enlarged = max(1, _WIDEST // width)
    size = enlarged * width, enlarged * height
    frame = cv2.resize(survey.frame, size, interpolation=cv2.INTER_NEAREST)
    page = np.vstack([frame, np.full((_PANEL, size[0]), 255, np.uint8)])
    page = cv2.cvtColor(page, cv2.COLOR_GRAY2BGR)
    level = size[1] + _PANEL // 2  # row of a mark that lies on the map
    cv2.line(page, (0, level), (size[0], level), (180, 180, 180), 1)

    def pixel(along: float, across: float) -> tuple[int, int]:
        x, y = survey.in_picture(along, across)
        return round(enlarged * (x + 0.5)), round(enlarged * (y + 0.5))

    def write_words(words: str, place: tuple[int, int], colour: tuple[int, ...]) -> None:
        cv2.putText(page, words, place, cv2.FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv2.LINE_AA)

    def draw_line(place: float, blocks: float, colour: tuple[int, ...], word: str) -> None:
        """A line across the belt at the tape, so many widths of the block long, and a word."""
        middle = survey.measure.line if survey.measure else survey.across_belt(survey.block)
        near, far = (pixel(place, middle + side * blocks * survey.across / 2) for side in (-1, 1))
        cv2.line(page, near, far, colour, 1)
        write_words(word, (near[0] + 2, min(max(near[1], 12), size[1] - 4)), colour)

    words = "no tape: scale and zero are those that were given"
    if measure := survey.measure:
        ruler, residuals = survey.ruler, survey.ruler.residuals
        for place, number, off in zip(measure.places, measure.numbers, residuals, strict=True):
            tenth = number % 10 == 0
            draw_line(place, 0.4 if tenth else 0.1, _MARK, f"{number:.0f}" if tenth else "")
            x = pixel(place, measure.line)[0]
            high = level - round(_PANEL / 2 * np.clip(off / _REACH, -1, 1))
            cv2.line(page, (x, level), (x, high), _MARK, max(1, enlarged))
        reach, misfit = 1e3 * _REACH * ruler.spacing_m, 1e3 * ruler.misfit * ruler.spacing_m
        words = (
            f"marks beside the map of the camera, from -{reach:.3g} to {reach:.3g} mm; "
            f"rms {misfit:.2g} mm; tilt {ruler.tilt:.1f} degrees"
        )
    write_words(words, (6, size[1] + 16), (0, 0, 0))
    draw_line(survey.zero, 2.0, _ZERO, "0")
    along, across = survey.along_belt(survey.block), survey.across_belt(survey.block)
    corners = [
        pixel(along + one * survey.along / 2, across + other * survey.across / 2)
        for one, other in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    cv2.polylines(page, [np.array(corners, np.int32)], True, _BLOCK, 1)
    with replacing(path) as part:
        part.write_bytes(cv2.imencode(".png", page)[1].tobytes())

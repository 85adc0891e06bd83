"""The ruler against the optics of a tilted camera, and the marks that are longer."""

import numpy as np
import pytest

from beltrepro.replication.camera import tape
from beltrepro.replication.camera.ruler import Ruler

FOCAL, DISTANCE = 1500.0, 2.0  # pixels; metres from the camera to the tape


@pytest.mark.parametrize("tilt", [-8.0, 0.0, 5.0])
@pytest.mark.parametrize(("half", "spacing"), [(960.0, 0.01), (400.0, 0.002)])
def test_scales_of_a_tilted_camera(tilt, half, spacing):
    slope = np.tan(np.radians(tilt))
    wide = half / FOCAL

    def along(place):  # where the ray through a place of the picture meets the tape
        ray = place / FOCAL
        return DISTANCE * ray / (np.cos(np.radians(tilt)) * (1 - ray * slope))

    values = np.array(
        [DISTANCE * wide / np.cos(np.radians(tilt)) / spacing, 30.0, -wide * slope, 0]
    )
    values[0] += values[1] * values[2]  # 30 marks to the left of the middle
    ruler = Ruler(half, values, np.zeros((4, 4)), spacing, 0.25, np.array([0.03, -0.01, 0.02]))
    place = np.linspace(-half, half, 7)
    np.testing.assert_allclose(ruler.metres(place), 0.25 + 30 * spacing + along(place), rtol=1e-12)
    step = along(place + 0.5) - along(place - 0.5)
    np.testing.assert_allclose(ruler.scale(place), step, rtol=1e-9)
    depth = DISTANCE + along(place) * np.sin(np.radians(tilt))
    np.testing.assert_allclose(ruler.scale_across(place), depth / FOCAL, rtol=0.011)
    np.testing.assert_allclose(
        ruler.scale_across(place) / ruler.scale_across(place)[3], depth / DISTANCE, rtol=1e-9
    )
    assert ruler.misfit == pytest.approx(np.sqrt(14e-4 / 3))
    np.testing.assert_allclose(
        ruler.places((ruler.metres(place) - 0.25) / spacing), place, atol=0.5
    )


def picture(numbers, spacing, first, every, hidden):
    """Dark marks at the top, of which every tenth or fifth reaches down into the rows beside."""
    turned = np.full((60, int(spacing * (numbers[-1] + 3))), 200.0)
    for number in numbers:
        middle = round(spacing * (number + 1))
        low = 40 if (number - first) % every == 0 else 20
        if number not in hidden:
            turned[:low, middle - 1 : middle + 2] = 20.0
    return turned


@pytest.mark.parametrize(("first", "every"), [(0, 10), (7, 10), (4, 5), (2, 5)])
@pytest.mark.parametrize("miscounted", [0, 3])
def test_longer_marks_are_every_tenth_or_fifth(first, every, miscounted):
    numbers, spacing, hidden = np.arange(90), 12.0, range(45, 60)
    turned = picture(numbers, spacing, first, every, hidden)
    seen = np.array([number for number in numbers if number not in hidden])
    counted = seen + np.where(seen > 50, miscounted, 0)  # beyond a wide gap the count may be wrong
    places = np.round(spacing * (seen + 1))
    assert tape._long_marks(turned, slice(0, 20), places, counted, spacing) == (first, every)
    assert tape._long_marks(turned, slice(0, 20), places[:15], counted[:15], spacing) is None


def test_no_mark_is_longer():
    numbers, spacing = np.arange(40), 12.0
    turned = picture(numbers, spacing, 0, 100, ())
    turned[20:] = 200.0
    places = spacing * (numbers + 1)
    assert tape._long_marks(turned, slice(0, 20), places, numbers, spacing) is None


@pytest.mark.parametrize("miscounted", [-3, 0, 4])
@pytest.mark.parametrize("gaps", [((20, 32), (50, 52)), ((9, 11), (60, 71))])
def test_the_count_beyond_a_wide_gap_is_the_one_that_fits(miscounted, gaps):
    numbers = np.array([n for n in range(100) if not any(a <= n < b for a, b in gaps)])
    shift = 0.12 / 50  # of the map c, what a tilt makes: far marks are closer together
    places = 12.0 * (numbers - 50) / (1 + shift * (numbers - 50))
    places += 0.02 * np.sin(7.0 * numbers)
    begin, end = max(gaps, key=lambda gap: gap[1] - gap[0])
    counted = numbers + np.where(numbers >= end, miscounted, 0)
    seen = tape.Tape(0.0, slice(0, 20), 10.0, places, counted, 12.0, 9.0, True, None)
    ruler = Ruler.of(seen, 1400, 0.01, 0.1)
    np.testing.assert_allclose(ruler.metres(places), 0.1 + 0.01 * numbers, atol=2e-4)
    assert ruler.misfit < 0.02 and end - begin > tape.WIDE_GAP

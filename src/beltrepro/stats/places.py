"""Numbers of runs at several places, as belt velocities: the places scatter, too."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from beltrepro.stats.estimates import Estimate, bootstrap, mean, share_of

PART = 0.5  # of an axis of u: velocities that are so near are often in one window


def part_of(place: np.ndarray) -> np.ndarray:
    """The upper end of the part of the axis in which each place lies."""
    return np.ceil(place / PART - 1e-9) * PART


def over_places(
    statistic: Callable[[np.ndarray], float], place: np.ndarray, values: np.ndarray
) -> Estimate:
    """Statistic of runs at several places, which are drawn anew with all their runs.

    Runs at one place often end alike, and neighbouring places may have other attractors.
    """
    at_each = [values[place == one] for one in np.unique(place)]
    return bootstrap(
        lambda drawn: statistic(np.concatenate([at_each[index] for index in drawn])),
        [np.arange(len(at_each))],
    )


def share_over(place: np.ndarray, having: np.ndarray) -> Estimate:
    """Share of runs over a range of places, of equally many at each.

    Its interval covers that of so many runs, and that of the mean of so many places.
    """
    runs = share_of(having)
    places = np.unique(place)
    if places.size < 2:
        return runs
    between = mean([having[place == one].mean() for one in places])
    low, high = max(0.0, min(runs.low, between.low)), min(1.0, max(runs.high, between.high))
    return replace(runs, low=low, high=high)

"""Transitions of r with their intervals, from independent runs at each point."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from beltrepro.stats import estimates, transitions
from beltrepro.stats.errors import require
from beltrepro.stats.estimates import Estimate, from_resamples
from beltrepro.stats.transitions import Transition

LEAST_RUNS = 4
QUANTITIES = ("critical", "lower", "upper", "width", "r_high", "r_low", "contrast")
ON_THE_GRID = ("critical", "lower", "upper", "width")
Finder = Callable[[np.ndarray, np.ndarray], Transition]


def fall(
    belt_velocity: np.ndarray, disorder: np.ndarray, *, smoothing: float = 0.0, **options: float
) -> dict[str, Estimate]:
    """The fall of r along u: edges, midpoint, width, plateaus and their ratio, as estimates.

    The runs at each u have a median of their own. A median over a window in u, which single runs
    need, draws the fall towards where the points are dense.
    """

    def find(places: np.ndarray, values: np.ndarray) -> Transition:
        return transitions.transition_region(
            places, values, smoothing=smoothing, bootstrap=0, **options
        )

    return _estimates(belt_velocity, disorder, find)


def rise(noise: np.ndarray, disorder: np.ndarray, **options: float) -> dict[str, Estimate]:
    """The rise of r along sigma, as `fall`; options of `transitions.critical_noise`."""

    def find(places: np.ndarray, values: np.ndarray) -> Transition:
        return transitions.critical_noise(places, values, bootstrap=0, **options)

    return _estimates(noise, disorder, find)


def _estimates(places: np.ndarray, values: np.ndarray, find: Finder) -> dict[str, Estimate]:
    """Runs are drawn anew at each place by itself, since those of two places are independent."""
    order = np.argsort(places, kind="stable")
    places, values = places[order], values[order]
    distinct, first, count = np.unique(places, return_index=True, return_counts=True)
    least = int(count.min())
    require(least >= LEAST_RUNS, f"{least} runs at a point, {LEAST_RUNS} are needed")
    rng = np.random.default_rng(0)
    begin, size = np.repeat(first, count), np.repeat(count, count)
    samples = [
        find(places, values[begin + (rng.random(values.size) * size).astype(int)])
        for _ in range(estimates.RESAMPLES)
    ]
    best = find(places, values)
    spacing = _spacing(distinct, best)
    return {
        name: from_resamples(
            float(getattr(best, name)),
            np.array([getattr(each, name) for each in samples], dtype=float),
            least,
            grid_spacing=spacing if name in ON_THE_GRID else 0.0,
        )
        for name in QUANTITIES
    }


def _spacing(places: np.ndarray, found: Transition) -> float:
    """Median distance of the points in and next to the transition."""
    if not found.found:
        return 0.0
    first = max(int(np.searchsorted(places, found.lower)) - 1, 0)
    last = int(np.searchsorted(places, found.upper, side="right")) + 1
    return float(np.median(np.diff(places[first:last])))

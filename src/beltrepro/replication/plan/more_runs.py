"""Runs added to the replicates of a point until the mean over them is known well enough.

At each point stands the half-width of the 95 % interval (Student's t) of the mean of one recorded
number over the runs there. Where it is larger than allowed, at the point itself or at a neighbour,
the point gets more runs. Neighbours count because near a transition runs end on one of two
branches: eight runs that happen to agree seem precise, and to stop there would draw the point to
the branch they are on.
"""

import math
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from beltrepro.replication.plan.points import Point
from beltrepro.stats import estimates


class MoreRuns(NamedTuple):
    """When a point gets more runs, and how many."""

    by: int  # in a round
    up_to: int  # runs at a point, at most
    of: str  # name of the recorded number
    half_width: float  # largest allowed, in its unit
    along: str  # the quantity along which points are neighbours

    def rounds(self, runs: int) -> list[int]:
        """How many runs a point that has so many gets in each round, at most."""
        return [min(self.by, self.up_to - count) for count in range(runs, self.up_to, self.by)]


def place_of(point: Point) -> Point:
    """The point without its replicate."""
    return point._replace(replicate=0)


def rows(points: Sequence[Point], along: str) -> list[list[Point]]:
    """Places that differ in this quantity alone, all or none of them with noise."""
    table: dict[tuple, list[Point]] = {}
    for place in dict.fromkeys(map(place_of, points)):
        rest = place._replace(**{along: 0})  # type: ignore[arg-type]
        table.setdefault((rest, place.noise > 0), []).append(place)
    return [sorted(row, key=lambda place: getattr(place, along)) for row in table.values()]


def half_width(values: np.ndarray) -> float:
    """Half the width of the 95 % interval of the mean of independent values (`estimates.mean`)."""
    if not len(values) > 1 or not np.all(np.isfinite(values)):
        return math.inf
    mean = estimates.mean(values)
    return mean.high - mean.value


def wanted(
    planned: Sequence[Point], runs: Sequence[Point], values: Sequence[float], rule: MoreRuns
) -> list[Point]:
    """The runs to add to those that there are.

    planned : whose places count, and no others. values : the number recorded of each of `runs`.
    """
    at: dict[Point, list[tuple[int, float]]] = {place_of(point): [] for point in planned}
    for point, value in zip(runs, values, strict=True):
        if place_of(point) in at:
            at[place_of(point)].append((point.replicate, value))
    more = []
    for row in rows(planned, rule.along):
        widths = [half_width(np.array([value for _, value in at[place]])) for place in row]
        for number, place in enumerate(row):
            if max(widths[max(number - 1, 0) : number + 2]) <= rule.half_width:
                continue
            first = 1 + max(replicate for replicate, _ in at[place])
            count = min(rule.by, rule.up_to - len(at[place]))
            more += [place._replace(replicate=first + run) for run in range(count)]
    return more


def runs_at_places(points: Sequence[Point]) -> str:
    """How many runs there are at the places of these points, in words."""
    places_with = sorted(Counter(Counter(map(place_of, points)).values()).items())
    return ", ".join(f"{runs} runs at {places} places" for runs, places in places_with)

"""Runs whose motion is named, or that were followed until it settled: shares and exponents.

Irregular motion may end after any time. Here it counts as lasting if it is seen for LONG. Runs that
are given up before, and those without an exponent above zero, are open: longer runs may show
either, and the interval of a share covers both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beltrepro.base.errors import require
from beltrepro.replication.verdicts.evidence import Evidence
from beltrepro.stats import estimates
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.motion import CHAOTIC, PERIODIC, TRANSIENT, above_zero

N_BLOCKS = 5
LONG = 1e5  # ten times the longest mean lifetime of a transient that the paper allows
SETTLING = ("survival_long", "survival_many", "survival")  # the first with runs at a point serves
MINIMUM_EXPONENTS = 3


@dataclass(frozen=True)
class Motions:
    """What motion runs were found in at their end."""

    names: np.ndarray  # one of `motion.MOTIONS` each (R,)
    returns: np.ndarray  # to the mean length in a period (R,), 0 if the orbit does not close
    long: np.ndarray  # which runs were followed for LONG (R,)

    @property
    def open(self) -> np.ndarray:
        """Which runs are irregular, and may not be for long (R,)."""
        return (self.names == TRANSIENT) | ((self.names == CHAOTIC) & ~self.long)

    def share(self, name: str) -> Estimate:
        """Share of the runs with a motion of this name."""
        named = (self.names == name) & ~self.open
        return estimates.share(int(named.sum()), self.names.size, int(self.open.sum()))

    def where(self, chosen: np.ndarray) -> Motions:
        """Some of the runs."""
        return Motions(**{name: column[chosen] for name, column in vars(self).items()})

    def and_also(self, others: Motions) -> Motions:
        """These runs and others."""
        pairs = zip(vars(self).values(), vars(others).values(), strict=True)
        return Motions(*map(np.concatenate, pairs))

    @property
    def words(self) -> str:
        """How many runs have each name, and how many are open."""
        counts = zip(*np.unique(self.names, return_counts=True), strict=True)
        text = ", ".join(f"{count} {name}" for name, count in counts)
        return f"{text} ({self.open.sum()} of {self.names.size} are open)"


def motions(evidence: Evidence, n_blocks: int, low: float = 0.0, high: float = np.inf) -> Motions:
    """Runs of `motion_map` of so many blocks with low <= u <= high."""
    arrays, attributes = evidence.runs("motion_map", n_blocks=n_blocks)
    names = arrays["state"].astype(str)
    long = np.full(names.size, attributes["duration"] >= LONG)
    runs = Motions(names, arrays["period_returns"], long).where(
        between(arrays["belt_velocity"], low, high)
    )
    require(runs.names.size, f"no runs with N = {n_blocks}, {low:g} <= u <= {high:g}")
    return runs


def settled_motions(evidence: Evidence, low: float, high: float, spread: float) -> Motions:
    """Runs of `survival` of five blocks with low <= u <= high from starts with this spread."""
    arrays, attributes = evidence.runs("survival", n_blocks=N_BLOCKS, initial_spread=spread)
    exponent, error, time = (arrays[f"irregular_{name}"] for name in ("exponent", "error", "time"))
    irregular = np.where(above_zero(exponent, error, time), CHAOTIC, TRANSIENT)
    names = np.where(arrays["settled"].astype(bool), arrays["state"].astype(str), irregular)
    long = np.full(names.size, attributes["duration"] >= LONG)
    return Motions(names, arrays["period_returns"], long).where(
        between(arrays["belt_velocity"], low, high)
    )


def between(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Mask of low <= value <= high, to the rounding of a grid."""
    return (values >= low - 1e-9) & (values <= high + 1e-9)


@dataclass(frozen=True)
class Settling:
    """Runs from random starts at one point, followed until they settled or were given up; (R,)."""

    lifetime: np.ndarray
    settled: np.ndarray
    state: np.ndarray
    exponents: np.ndarray  # of the irregular motion; NaN where it was too short
    duration: float

    def irregular_for(self, time: float) -> Estimate:
        """Share of the runs that are irregular for a time or longer."""
        lasting = self.lifetime >= time
        still_open = ~lasting & ~self.settled
        return estimates.share(int(lasting.sum()), lasting.size, int(still_open.sum()))

    @property
    def periodic(self) -> Estimate:
        """Share of the runs that end on a periodic orbit; those irregular for LONG do not."""
        periodic = self.settled & (self.state == PERIODIC)
        still_open = ~self.settled & (self.lifetime < LONG)
        return estimates.share(int(periodic.sum()), periodic.size, int(still_open.sum()))

    @property
    def exponent(self) -> Estimate:
        """Mean largest exponent of the irregular motion; absent if all settled too soon for one."""
        exponents = self.exponents[np.isfinite(self.exponents)]
        if exponents.size >= MINIMUM_EXPONENTS:
            return estimates.mean(exponents)
        require(self.settled.all(), f"{self.words}: longer runs are needed for an exponent")
        return estimates.absent(self.settled.size)

    @property
    def words(self) -> str:
        """How many runs settled, and after what time."""
        return (
            f"{self.settled.sum()} of {self.settled.size} runs settled within {self.duration:g}, "
            f"half of all by {np.median(self.lifetime):.0f}"
        )


def runs_from(evidence: Evidence, belt_velocity: float, spread: float) -> Settling:
    """Runs of five blocks from starts with this spread: the longest that there are."""
    arrays, attributes = evidence.runs(
        *SETTLING, n_blocks=N_BLOCKS, belt_velocity=belt_velocity, initial_spread=spread
    )
    return Settling(
        arrays["lifetime"],
        arrays["settled"].astype(bool),
        arrays["state"].astype(str),
        arrays["irregular_exponent"],
        float(attributes["duration"]),
    )


def by_spread(evidence, measure):
    """A reading for each spread of the starts that the claim names."""
    parameters = evidence.claim.parameters
    return {
        f"starts spread by {spread:g}": lambda spread=spread: measure(
            runs_from(evidence, parameters["belt_velocity"], spread)
        )
        for spread in parameters["initial_spread"]
    }

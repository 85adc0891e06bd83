"""Runs whose motion is named, and runs that were followed until it settled: what claims count.

Irregular motion may end after any time. Here it counts as lasting if it is seen for LONG. Runs that
are given up before, and those without an exponent above zero, are open: longer runs may show
either, and the interval of a share covers both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.verdicts.evidence import EXACT, SCHEME, Ends, Evidence
from beltrepro.stats import estimates, sections
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.motion import CHAOTIC, PERIODIC, STABLE_CHAOS, TRANSIENT, above_zero
from beltrepro.stats.places import part_of, share_over

N_BLOCKS = 5
LONG = 1e5  # ten times the longest mean lifetime of a transient that the paper allows
PERMANENT = 1e6  # which the paper discards before it looks
# The runs of each reading: of the exact dynamics, the first dataset with runs at a point serves.
SETTLING = {
    SCHEME: ("survival_scheme",),
    EXACT: ("survival_many", "survival_long", "survival"),
}
SPREADS = (7.0, 10.0)  # of their starts, which lie wide apart
MINIMUM_EXPONENTS = 3
# By the look of a diagram motion is periodic if it occupies so few bins, as an eye can tell apart;
# with fewer crossings it cannot be told.
FEW_VALUES, FEWEST_CROSSINGS = 20, 100


# --- runs of a given length -----------------------------------------------------------------------


def runs(
    evidence: Evidence, n_blocks: int, low: float = 0.0, high: float = np.inf, *, besides: str = ""
) -> pd.DataFrame:
    """Runs of so many blocks with low <= u <= high: their motion, its returns, what is open.

    At each u of `motion_map` there are as many as of the number of blocks that has the fewest: more
    runs find more orbits, and those at one u often end alike.

    besides : a dataset of kind settling, if there, whose runs count too. One that has not settled
    is chaotic by its exponent. Its starts have another spread, so that no run counts twice.
    """
    every = evidence.dataset("motion_map").arrays
    points = np.column_stack([every["n_blocks"], every["belt_velocity"]])
    fewest = np.unique(points, axis=0, return_counts=True)[1].min(initial=len(points))
    arrays, attributes = evidence.runs("motion_map", n_blocks=n_blocks)
    first = np.unique(every["replicate"])[:fewest]
    arrays = sections.select(arrays, np.isin(arrays["replicate"], first))
    named = _named(arrays["state"], arrays, attributes, low, high)
    require(len(named), f"no runs with N = {n_blocks}, {low:g} <= u <= {high:g}")
    if not evidence.has(besides):
        return named
    arrays, attributes = evidence.runs(besides, n_blocks=n_blocks, initial_spread=SPREADS)
    exponent = (arrays[f"irregular_{name}"] for name in ("exponent", "error", "time"))
    irregular = np.where(above_zero(*exponent), CHAOTIC, TRANSIENT)
    names = np.where(arrays["settled"].astype(bool), arrays["state"].astype(str), irregular)
    return pd.concat([named, _named(names, arrays, attributes, low, high)])


def _named(
    names: np.ndarray, arrays: dict, attributes: dict, low: float, high: float
) -> pd.DataFrame:
    names = names.astype(str)
    # may end like any other irregular motion without an exponent above zero, and counts as such
    names = np.where(names == STABLE_CHAOS, TRANSIENT, names)
    short = attributes["duration"] < LONG
    is_open = (names == TRANSIENT) | ((names == CHAOTIC) & short)
    runs = pd.DataFrame({"motion": names, "returns": arrays["period_returns"], "open": is_open})
    return runs[between(arrays["belt_velocity"], low, high)]


def share(runs: pd.DataFrame, motion: str) -> Estimate:
    """Share of the runs with a motion of this name."""
    return estimates.share_of((runs["motion"] == motion) & ~runs["open"], runs["open"])


def in_words(runs: pd.DataFrame) -> str:
    """How many runs have each motion, and how many are open."""
    counts = runs.groupby("motion").size().items()
    text = ", ".join(f"{count} {name}" for name, count in counts)
    return f"{text} ({runs['open'].sum()} of {len(runs)} are open)"


def looks(
    evidence: Evidence, n_blocks: int, low: float, high: float
) -> tuple[dict[str, Estimate], np.ndarray, str]:
    """Shares of a bifurcation diagram without noise that look chaotic and periodic.

    One run of the paper's scheme from the declared start at each u shows few values or many, in
    which a long period looks like chaos. Neighbouring velocities look alike: the intervals are over
    parts of the axis of u. Velocities with few values, too, and a note.
    """
    row = evidence.row(scan_of(n_blocks, "density"), n_blocks, 0.0).within(low, high)
    filled = sections.occupied_bins(row.points["section_histogram"], least=FEWEST_CROSSINGS)
    crossing = np.isfinite(filled)
    velocity, few = row.belt_velocity[crossing], filled[crossing] <= FEW_VALUES
    shares = {
        name: share_over(part_of(velocity), having)
        for name, having in ((CHAOTIC, ~few), (PERIODIC, few))
    }
    words = f"N = {n_blocks}: {crossing.sum()} of {crossing.size} velocities"
    return shares, velocity[few], words


def scan_of(n_blocks: int, kind: str) -> str:
    """Name of the scan that has rows of so many blocks, as "density" or "replicates"."""
    return f"{'n5' if n_blocks == N_BLOCKS else 'size'}_{kind}"


def between(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Mask of low <= value <= high, to the rounding of a grid."""
    return (values >= low - 1e-9) & (values <= high + 1e-9)


# --- runs that are followed until they settle -----------------------------------------------------


@dataclass(frozen=True)
class Settling:
    """Runs from random starts, followed until they settled or were given up."""

    arrays: dict[str, np.ndarray]  # of kind settling
    duration: float

    @classmethod
    def of(cls, evidence: Evidence, *names: str, **place: Ends) -> Settling:
        """Runs of five blocks from the first of the datasets that has some at this place."""
        place |= {"n_blocks": N_BLOCKS, "initial_spread": SPREADS}
        arrays, attributes = evidence.runs(*names, **place)
        arrays |= {"settled": arrays["settled"].astype(bool), "state": arrays["state"].astype(str)}
        return cls(arrays, float(attributes["duration"]))

    def where(self, chosen: np.ndarray) -> Settling:
        """Some of the runs."""
        return Settling(sections.select(self.arrays, chosen), self.duration)

    def irregular_for(self, time: float) -> Estimate:
        """Share of the runs that are irregular for a time or longer.

        Where all runs tell, its interval covers the scatter of velocities, too.
        """
        lasting = self.arrays["lifetime"] >= time
        if np.any(~lasting & ~self.arrays["settled"]):
            return estimates.share_of(lasting, ~self.arrays["settled"])
        return share_over(self.arrays["belt_velocity"], lasting)

    @property
    def ends_periodic(self) -> Estimate:
        """Share of the runs that end in periodic stick-slip; those irregular for LONG do not."""
        settled = self.arrays["settled"]
        sticks = (self.arrays["state"] == PERIODIC) & (self.arrays["period_events"] > 0)
        unknown = ~settled & (self.arrays["lifetime"] < LONG)
        return estimates.share_of(settled & sticks, unknown)

    @property
    def half_life(self) -> Estimate:
        """Time by which half of the runs have settled, or the whole time if fewer have."""
        return estimates.sure(np.median(self.arrays["lifetime"]))

    @property
    def exponent(self) -> Estimate:
        """Median largest exponent of the irregular motion; absent if all settled too soon for one.

        It hides its sign: that of a shift in time, which is zero, is among those of each run.
        """
        values = self.arrays["irregular_exponent"]
        values = values[np.isfinite(values)]
        if values.size >= MINIMUM_EXPONENTS:
            return _median(values)
        settled = self.arrays["settled"]
        require(settled.all(), f"{self.words}: longer runs are needed for an exponent")
        return estimates.absent(settled.size)

    @property
    def words(self) -> str:
        """How many runs settled, and after what time."""
        settled, half = self.arrays["settled"], self.half_life.value
        count = f"{settled.sum()} of {settled.size} runs settled within {self.duration:g}"
        return f"{count}, half of all by {half:.0f}" if 2 * settled.sum() >= settled.size else count


def settling(evidence: Evidence, names: tuple[str, ...]) -> Settling:
    """Runs at the belt velocities of the claim, from the first of the datasets that has some."""
    return Settling.of(evidence, *names, belt_velocity=evidence.claim.parameters["belt_velocity"])


def nontrivial_exponent(evidence: Evidence) -> Estimate:
    """Median over exact runs at their end of the largest exponent but that of a shift in time."""
    velocities = evidence.claim.parameters["belt_velocity"]
    try:
        arrays, _ = evidence.runs("motion_map", n_blocks=N_BLOCKS, belt_velocity=velocities)
    except NotEnoughDataError:
        return estimates.absent()
    values = arrays["nontrivial_exponent"][np.isfinite(arrays["nontrivial_exponent"])]
    return _median(values) if values.size else estimates.absent()


def _median(values: np.ndarray) -> Estimate:
    return estimates.bootstrap(np.median, [values])

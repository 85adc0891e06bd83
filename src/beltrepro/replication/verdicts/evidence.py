"""Access of claim functions to datasets and tracks: what is missing is said in one line."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.stats import sections, states, transition
from beltrepro.stats.estimates import Estimate

# Chaotic transients last up to 1e4 (inset of Fig. 12). A run that discards less than this shows
# the transient instead of the state that follows, so it cannot test claims about that state.
SETTLED_TRANSIENT = 5000.0
_SYMBOLS = {"n_blocks": "N", "belt_velocity": "u", "noise": "sigma"}  # of the paper
Ends = float | Sequence[float]  # a value, or the ends of a range
SCHEME, EXACT = "the paper's scheme", "exact dynamics"  # names of readings


@dataclass(frozen=True)
class Cut:
    """A row or column of a scan, with what is derived from it once."""

    points: dict = field(hash=False)
    transient: float
    duration: float

    @classmethod
    def of(cls, scan, **where: float) -> "Cut":
        """A row (n_blocks, noise) or column (n_blocks, belt_velocity) of a scan."""
        return cls(sections.cut(scan, **where), *_lengths(scan))

    belt_velocity = property(lambda self: self.points["belt_velocity"], doc="u (P,).")
    noise = property(lambda self: self.points["noise"], doc="sigma (P,).")
    disorder = property(lambda self: self.points["disorder_parameter"], doc="r (P,).")
    velocities = property(
        lambda self: self.points["section_velocity"], doc="v_N (P, V), NaN padded."
    )

    @cached_property
    def states(self) -> np.ndarray:
        """Labels of `states.label_states` (P,)."""
        return states.label_states(self.points, transient=self.transient, duration=self.duration)

    @cached_property
    def fall(self) -> dict[str, Estimate]:
        """The fall of r along u, outliers left out (`transition.fall`)."""
        kept = ~self.outliers
        return transition.fall(self.belt_velocity[kept], self.disorder[kept])

    @cached_property
    def outliers(self) -> np.ndarray:
        """Mask of what the paper calls outlying values: periodic stick-slip beyond the fall (P,).

        Beyond the first u at which most of several runs slip continuously, a run on a periodic
        orbit with sticks is on neither of the branches that r passes between (Fig. 12).
        """
        mask = np.zeros(len(self.belt_velocity), dtype=bool)
        places, place, runs = np.unique(self.belt_velocity, return_inverse=True, return_counts=True)
        if runs.max(initial=0) < 2:
            return mask
        slips = np.nan_to_num(self.points["last_stick_time"], nan=-np.inf) <= self.transient
        most = np.bincount(place, slips) >= runs / 2
        if most.any():
            late = ~slips & (self.belt_velocity > places[most.argmax()] + 1e-9)
            part = sections.select(self.points, late)
            labels = states.label_states(part, transient=self.transient, duration=self.duration)
            mask[late] = labels == states.PERIODIC
        return mask

    def within(self, low: float, high: float) -> "Cut":
        """The part of the points with low <= u <= high, one at least."""
        chosen = self.between(low, high)
        place = f"u = {low:g}" if low == high else f"{low:g} <= u <= {high:g}"
        require(chosen.any(), f"no runs at {place}")
        return Cut(sections.select(self.points, chosen), self.transient, self.duration)

    def between(self, low: float, high: float) -> np.ndarray:
        """Mask of the points with low <= u <= high, as many at each u (`evenly`)."""
        return self.evenly((self.belt_velocity >= low - 1e-9) & (self.belt_velocity <= high + 1e-9))

    def evenly(self, chosen: np.ndarray) -> np.ndarray:
        """The chosen points, at each u only the first so many as there are where it has fewest.

        Runs are added where r scatters. A share of the runs at several u would be drawn there.
        """
        rows = np.flatnonzero(chosen)
        _, place, count = np.unique(
            self.belt_velocity[rows], return_inverse=True, return_counts=True
        )
        kept = chosen.copy()
        for number in np.flatnonzero(count > count.min(initial=len(rows))):
            kept[rows[place == number][count.min() :]] = False
        return kept


class Evidence:
    """The datasets of a preset, and the tracks of its films (`belt_028_track`), by name.

    Missing data raise NotEnoughDataError with the reason. `used` lists what has been asked for
    since `start` was called.
    """

    def __init__(self, datasets: dict, settings: dict):
        self._datasets = datasets
        self._cuts: dict[tuple, Cut] = {}
        self.settings = settings
        self.used: list[str] = []
        self.claim = None

    def start(self, claim) -> None:
        """Begin with a claim: forget what was used for the last one."""
        self.claim, self.used = claim, []

    def dataset(self, name: str):
        """One dataset, e.g. "u1"."""
        require(name in self._datasets, f"this preset has no {name}")
        if name not in self.used:
            self.used.append(name)
        return self._datasets[name]

    def has(self, name: str) -> bool:
        """Whether a dataset is there."""
        return name in self._datasets

    def runs(self, *names: str, **where: Ends) -> tuple[dict[str, np.ndarray], dict]:
        """Runs with these values of quantities, or in these ranges, from the first that has any.

        Returns the arrays of these runs, and the attributes of the dataset. Runs are refused, as in
        `row`, if they discard a transient that is too short.
        """
        for name in filter(self.has, names):
            arrays = self._datasets[name].arrays
            chosen = np.all([_lies(arrays[key], value) for key, value in where.items()], axis=0)
            if chosen.any():
                attributes = self.dataset(name).attributes
                _settled(attributes.get("transient", np.inf), name)
                return sections.select(arrays, chosen), attributes
        raise _nowhere(names, where)

    def row(self, scan: str, n_blocks: int, noise: float) -> Cut:
        """The row of a number of blocks and a noise in a scan."""
        return self._cut(scan, n_blocks=n_blocks, noise=noise)

    def column(self, scan: str, n_blocks: int, belt_velocity: float) -> Cut:
        """The column of a number of blocks and a belt velocity in a scan."""
        return self._cut(scan, n_blocks=n_blocks, belt_velocity=belt_velocity)

    def _cut(self, scan: str, **where: float) -> Cut:
        dataset, key = self.dataset(scan), (scan, *where.items())
        if key not in self._cuts:
            self._cuts[key] = Cut.of(dataset, **where)
        cut = self._cuts[key]
        if not len(cut.belt_velocity):
            raise _nowhere([scan], where)
        _settled(cut.transient, scan)
        return cut

    def table(self, scan: str) -> Cut:
        """All points of a scan."""
        dataset = self.dataset(scan)
        cut = Cut(dataset.arrays, *_lengths(dataset))
        _settled(cut.transient, scan)
        return cut


def _lengths(dataset) -> tuple[float, float]:
    return float(dataset.attributes["transient"]), float(dataset.attributes["duration"])


def _settled(transient: float, name: str) -> None:
    require(
        transient >= SETTLED_TRANSIENT,
        f"{name} discards a transient of {transient:g}; chaotic transients last longer, "
        f"{SETTLED_TRANSIENT:g} is the least",
    )


def _lies(values: np.ndarray, ends: Ends) -> np.ndarray:
    return (values >= np.min(ends) - 1e-6) & (values <= np.max(ends) + 1e-6)


def _nowhere(names: Iterable[str], where: Mapping[str, Ends]) -> NotEnoughDataError:
    texts = {
        key: " to ".join(map("{:g}".format, np.atleast_1d(ends))) for key, ends in where.items()
    }
    place = ", ".join(f"{_SYMBOLS.get(key, key)} = {text}" for key, text in texts.items())
    return NotEnoughDataError(f"no runs with {place} in {' or '.join(names)}")


def by_point(arrays: dict[str, np.ndarray], *names: str) -> Iterator[tuple[dict, np.ndarray]]:
    """Each point as the values that these quantities have together, in rising order, and its runs.

    The runs are the places in the arrays, in their order.
    """
    columns = pd.DataFrame({name: arrays[name] for name in names})
    for values, runs in columns.groupby(list(names)):
        yield dict(zip(names, values, strict=True)), runs.index.to_numpy()

"""Which values of parameters agree with recordings: approximate Bayesian computation on a grid.

All combinations of levels have equally many trials; how probable they are before is given. A trial
agrees with a recording if a number lies within a tolerance of the recorded one and it shows the
feature of the recording. Recordings are independent, so shares of trials that agree multiply. They
are averaged over neighbouring levels, or the most probable levels would be those of a lucky share
of few trials.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import scipy

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.stats.estimates import Estimate, share


@dataclass(frozen=True, eq=False)
class Simulated:
    """Trials of S recordings at all combinations of the levels of some parameters."""

    # levels of each parameter; their numbers are the shape of the grid, C
    levels: dict[str, np.ndarray]
    summary: np.ndarray  # the number that is compared, of each of R trials
    shown: np.ndarray  # whether the trial shows the feature of the recording
    # by parameter, over how many levels shares are averaged: standard deviation of Gaussian
    # weights. A parameter that is not named is not averaged over
    smoothing: Mapping[str, float] = field(default_factory=dict)
    # by parameter, how probable its levels are before, relative to each other. Those of a parameter
    # that is not named are equally probable
    weights: Mapping[str, np.ndarray] = field(default_factory=dict)
    # share of the time that each trial is quiet, as `summary`; what is told of recordings lacks it
    quiet_share: np.ndarray | None = None

    @property
    def prior(self) -> np.ndarray:
        """How probable each combination of levels is before; adds up to 1."""
        prior = np.ones(())
        for name, levels in self.levels.items():
            prior = np.multiply.outer(prior, self.weights.get(name, np.ones(levels.size)))
        return prior / prior.sum()

    @property
    def runs(self) -> int:
        """Trials of each recording in a cell of the grid."""
        return self.summary.shape[-1]

    def fixed(self, name: str, value: float) -> Simulated:
        """The trials at one level of a parameter."""
        chosen = np.isclose(self.levels[name], value, rtol=1e-3, atol=0)
        require(chosen.any(), f"no trial with {name} = {value:g}")
        axis = 1 + list(self.levels).index(name)
        fixed = self.of(lambda trials: np.compress(chosen, trials, axis=axis))
        weights = {other: weight for other, weight in self.weights.items() if other != name}
        levels = self.levels | {name: self.levels[name][chosen]}
        return replace(fixed, levels=levels, weights=weights)

    def of(self, chosen: Callable[[np.ndarray], np.ndarray]) -> Simulated:
        """Those of the trials that a function takes of an array (S, *C, R)."""
        quiet = None if self.quiet_share is None else chosen(self.quiet_share)
        return replace(
            self, summary=chosen(self.summary), shown=chosen(self.shown), quiet_share=quiet
        )

    def drawn_anew(self, rng: np.random.Generator) -> Simulated:
        """As many trials of each cell, drawn from them with replacement."""
        drawn = rng.integers(0, self.runs, self.summary.shape)
        return self.of(lambda trials: np.take_along_axis(trials, drawn, axis=-1))

    def agreeing(self, recorded: Sequence[float], tolerance: float) -> np.ndarray:
        """Which trials (S, *C, R) agree with these numbers of the S recordings."""
        return (self._distance(self.summary, recorded) <= tolerance) & self.shown

    def as_quiet(self, quiet_share: Sequence[float] | np.ndarray, within: float) -> np.ndarray:
        """Which trials (S, *C, R) are quiet for these shares of the time."""
        require(self.quiet_share is not None, "of the trials no quiet share is known")
        return self._distance(self.quiet_share, quiet_share) <= within

    def _distance(self, numbers, recorded) -> np.ndarray:
        return np.abs(numbers - np.reshape(recorded, (-1, *[1] * (self.summary.ndim - 1))))


@dataclass(frozen=True, eq=False)
class Posterior:
    """How probable each combination of levels is, given the recordings."""

    levels: dict[str, np.ndarray]  # levels of each parameter, with the shape C
    probability: np.ndarray  # adds up to 1
    evidence: float  # probability, before, that trials agree with all recordings
    agreed: tuple[int, ...]  # how many trials agree with each recording

    def marginal(self, *names: str) -> np.ndarray:
        """Probability of the levels of some parameters, whatever the others."""
        others = tuple(axis for axis, name in enumerate(self.levels) if name not in names)
        return self.probability.sum(axis=others)


def credible_set(probability: np.ndarray, credibility: float = 0.9) -> np.ndarray:
    """The most probable levels that together have at least this probability."""
    order = np.argsort(-probability, kind="stable")
    before = np.cumsum(probability[order]) - probability[order]
    chosen = np.zeros(probability.size, dtype=bool)
    chosen[order[before < credibility - 1e-12]] = True
    return chosen


def posterior(
    simulated: Simulated,
    recorded: Sequence[float],
    tolerance: float,
    *,
    without: np.ndarray | None = None,
    among: np.ndarray | bool = True,
) -> Posterior:
    """How probable each combination of levels is, given numbers of the recordings.

    Shares of the trials that agree are averaged over neighbouring levels. without : trials that are
    left out. among : those that agree in something else.
    """
    agreed = simulated.agreeing(recorded, tolerance) & among
    asked = np.ones_like(agreed) if without is None else ~without
    agreed &= asked
    width = (0.0, *(simulated.smoothing.get(name, 0.0) for name in simulated.levels))
    agreeing, all_asked = (
        scipy.ndimage.gaussian_filter(trials.sum(axis=-1, dtype=float), width, mode="constant")
        for trials in (agreed, asked)
    )
    likelihood = np.prod(agreeing / all_asked, axis=0)
    counts = tuple(int(trials.sum()) for trials in agreed)
    require(
        likelihood.any(),
        f"{' and '.join(map(str, counts))} of {agreed[0].size} trials agree with the recordings, "
        "none with all at one combination of levels",
    )
    both = simulated.prior * likelihood
    return Posterior(simulated.levels, both / both.sum(), float(both.sum()), counts)


# --- checks of it ---------------------------------------------------------------------------------


def held_out(simulated: Simulated, recorded: Sequence[float], tolerance: float) -> float:
    """Probability that fresh trials under the posterior agree with all recordings.

    Half of the trials make the posterior and the other half are asked, then the other way round: a
    cell is not praised for the chance by which it was chosen.
    """
    require(simulated.runs >= 2, "two trials in a cell are needed, to ask other ones")
    halves = [simulated.of(lambda trials, first=first: trials[..., first::2]) for first in (0, 1)]
    agreeing = []
    for made_of, asked in (halves, halves[::-1]):
        try:
            probability = posterior(made_of, recorded, tolerance).probability
        except NotEnoughDataError:
            probability = np.zeros(())
        fresh = np.prod(asked.agreeing(recorded, tolerance).mean(axis=-1), axis=0)
        agreeing.append(float((probability * fresh).sum()))
    return float(np.mean(agreeing))


def predicted(answer: Posterior, values: np.ndarray, quantiles: Sequence[float]) -> np.ndarray:
    """Quantiles of a number of trials under the posterior."""
    weights = np.broadcast_to(answer.probability[..., np.newaxis], values.shape)
    return np.quantile(values.ravel(), quantiles, weights=weights.ravel(), method="inverted_cdf")


class Calibration(NamedTuple):
    """How posteriors do on trials with known parameters."""

    # by parameter, share of the made-up experiments whose true level lies in the credible set
    coverage: dict[str, Estimate]
    # by parameter, p of the test that the posterior probability below the true level is uniform
    # (Kolmogorov and Smirnov); ties are broken at random
    uniform_p: dict[str, float]
    # by parameter, how many levels the credible set holds, on average
    levels: dict[str, float]
    experiments: int  # made-up experiments
    unanswered: int  # further ones with which no trial agreed


def calibrate(
    simulated: Simulated, tolerance: float, *, draws: int = 400, quiet_within: float | None = None
) -> Calibration:
    """Treat trials as experiments whose parameters are known, and infer them from the other trials.

    The made-up experiments are drawn from all combinations of levels, as probable as before, out of
    the trials that show the feature. quiet_within : they tell their quiet share too, to so much.
    """
    generator = np.random.default_rng(1)
    weight = simulated.prior * np.prod(simulated.shown.mean(axis=-1), axis=0)
    require(weight.any(), "no trials show what the recordings show")
    cells = generator.choice(weight.size, size=draws, p=(weight / weight.sum()).ravel())
    ranks_of: dict[str, list[float]] = {name: [] for name in simulated.levels}
    covered: dict[str, list[bool]] = {name: [] for name in simulated.levels}
    sizes: dict[str, list[int]] = {name: [] for name in simulated.levels}
    for cell in cells:
        at = np.unravel_index(cell, weight.shape)
        without = np.zeros(simulated.shown.shape, dtype=bool)
        for number, shown in enumerate(simulated.shown):
            without[(number, *at, generator.choice(np.flatnonzero(shown[at])))] = True
        among: np.ndarray | bool = True
        if quiet_within is not None and simulated.quiet_share is not None:
            among = simulated.as_quiet(simulated.quiet_share[without], quiet_within)
        recorded = simulated.summary[without]
        try:
            answer = posterior(simulated, recorded, tolerance, without=without, among=among)
        except NotEnoughDataError:
            continue
        for name, level in zip(simulated.levels, at, strict=True):
            marginal = answer.marginal(name)
            below = marginal[:level].sum() + generator.random() * marginal[level]
            ranks_of[name].append(float(below))
            chosen = credible_set(marginal)
            covered[name].append(bool(chosen[level]))
            sizes[name].append(int(chosen.sum()))
    answered = len(next(iter(ranks_of.values())))
    require(answered, "no made-up experiment has a posterior")
    return Calibration(
        {name: share(sum(inside), answered) for name, inside in covered.items()},
        {name: float(scipy.stats.kstest(x, "uniform").pvalue) for name, x in ranks_of.items()},
        {name: float(np.mean(counts)) for name, counts in sizes.items()},
        answered,
        draws - answered,
    )

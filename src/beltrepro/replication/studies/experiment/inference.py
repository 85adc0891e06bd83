"""Which values of parameters agree with recordings: approximate Bayesian computation on a grid.

All combinations of levels have equally many trials and are equally probable before. A trial agrees
with a recording if a number lies within a tolerance of the recorded one and it shows the same
feature. Recordings are independent, so shares of trials that agree multiply. They are averaged over
neighbouring levels, or the most probable levels would be those of a lucky share of few trials.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import scipy

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.stats.estimates import Estimate, share

CREDIBILITY = 0.9  # of sets of levels, where nothing else is said


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

    @property
    def runs(self) -> int:
        """Trials of each recording in a cell of the grid."""
        return self.summary.shape[-1]

    def fixed(self, name: str, value: float, *, tolerance: float = 1e-3) -> Simulated:
        """The trials at one level of a parameter."""
        chosen = np.isclose(self.levels[name], value, rtol=tolerance, atol=0)
        require(chosen.any(), f"no trial with {name} = {value:g}")
        axis = 1 + list(self.levels).index(name)
        return replace(
            self,
            levels=self.levels | {name: self.levels[name][chosen]},
            summary=np.compress(chosen, self.summary, axis=axis),
            shown=np.compress(chosen, self.shown, axis=axis),
        )

    def drawn_anew(self, rng: np.random.Generator) -> Simulated:
        """As many trials of each cell, drawn from them with replacement."""
        chosen = rng.integers(0, self.runs, self.summary.shape)
        summary, shown = (
            np.take_along_axis(values, chosen, axis=-1) for values in (self.summary, self.shown)
        )
        return replace(self, summary=summary, shown=shown)

    def part(self, runs: slice) -> Simulated:
        """Some of the trials of each cell."""
        return replace(self, summary=self.summary[..., runs], shown=self.shown[..., runs])


class Recorded(NamedTuple):
    """What was recorded: the number, and whether the feature shows, of each of S recordings."""

    summary: Sequence[float]
    shown: Sequence[bool]


@dataclass(frozen=True, eq=False)
class Posterior:
    """How probable each combination of levels is, given the recordings."""

    levels: dict[str, np.ndarray]  # levels of each parameter, with the shape C
    probability: np.ndarray  # adds up to 1
    # probability, before, that trials agree with all recordings: mean over all combinations
    evidence: float
    agreed: tuple[int, ...]  # how many trials agree with each recording

    def marginal(self, *names: str) -> np.ndarray:
        """Probability of the levels of some parameters, whatever the others."""
        others = tuple(axis for axis, name in enumerate(self.levels) if name not in names)
        return self.probability.sum(axis=others)

    def credible(self, name: str) -> np.ndarray:
        """The smallest set of levels with at least the probability CREDIBILITY."""
        return credible_set(self.marginal(name))


def credible_set(probability: np.ndarray, credibility: float = CREDIBILITY) -> np.ndarray:
    """The most probable levels that together have at least this probability."""
    order = np.argsort(-probability, kind="stable")
    before = np.cumsum(probability[order]) - probability[order]
    chosen = np.zeros(probability.size, dtype=bool)
    chosen[order[before < credibility - 1e-12]] = True
    return chosen


def agreement(simulated: Simulated, recorded: Recorded, tolerance: float) -> np.ndarray:
    """Which trials agree with the recordings."""
    shape = (-1, *[1] * (simulated.summary.ndim - 1))
    summary, shown = (np.reshape(values, shape) for values in recorded)
    return (np.abs(simulated.summary - summary) <= tolerance) & (simulated.shown == shown)


def posterior(
    simulated: Simulated, recorded: Recorded, tolerance: float, *, without: np.ndarray | None = None
) -> Posterior:
    """How probable each combination of levels is, given the recordings."""
    agreed = agreement(simulated, recorded, tolerance)
    asked = np.ones_like(agreed) if without is None else ~without
    agreed &= asked
    likelihood = np.prod(_shares(simulated, agreed, asked), axis=0)
    counts = tuple(int(trials.sum()) for trials in agreed)
    require(
        likelihood.any(),
        f"{' and '.join(map(str, counts))} of {agreed[0].size} trials agree with the recordings, "
        "none with all at one combination of levels",
    )
    evidence = float(likelihood.mean())
    return Posterior(simulated.levels, likelihood / likelihood.sum(), evidence, counts)


def _shares(simulated: Simulated, agreed: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Shares (S, *C) of the trials asked that agree, averaged over neighbouring levels."""
    width = (0.0, *(simulated.smoothing.get(name, 0.0) for name in simulated.levels))
    agreeing, all_asked = (
        scipy.ndimage.gaussian_filter(trials.sum(axis=-1, dtype=float), width, mode="constant")
        for trials in (agreed, asked)
    )
    return agreeing / all_asked


# --- checks of it ---------------------------------------------------------------------------------


def held_out(simulated: Simulated, recorded: Recorded, tolerance: float) -> float:
    """Probability that fresh trials under the posterior agree with all recordings.

    Half of the trials make the posterior and the other half are asked, then the other way round: a
    cell is not praised for the chance by which it was chosen.
    """
    require(simulated.runs >= 2, "two trials in a cell are needed, to ask other ones")
    halves = simulated.part(slice(0, None, 2)), simulated.part(slice(1, None, 2))
    agreeing = []
    for made_of, asked in (halves, halves[::-1]):
        try:
            probability = posterior(made_of, recorded, tolerance).probability
        except NotEnoughDataError:
            probability = np.zeros(())
        fresh = np.prod(agreement(asked, recorded, tolerance).mean(axis=-1), axis=0)
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
    experiments: int  # made-up experiments
    unanswered: int  # further ones with which no trial agreed


def calibrate(
    simulated: Simulated,
    tolerance: float,
    *,
    shown: Sequence[bool],
    draws: int = 400,
) -> Calibration:
    """Treat trials as experiments whose parameters are known, and infer them from the other trials.

    The made-up experiments are drawn from all combinations of levels, as probable as before, out of
    those that show what the recordings show.
    """
    generator = np.random.default_rng(1)
    alike = simulated.shown == np.reshape(shown, (-1, *[1] * (simulated.shown.ndim - 1)))
    weight = np.prod(alike.sum(axis=-1), axis=0)
    require(weight.any(), "no trials show what the recordings show")
    cells = generator.choice(weight.size, size=draws, p=(weight / weight.sum()).ravel())
    ranks_of: dict[str, list[float]] = {name: [] for name in simulated.levels}
    covered: dict[str, list[bool]] = {name: [] for name in simulated.levels}
    for cell in cells:
        at = np.unravel_index(cell, weight.shape)
        taken = [generator.choice(np.flatnonzero(shows[at])) for shows in alike]
        without = np.zeros(simulated.shown.shape, dtype=bool)
        for number, run in enumerate(taken):
            without[(number, *at, run)] = True
        summary = [
            float(values[out][0]) for values, out in zip(simulated.summary, without, strict=True)
        ]
        try:
            answer = posterior(simulated, Recorded(summary, shown), tolerance, without=without)
        except NotEnoughDataError:
            continue
        for name, level in zip(simulated.levels, at, strict=True):
            marginal = answer.marginal(name)
            below = marginal[:level].sum() + generator.random() * marginal[level]
            ranks_of[name].append(float(below))
            covered[name].append(bool(answer.credible(name)[level]))
    answered = len(next(iter(ranks_of.values())))
    require(answered, "no made-up experiment has a posterior")
    return Calibration(
        {name: share(sum(inside), answered) for name, inside in covered.items()},
        {
            name: float(scipy.stats.kstest(ranks, "uniform").pvalue)
            for name, ranks in ranks_of.items()
        },
        answered,
        draws - answered,
    )

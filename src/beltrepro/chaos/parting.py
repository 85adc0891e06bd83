"""How fast runs that begin close together separate, at each size of their distance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import Chunk
from beltrepro.engine.noise import stream_key
from beltrepro.engine.state import ChainState
from beltrepro.simulation.groups import Report, integrator_of, observe
from beltrepro.simulation.results import Results, gathered
from beltrepro.simulation.setup import Case, Chains, Keywords, check_lengths, setup_of, with_setup

# Of twins at first, model length. Rounding is a tenth of the smallest.
DISTANCES = (1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 1.0)
_LARGEST = 10.0  # model length; blocks of irregular motion are some ten apart
_PER_DECADE = 2  # levels
_DIRECTION = 2  # purpose of a random stream: in which direction a twin is moved


@with_setup
def separation(
    chains: Chains,
    *,
    duration: float,
    transient: float,
    levels: ArrayLike | None = None,
    distances: Sequence[float] = DISTANCES,
    progress: Report | None = None,
    **setup: Unpack[Keywords],
) -> Results:
    """When each of P chains and twins of it are first apart by each of several levels.

    After the transient each chain gets D twins. The blocks of a twin are moved in a random
    direction, the one that moves most by one of the `distances`. Velocities, and which blocks are
    stuck, stay the same, and so do all random numbers to come. Then all advance. The distance is
    the largest difference of the positions of a block, looked at about every 0.1 time units.
    Finite-size exponents follow from it (`beltrepro.stats.growth`). Where small distances
    shrink, only twins that begin further away tell at which size distances grow.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        P chains.
    duration : float
        Model time of each run, the transient included.
    transient : float
        The first part of it, before there is a twin.
    levels : array (L,)
        Increasing, model length; if not given two in each decade, from the smallest distance to 10.
    distances : sequence of float
        Of the D twins at first, model length.
    progress : callable, optional
        Called with the fraction done.
    **setup
        The keywords of `Setup`, `kick` among them.

    Returns
    -------
    Results
        levels (L,), distances (D,); passage_time (P, D, L), model time since the twins were moved
        at which one was first as far away; NaN where it never was, or begins further away.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, or a state left the range of the model.
    """
    duration, transient = check_lengths(duration, transient)
    apart = checks.several("distances", distances, checks.positive)
    sizes = _levels(levels, apart)
    settings: dict[str, Any] = {"duration": duration, "transient": transient}
    measure = partial(_followed, distances=apart, levels=sizes, **settings)
    made = setup_of(chains, setup, kicks=True)
    passages = gathered("separation", made, measure, progress, **settings)
    passages |= {"levels": sizes, "distances": apart}
    return passages


def _levels(sizes: ArrayLike | None, distances: np.ndarray) -> np.ndarray:
    """Levels at which the time is noted."""
    if sizes is None:
        count = round(_PER_DECADE * np.log10(_LARGEST / distances.min())) + 1
        return np.geomspace(distances.min(), _LARGEST, max(count, 2))
    levels = checks.several("levels", sizes, checks.positive)
    if levels.size < 2 or not np.all(np.diff(levels) > 0):
        shown = checks.shown(sizes)
        raise InputError(f"levels = {shown}: at least two increasing ones above 0 are needed")
    return levels


def _followed(
    group: np.ndarray,
    members: list[Case],
    report: Report,
    *,
    distances: np.ndarray,
    levels: np.ndarray,
    duration: float,
    transient: float,
) -> dict[str, np.ndarray]:
    """Passage times (W, D, L) of a group."""
    before = integrator_of(members)
    if transient > 0:
        observe(before, transient, [], lambda done: report(done * transient / duration))
    # variables of the scheme are made anew for all, since a twin has none
    firsts = [replace(state, scheme=None) for state in before.state()]
    states = firsts + [_moved(state, distance) for distance in distances for state in firsts]
    cases = [replace(members[row % len(members)], state=state) for row, state in enumerate(states)]
    chains = integrator_of(cases, sampled_blocks=before.n_blocks)
    passages = _Passages(len(members), distances, levels, chains.time)
    start, left = chains.time, duration - transient
    for chunk in chains.advance(start + left):
        passages.observe(chunk)
        report((transient + chunk.end - start) / duration)
        if passages.done:
            break
    return {"passage_time": passages.time}


def _moved(state: ChainState, distance: float) -> ChainState:
    """A state whose blocks are moved, the one that moves most by `distance`."""
    key = stream_key(state.parameters, state.seed, state.replicate, _DIRECTION)
    way = np.random.default_rng(key).standard_normal(len(state.displacements))
    twin = replace(state, displacements=state.displacements + distance * way / np.abs(way).max())
    if not np.all(np.diff(twin.positions, prepend=0.0) > 0):
        raise InputError(f"distances = {distance:g}: blocks of a twin would be beyond each other")
    return twin


class _Passages:
    """When D twins of W chains are first as far from them as each of L levels.

    The first W chains are followed by their W twins at each of the distances. `time` (W, D, L) is
    counted from `start`.
    """

    def __init__(self, width: int, distances: np.ndarray, levels: np.ndarray, start: float) -> None:
        self._levels, self._start = levels, start
        self.time = np.full((width, len(distances), len(levels)), np.nan)
        for twin, distance in enumerate(distances):
            self.time[:, twin, np.isclose(levels, distance, atol=0.0)] = 0.0
        self._above = levels > distances[:, None]  # those below are not passed on the way

    @property
    def done(self) -> bool:
        """Whether all twins have been at the last level."""
        return not np.isnan(self.time[:, :, -1]).any()

    def observe(self, chunk: Chunk) -> None:
        """Look at the samples of a chunk."""
        width, twins, _ = self.time.shape
        moved = chunk.displacement.reshape(*chunk.displacement.shape[:2], twins + 1, width)
        apart = np.abs(moved[:, :, 1:] - moved[:, :, :1]).max(axis=1)
        farthest = np.maximum.accumulate(apart, axis=0)
        for twin in range(twins):
            for lane in range(width):
                passed = self.time[lane, twin]
                place = np.searchsorted(farthest[:, twin, lane], self._levels)
                new = self._above[twin] & (place < len(farthest)) & np.isnan(passed)
                passed[new] = chunk.time[place[new]] - self._start

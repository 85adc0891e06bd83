"""Deviation vectors of a group of chains: how they start, grow and are kept apart."""

from collections.abc import Callable, Sequence

import numpy as np

from beltrepro.engine.integrator import Sampling
from beltrepro.engine.tangent_integrator import TangentIntegrator

INTERVAL = 20.0  # model time between two orthonormalisations; e-folding takes 60 and more
SAMPLES = Sampling(1, 0.1)  # for r
NO_SAMPLES = Sampling(1, 10 * INTERVAL)
_BATCHES = 32  # of the growth of one run, whose scatter is its error


def randomise(chains: TangentIntegrator) -> None:
    """Give all chains the same random vectors."""
    shape = chains.deviations().shape
    vectors = np.random.default_rng(chains.n_blocks).standard_normal(shape[1:])
    chains.set_deviations(np.broadcast_to(vectors, shape))


def grow(
    chains: TangentIntegrator,
    length: float,
    intervals: int | None,
    observers: Sequence,
    report: Callable[[float], None],
) -> np.ndarray:
    """Advance by `length` and orthonormalise at the end of each of T intervals.

    intervals : T; as many as INTERVAL asks for if None. report : called with the time reached.
    Returns the rates of growth (W, T, K) of the vectors.
    """
    begin = chains.time
    count = max(1, round(length / INTERVAL)) if intervals is None else intervals
    growth = []
    for number in range(1, count + 1):
        for chunk in chains.advance(begin + number * length / count):
            for observer in observers:
                observer.observe(chunk)
        growth.append(_orthonormalise(chains))
        report(chains.time)
    return np.stack(growth, axis=1) * (count / length)


def _orthonormalise(chains: TangentIntegrator) -> np.ndarray:
    """Make the vectors orthonormal; returns the logarithms (W, K) of their growth."""
    directions, triangle = np.linalg.qr(chains.deviations())
    chains.set_deviations(directions)
    stretch = np.abs(np.diagonal(triangle, axis1=1, axis2=2))
    return np.log(np.maximum(stretch, np.finfo(float).tiny))


def standard_errors(growth: np.ndarray) -> np.ndarray:
    """Standard errors (P, K) of the means of growth rates (P, T, K), by means of batches.

    Successive rates are correlated, means over a thirty-second of the run hardly. NaN with fewer
    than two intervals, 0 where the exponent is minus infinity.
    """
    batches = min(_BATCHES, growth.shape[1])
    if batches < 2:
        return np.full((growth.shape[0], growth.shape[2]), np.nan)
    finite = np.where(np.isneginf(growth), 0.0, growth)
    means = np.stack([part.mean(axis=1) for part in np.array_split(finite, batches, axis=1)])
    return means.std(axis=0, ddof=1) / np.sqrt(batches)

"""Sizes and energies of slips and avalanches, and the power laws in their densities (Fig. 9)."""

import numpy as np
import numpy.typing as npt

from beltrepro.stats.errors import require
from beltrepro.stats.fits import PowerLawFit, fit_log_log

__all__ = [
    "PowerLawFit",
    "cutoff",
    "density_error",
    "dissipation_while_last_block_slips",
    "falling_range",
    "fit_density",
    "last_block_slip_sizes",
    "last_block_slips",
    "log_histogram",
    "most_at_once",
    "with_last_block",
]

FRAMES = ("laboratory", "belt")
MINIMUM_COUNT = 10


def last_block_slips(slips: np.ndarray, n_blocks: int) -> np.ndarray:
    """The slips of a catalogue that belong to the last block."""
    return slips[slips["block"] == n_blocks]


def last_block_slip_sizes(
    slips: np.ndarray, n_blocks: int, belt_velocity: float, frame: str = "laboratory"
) -> np.ndarray:
    """Slip sizes of the last block: coordinate where it starts to slip minus where it stops."""
    if frame not in FRAMES:
        raise ValueError(f"frame = {frame!r}: allowed are {', '.join(FRAMES)}")
    own = last_block_slips(slips, n_blocks)
    sizes = own["start_position"] - own["stop_position"]
    if frame == "belt":
        sizes = sizes + belt_velocity * (own["stop_time"] - own["start_time"])
    return sizes


def dissipation_while_last_block_slips(slips: np.ndarray, n_blocks: int) -> np.ndarray:
    """Friction loss of the whole chain during each slip of the last block.

    In this reading of the paper an avalanche ends when the last block stops. A slip of another
    block that overlaps counts with the share of its duration that overlaps.
    """
    energies = []
    for chain in np.unique(slips["point"]):
        of_chain = slips[slips["point"] == chain]
        of_chain = of_chain[np.argsort(of_chain["start_time"])]
        starts, stops = of_chain["start_time"], of_chain["stop_time"]
        longest = np.max(stops - starts)
        for own in of_chain[of_chain["block"] == n_blocks]:
            near = slice(
                np.searchsorted(starts, own["start_time"] - longest),
                np.searchsorted(starts, own["stop_time"]),
            )
            overlap = np.minimum(stops[near], own["stop_time"]) - np.maximum(
                starts[near], own["start_time"]
            )
            duration = np.maximum(stops[near] - starts[near], np.finfo(float).tiny)
            share = np.clip(overlap / duration, 0.0, 1.0)
            energies.append(np.sum(share * of_chain["dissipated"][near]))
    return np.array(energies)


def with_last_block(avalanches: np.ndarray, slips: np.ndarray, n_blocks: int) -> np.ndarray:
    """Which avalanches of a catalogue take in a slip of the last block."""
    own = last_block_slips(slips, n_blocks)
    reached = np.zeros(avalanches.size, dtype=bool)
    for chain in np.unique(avalanches["point"]):
        starts = np.sort(own["start_time"][own["point"] == chain])
        of_chain = avalanches["point"] == chain
        before = np.searchsorted(starts, avalanches["start_time"][of_chain])
        after = np.searchsorted(starts, avalanches["stop_time"][of_chain], side="right")
        reached[of_chain] = after > before
    return reached


def most_at_once(avalanches: np.ndarray, slips: np.ndarray) -> np.ndarray:
    """Largest number of blocks that slip at one instant of each avalanche."""
    most = np.zeros(avalanches.size, dtype=int)
    for chain in np.unique(avalanches["point"]):
        own = slips[slips["point"] == chain]
        of_chain = np.flatnonzero(avalanches["point"] == chain)
        time = np.concatenate([own["stop_time"], own["start_time"]])
        change = np.repeat([-1, 1], own.size)
        order = np.argsort(time, kind="stable")  # a block that reverses stops first
        slipping = np.cumsum(change[order])
        first = np.searchsorted(time[order], avalanches["start_time"][of_chain])
        last = np.searchsorted(time[order], avalanches["stop_time"][of_chain])
        most[of_chain] = [slipping[begin:end].max() for begin, end in zip(first, last, strict=True)]
    return most


def log_histogram(
    values: npt.ArrayLike,
    *,
    bins_per_decade: int,
    low: float | None = None,
    high: float | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Probability density of positive values in bins of equal width in log10."""
    values = np.asarray(values, dtype=float).ravel()
    values = values[values > 0]
    require(values.size, "no positive value")
    first = np.floor(np.log10(values.min() if low is None else low) * bins_per_decade + 1e-9)
    last = np.ceil(np.log10(values.max() if high is None else high) * bins_per_decade - 1e-9)
    edges = 10 ** (np.arange(first, max(last, first + 1) + 1) / bins_per_decade)
    # Rounding must not drop the extreme values.
    edges[0] *= 1 - 1e-12
    edges[-1] *= 1 + 1e-12
    count, _ = np.histogram(values, edges)
    return np.sqrt(edges[1:] * edges[:-1]), count / (values.size * np.diff(edges)), count


def density_error(
    values: npt.ArrayLike, run: npt.ArrayLike, centre: np.ndarray, *, bins_per_decade: int
) -> np.ndarray:
    """Standard error of a density from `log_histogram`, by leaving out one run after the other.

    Values of one run hang together, so that their number says little of the error.
    """
    values, run = np.asarray(values, dtype=float), np.asarray(run)
    names, member = np.unique(run[values > 0], return_inverse=True)
    if names.size < 2:
        return np.full(len(centre), np.nan)
    first = np.log10(centre[0]) * bins_per_decade - 0.5
    place = np.floor(np.log10(values[values > 0]) * bins_per_decade - first + 1e-9).astype(int)
    count = np.zeros((names.size, len(centre)))
    np.add.at(count, (member, np.clip(place, 0, len(centre) - 1)), 1)
    ratio = 10 ** (0.5 / bins_per_decade)
    width = centre * (ratio - 1 / ratio)
    total = count.sum(axis=0) - count
    without = total / (total.sum(axis=1, keepdims=True) * width)
    return np.sqrt((names.size - 1) * without.var(axis=0))


def cutoff(values: npt.ArrayLike, run: npt.ArrayLike) -> tuple[float, float]:
    """Size at which a broad density ends: the ratio of its second moment to its first.

    Under a power law that falls less steeply than with exponent -2 and is cut off, the ratio is
    proportional to the cutoff, as the small values hardly count.
    """
    values, run = np.asarray(values, dtype=float), np.asarray(run)
    positive = values > 0
    require(positive.any(), "no positive value")
    names, member = np.unique(run[positive], return_inverse=True)
    first = np.bincount(member, values[positive])
    second = np.bincount(member, values[positive] ** 2)
    size = float(second.sum() / first.sum())
    if names.size < 2:
        return size, np.nan
    without = (second.sum() - second) / (first.sum() - first)
    return size, float(np.sqrt((names.size - 1) * without.var()))


def falling_range(
    centre: np.ndarray,
    density: np.ndarray,
    count: np.ndarray,
    *,
    minimum_count: int = MINIMUM_COUNT,
) -> tuple[float, float]:
    """Range of the falling part of a density: the fit range used for Fig. 9, stated as a rule.

    From the bin of the largest density to the last bin of the unbroken run of bins that follow it
    with at least `minimum_count` values.
    """
    top = int(np.argmax(density))
    sparse = np.flatnonzero(count[top:] < minimum_count)
    end = top + sparse[0] - 1 if sparse.size else len(count) - 1
    require(end > top, f"no bin after the most probable one holds {minimum_count} values")
    return float(centre[top]), float(centre[end])


def fit_density(
    centre: np.ndarray, density: np.ndarray, count: np.ndarray, *, low: float, high: float
) -> PowerLawFit:
    """Power law through a histogram density, bins between low and high weighted by their counts."""
    edge = 1e-9
    return fit_log_log(centre, density, low=low * (1 - edge), high=high * (1 + edge), weight=count)

"""Where the disorder parameter r falls with u or rises with noise (Figs. 12 to 15, 19 and 21)."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.stats.errors import require

MINIMUM_POINTS = 8
MINIMUM_CONTRAST = 2.0
MINIMUM_RISE = 1.3
SMOOTHING = 3.0
BOOTSTRAP_SAMPLES = 50


@dataclass(frozen=True)
class Transition:
    """A fall or rise of r between two plateaus, along u or sigma.

    The edges and `critical` are NaN when `found` is False: the plateaus are too alike for a
    transition.
    """

    lower: float  # lower edge of the transition region
    upper: float  # upper edge of the transition region
    critical: float  # the point that stands for the region
    r_high: float  # median of the high plateau
    r_low: float  # median of the low plateau
    found: bool = True  # whether there is a transition
    error: float = np.nan  # one standard error of `critical`
    r_high_error: float = np.nan  # standard error of r_high
    r_low_error: float = np.nan  # standard error of r_low
    n_points: int = 0  # number of points used

    @property
    def width(self) -> float:
        """Width of the transition region."""
        return self.upper - self.lower

    @property
    def contrast(self) -> float:
        """Ratio of the plateaus."""
        return self.r_high / self.r_low


def transition_region(
    belt_velocity: npt.ArrayLike,
    disorder_parameter: npt.ArrayLike,
    *,
    smoothing: float = SMOOTHING,
    minimum_contrast: float = MINIMUM_CONTRAST,
    bootstrap: int = BOOTSTRAP_SAMPLES,
) -> Transition:
    """Transition region of r(u): where r falls from its high to its low plateau.

    Criterion. (1) A step with two levels is fitted to r(u) by least absolute deviations: outliers
    (periodic windows, attractors of large amplitude) do not move it. (2) r_high is the median of r
    between half the position of the step and the step, r_low that between the step and twice its
    position. (3) In the running median of r over a window of `smoothing` in u, `lower` is the last
    u up to which r keeps 90 % of the fall, `upper` the first u after that where it is down to 10 %
    (interpolated). (4) critical is the midpoint, as for the paper's u_c. There is no transition
    when r_high < minimum_contrast * r_low.
    """
    velocity, disorder = _sorted(belt_velocity, disorder_parameter)
    result = _fall(velocity, disorder, smoothing, minimum_contrast)
    if not result.found or not bootstrap:
        return result
    rng = np.random.default_rng(0)
    samples = []
    for _ in range(bootstrap):
        chosen = np.sort(rng.integers(0, velocity.size, velocity.size))
        samples.append(_fall(velocity[chosen], disorder[chosen], smoothing, minimum_contrast))
    spacing = np.median(np.diff(np.unique(velocity)))
    return replace(
        result,
        error=_hypot(_spread([s.critical for s in samples]), spacing / np.sqrt(12)),
        r_high_error=_spread([s.r_high for s in samples]),
        r_low_error=_spread([s.r_low for s in samples]),
    )


def critical_noise(
    noise: npt.ArrayLike,
    disorder_parameter: npt.ArrayLike,
    *,
    minimum_rise: float = MINIMUM_RISE,
    bootstrap: int = BOOTSTRAP_SAMPLES,
) -> Transition:
    """Noise-induced transition: where r(sigma) at fixed u rises from a low to a high plateau.

    Criterion. (1) A step with two levels is fitted by least absolute deviations; the levels r_low
    and r_high are the medians on its two sides. (2) critical is where the isotonic regression of
    r(sigma) (the monotone curve of least squares) passes half way, lower and upper where it passes
    10 % and 90 % of the rise (linear between grid points). There is no transition when
    r_high < minimum_rise * r_low.
    """
    noise, disorder = _sorted(noise, disorder_parameter, minimum=5)
    result = _rise(noise, disorder, minimum_rise)
    if not result.found or not bootstrap:
        return result
    rng = np.random.default_rng(0)
    samples = []
    for _ in range(bootstrap):
        chosen = np.sort(rng.integers(0, noise.size, noise.size))
        samples.append(_rise(noise[chosen], disorder[chosen], minimum_rise))
    spacing = np.median(np.diff(np.unique(noise)))
    return replace(
        result,
        error=_hypot(_spread([s.critical for s in samples]), spacing / np.sqrt(12)),
        r_high_error=_spread([s.r_high for s in samples]),
        r_low_error=_spread([s.r_low for s in samples]),
    )


def running_median(
    abscissa: np.ndarray, ordinate: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Median of the ordinate over points within width/2 of each distinct abscissa."""
    places = np.unique(abscissa)
    near = np.abs(abscissa - places[:, np.newaxis]) <= width / 2 + 1e-9
    return places, _medians(ordinate, near)


def _fall(
    velocity: np.ndarray, disorder: np.ndarray, smoothing: float, minimum_contrast: float
) -> Transition:
    step = _step(velocity, disorder, falling=True)
    before = (velocity < step) & (velocity >= step / 2)
    after = (velocity > step) & (velocity <= 2 * step)
    if not before.any() or not after.any():
        return _absent(np.nan, np.nan, velocity.size)
    r_high, r_low = np.median(disorder[before]), np.median(disorder[after])
    if not r_high >= minimum_contrast * r_low:
        return _absent(r_high, r_low, velocity.size)
    places, smooth = running_median(velocity, disorder, smoothing)
    share = (smooth - r_low) / (r_high - r_low)
    above = np.flatnonzero((share >= 0.9) & (places <= step))
    if not above.size:
        return _absent(r_high, r_low, velocity.size)
    below = np.flatnonzero((share <= 0.1) & (places > places[above[-1]]))
    if not below.size:
        return _absent(r_high, r_low, velocity.size)
    lower = _crossing(places, share, above[-1], 0.9)
    upper = _crossing(places, share, below[0] - 1, 0.1)
    middle = (lower + upper) / 2
    return Transition(lower, upper, middle, r_high, r_low, n_points=velocity.size)


def _rise(noise: np.ndarray, disorder: np.ndarray, minimum_rise: float) -> Transition:
    step = _step(noise, disorder, falling=False)
    if not np.isfinite(step):
        return _absent(np.nan, np.nan, noise.size)
    r_low, r_high = np.median(disorder[noise < step]), np.median(disorder[noise > step])
    if not r_high >= minimum_rise * r_low:
        return _absent(r_high, r_low, noise.size)
    places, place = np.unique(noise, return_inverse=True)
    count = np.bincount(place)
    curve = scipy.optimize.isotonic_regression(
        np.bincount(place, disorder) / count, weights=count
    ).x
    share = (curve - r_low) / (r_high - r_low)
    lower, critical, upper = (_first_passage(places, share, level) for level in (0.1, 0.5, 0.9))
    return Transition(lower, upper, critical, r_high, r_low, n_points=noise.size)


def _step(abscissa: np.ndarray, ordinate: np.ndarray, *, falling: bool) -> float:
    """Position of the two-level step of least absolute deviations, midway between points."""
    places = np.unique(abscissa)
    positions = (places[1:] + places[:-1]) / 2
    before = abscissa < positions[:, np.newaxis]
    first, last = _medians(ordinate, before), _medians(ordinate, ~before)
    levels = np.where(before, first[:, np.newaxis], last[:, np.newaxis])
    cost = np.abs(ordinate - levels).sum(axis=1)
    cost[(first > last) != falling] = np.inf
    if not np.isfinite(cost.min()):
        return np.nan
    as_good = cost <= cost.min() * (1 + 1e-9)  # a tie is not left to the rounding of the sums
    return float(positions[np.argmax(as_good)])


def _medians(values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Median of the values that each row of the mask (M, P) chooses, at least one."""
    in_order = np.sort(np.where(chosen, values, np.inf), axis=1)
    row, count = np.arange(len(chosen)), np.count_nonzero(chosen, axis=1)
    return (in_order[row, (count - 1) // 2] + in_order[row, count // 2]) / 2


def _crossing(places: np.ndarray, share: np.ndarray, index: int, level: float) -> float:
    """Where the curve passes `level` between places[index] and the next one."""
    if index + 1 >= places.size or share[index] == share[index + 1]:
        return float(places[index])
    part = (share[index] - level) / (share[index] - share[index + 1])
    return float(places[index] + np.clip(part, 0, 1) * (places[index + 1] - places[index]))


def _first_passage(places: np.ndarray, share: np.ndarray, level: float) -> float:
    index = int(np.argmax(share >= level))
    if share[index] < level:
        return float(places[-1])
    if index == 0:
        return float(places[0])
    return _crossing(places, share, index - 1, level)


def _absent(r_high: float, r_low: float, n_points: int) -> Transition:
    return Transition(np.nan, np.nan, np.nan, r_high, r_low, found=False, n_points=n_points)


def _sorted(
    abscissa: npt.ArrayLike, ordinate: npt.ArrayLike, minimum: int = MINIMUM_POINTS
) -> tuple[np.ndarray, np.ndarray]:
    abscissa, ordinate = (np.asarray(values, dtype=float) for values in (abscissa, ordinate))
    finite = np.isfinite(abscissa) & np.isfinite(ordinate)
    abscissa, ordinate = abscissa[finite], ordinate[finite]
    places = np.unique(abscissa).size
    require(places >= minimum, f"{places} points along the curve, {minimum} are needed")
    order = np.argsort(abscissa, kind="stable")
    return abscissa[order], ordinate[order]


def _spread(values: npt.ArrayLike) -> float:
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    return float(np.std(values)) if values.size > 1 else np.nan


def _hypot(first: float, second: float) -> float:
    return float(np.hypot(np.nan_to_num(first), second))

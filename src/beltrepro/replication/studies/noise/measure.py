"""Where r rises with noise, over runs with noise."""

import numpy as np

from beltrepro.stats import transitions
from beltrepro.stats.estimates import Estimate

NO_NOISE = 0.0


def rise(
    noise: np.ndarray, disorder: np.ndarray, *, above: float = NO_NOISE
) -> dict[str, Estimate]:
    """The rise of r along sigma at noise levels above one: those without noise are a set apart."""
    noisy = noise > above
    return transitions.rise(noise[noisy], disorder[noisy])

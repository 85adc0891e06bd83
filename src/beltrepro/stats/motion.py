"""Names for the motion of a chain, by recurrence and exponents, not by the look of a diagram."""

import numpy as np
import numpy.typing as npt

EQUILIBRIUM = "equilibrium slip"
PERIODIC = "periodic"
QUASI_PERIODIC = "quasi-periodic"
CHAOTIC = "chaotic"
TRANSIENT = "transient"
NOISE_DRIVEN = "noise-driven"
MOTIONS = (EQUILIBRIUM, PERIODIC, QUASI_PERIODIC, CHAOTIC, TRANSIENT, NOISE_DRIVEN)

# Standard errors by which an exponent must differ from zero, and e-foldings that it must bring
# about in the time of observation: less cannot be told from a change of the vector within a period.
ERRORS = 3.0
FOLDINGS = 5.0
# Returns to a section in which a deviation would have grown by e, or shrunk, if its exponent were
# not zero: the statement that it is zero needs a time that long. The chains that are chaotic take
# some ten returns.
RETURNS = 200


def margin(standard_error: npt.ArrayLike, time: npt.ArrayLike) -> np.ndarray:
    """How far from zero an exponent must be to be told from it."""
    errors, times = (np.asarray(values, dtype=float) for values in (standard_error, time))
    with np.errstate(divide="ignore"):
        return np.maximum(ERRORS * errors, FOLDINGS / times)


def above_zero(
    exponent: npt.ArrayLike, standard_error: npt.ArrayLike, time: npt.ArrayLike
) -> np.ndarray:
    """Whether exponents are above zero, beyond doubt."""
    return np.asarray(exponent, dtype=float) > margin(standard_error, time)


def name_motion(
    *,
    turns: bool,
    closed: bool,
    exponents: npt.ArrayLike,
    standard_error: npt.ArrayLike,
    time: float,
    returns: int,
    n_trivial: int = 1,
    noisy: bool = False,
) -> str:
    """Name of a motion from what was observed of it for some time: the criteria of docs/chaos.md.

    turns : whether blocks stick or reverse to the end. closed : whether the state comes back.
    exponents : the largest. returns : to a section. n_trivial : exponents that are zero by the
    symmetries of the motion; with more of them the motion fills a torus.
    """
    if not turns:
        return EQUILIBRIUM
    if closed:
        return PERIODIC
    values = np.asarray(exponents, dtype=float)
    if np.any(above_zero(values, standard_error, time)):
        return CHAOTIC
    least = margin(standard_error, time)
    resolved = least * time * RETURNS <= returns
    if noisy:  # where motions under the same noise do not separate, it is irregular as the noise is
        return NOISE_DRIVEN if np.all(resolved | (values < -least)) else TRANSIENT
    if np.sum(resolved & (np.abs(values) <= least)) > n_trivial:
        return QUASI_PERIODIC
    return TRANSIENT

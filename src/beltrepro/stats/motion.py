"""Names for the motion of a chain, by recurrence and exponents, not by the look of a diagram.

A deterministic motion whose full state comes back has been periodic from there on, whatever its
period. So a sequence of states at successive crossings of a surface settles the question that a
sequence of one of their coordinates leaves open, to a distance that is far below the size of the
orbit and above rounding.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

EQUILIBRIUM = "equilibrium slip"
PERIODIC = "periodic"
QUASI_PERIODIC = "quasi-periodic"
CHAOTIC = "chaotic"
TRANSIENT = "transient"
NOISE_DRIVEN = "noise-driven"
STABLE_CHAOS = "stable chaos"  # Politi, Livi, Oppo, Kapral, Europhys. Lett. 22, 571 (1993)
UNSETTLED = (CHAOTIC, STABLE_CHAOS, TRANSIENT)
MOTIONS = (EQUILIBRIUM, PERIODIC, QUASI_PERIODIC, *UNSETTLED, NOISE_DRIVEN)

# Standard errors by which an exponent must differ from zero, and e-foldings that it must bring
# about in the time of observation: less cannot be told from a change of the vector within a period.
ERRORS = 3.0
FOLDINGS = 5.0
# Returns to a section in which a deviation would have grown by e, or shrunk, if its exponent were
# not zero: the statement that it is zero needs a time that long. The chains that are chaotic take
# some ten returns.
RETURNS = 200
_FEWEST = 20  # returns of motion that is called irregular though it contracts
# Share of the time in which deviations must shrink as far as to the distance at which states count
# as one: what approaches an orbit has come back by then, and only irregular motion has not.
_HALF = 0.5


def resolution(standard_error: npt.ArrayLike, time: npt.ArrayLike) -> np.ndarray:
    """How far from zero an exponent must be to be told from it."""
    errors, times = (np.asarray(values, dtype=float) for values in (standard_error, time))
    with np.errstate(divide="ignore"):
        return np.maximum(ERRORS * errors, FOLDINGS / times)


def above_zero(
    exponent: npt.ArrayLike, standard_error: npt.ArrayLike, time: npt.ArrayLike
) -> np.ndarray:
    """Whether exponents are above zero, beyond doubt."""
    return np.asarray(exponent, dtype=float) > resolution(standard_error, time)


def name_motion(
    *,
    slides: bool,
    closed: bool,
    exponents: npt.ArrayLike,
    standard_error: npt.ArrayLike,
    time: float,
    returns: int,
    nontrivial: tuple[float, float] = (np.nan, np.nan),
    n_trivial: int = 1,
    noisy: bool = False,
) -> str:
    """Name of a motion from what was observed of it for some time: the criteria of docs/chaos.md.

    slides : whether all blocks slip on to the end. closed : whether the state comes back.
    exponents : the largest. returns : to a section. nontrivial : the largest exponent but those
    that are zero by the symmetries of the motion, and its error. n_trivial : how many are; with
    more of them the motion fills a torus.
    """
    if slides:
        return EQUILIBRIUM
    if closed:
        return PERIODIC
    values = np.asarray(exponents, dtype=float)
    if np.any(above_zero(values, standard_error, time)):
        return CHAOTIC
    least = resolution(standard_error, time)
    resolved = least * time * RETURNS <= returns
    if noisy:  # where motions under the same noise do not separate, it is irregular as the noise is
        return NOISE_DRIVEN if np.all(resolved | (values < -least)) else TRANSIENT
    if np.sum(resolved & (np.abs(values) <= least)) > n_trivial:
        return QUASI_PERIODIC
    exponent, error = nontrivial
    if returns < _FEWEST:
        return TRANSIENT
    if exponent < -resolution(error, time) and -exponent * time * _HALF > -np.log(CLOSED):
        return STABLE_CHAOS
    return TRANSIENT


# --- recurrence -----------------------------------------------------------------------------------

# Distance of two states, as a share of their largest coordinate, at which they count as one. An
# orbit that attracts approaches itself by a constant factor each period and soon is as near as
# rounding, 1e-12, allows; the states of an irregular motion of 1e5 crossings come no nearer to each
# other than 1e-5.
CLOSED = 1e-8
NEAR = 1e-6  # the same of two states of an orbit that is still approached
_FAR, _MOVED = 1.1, 1.001  # times the last distance: those before tell how distances shrink


class Recurrence(NamedTuple):
    """A closed orbit."""

    crossings: int  # crossings of the surface in a period
    time: float  # length of a period, the unit of the times given
    since: int  # index of the first state from which on all states are a period apart
    back: float  # time after which states come back: two periods, beside a period doubling


def find_recurrence(
    states: npt.ArrayLike,
    times: npt.ArrayLike,
    *,
    closed: float = CLOSED,
    distance: float = 0.0,
    crossings: int = 1,
) -> Recurrence | None:
    """The period of a sequence of states at successive crossings, None if it does not close.

    The smallest number p of crossings is sought after which every state of the last p comes back,
    so that a period up to half the sequence can be found, and none in fewer than three states.

    Disturbances, for instance by a scheme that moves events to its steps, keep a motion from coming
    nearer to an earlier state than some `distance`. Irregular motion comes as near to one of many
    earlier states now and then, but does not stay there. So then many `crossings` must come back.
    """
    states, times = np.asarray(states, dtype=float), np.asarray(times, dtype=float)
    if len(states) < 3:
        return None
    size = float(np.abs(states).max())
    limit = max(closed * size, distance)
    last = np.abs(states[:-1] - states[-1]).max(axis=1)[::-1]
    for period in (np.flatnonzero(last[: len(states) // 2] <= limit) + 1).tolist():
        apart = np.abs(states[period:] - states[:-period]).max(axis=1)
        latest = apart[-max(period, crossings) :]
        if len(latest) >= crossings and np.all(latest <= limit):
            least = _least_period(states, period, max(NEAR * size, limit))
            since = int(np.flatnonzero(np.append(True, apart > limit))[-1])
            time = float(times[-1] - times[-1 - least])
            if least % 2 == 0 and not distance and _halves_meet(states, least):
                return Recurrence(least // 2, time / 2, since, time)
            return Recurrence(least, time, since, time)
    return None


def _least_period(states: np.ndarray, period: int, near: float) -> int:
    """The least part of a period after which states come near to each other all the same."""
    # an orbit that is approached from alternate sides closes after two periods first
    for part in (part for part in range(1, period) if period % part == 0):
        if np.abs(states[-period:] - states[-period - part : -part]).max() <= near:
            return part
    return period


def _halves_meet(states: np.ndarray, period: int) -> bool:
    """Whether states half a period apart come nearer to each other, in the end without limit."""
    apart = np.abs(states[period // 2 :] - states[: -(period // 2)]).max(axis=1)
    sizes = apart[len(apart) % period :].reshape(-1, period).max(axis=1)  # in each period
    last = len(sizes) - 1
    first = max(np.flatnonzero(sizes > _FAR * sizes[last]), default=0)
    if last - first < 2 or sizes[first] < _MOVED * sizes[last]:
        return False
    # beside a period doubling a size s loses the share d + c s^2 of it in a period: is d > 0?
    places = np.array([first, (first + last) // 2, last])
    early, late = -np.diff(np.log(sizes[places])) / np.diff(places)
    return bool(late * sizes[first] > early * sizes[last] > 0)

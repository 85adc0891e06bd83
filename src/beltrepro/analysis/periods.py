"""Lengths of the periods that runs end on, in time and in slips: which orbits, and how often."""

from typing import Any

import numpy as np
import numpy.typing as npt

from beltrepro.analysis.motion import PERIODIC

# Share by which the periods of two runs on one orbit may differ: states count as one that differ by
# less than 1e-8, and a period is shorter than the time in which it was found.
SAME = 1e-6
QUARTILES = (0.25, 0.5, 0.75)


def tell_orbits(
    period_time: npt.ArrayLike, period_events: npt.ArrayLike, *, same: float = SAME
) -> np.ndarray:
    """Which runs of one chain are on one orbit: those of equal period, in time and in slips.

    Parameters
    ----------
    period_time : array (M,)
        Length of the period of each run, model time; NaN for a run that is on none.
    period_events : array (M,)
        Slips of all blocks in it.
    same : float
        Share by which two times that count as equal may differ.

    Returns
    -------
    array (M,) of int
        Number of the orbit, from 0 by rising slips and time; -1 for a run that is on none.
    """
    time, slips = np.asarray(period_time, dtype=float), np.asarray(period_events, dtype=float)
    closed = np.flatnonzero(np.isfinite(time))
    order = closed[np.lexsort((time[closed], slips[closed]))]
    other_slips = np.diff(slips[order], prepend=-1) != 0
    other_time = np.diff(time[order], prepend=-np.inf) > same * time[order]
    number = np.full(time.shape, -1)
    number[order] = np.cumsum(other_slips | other_time) - 1
    return number


def orbits_reached(runs: Any) -> dict[str, np.ndarray]:
    """The distribution of periods: how many runs of each chain end on each orbit.

    Parameters
    ----------
    runs : Dataset of kind settling or motion, or its arrays (P,)
        Arrays n_blocks, belt_velocity, state, period_time, period_events, period_returns and
        disorder_parameter.

    Returns
    -------
    dict of arrays (O,)
        A row for each orbit, by rising n_blocks, belt_velocity, slips and time: period_time, mean
        of the runs; period_events, period_returns and disorder_parameter of the first run on it;
        runs on it, and their share of all runs of this chain.
    """
    rows = []
    for chain, arrays in _chains(runs):
        number = tell_orbits(_closed_times(arrays), arrays["period_events"])
        for orbit in range(number.max(initial=-1) + 1):
            on_it = number == orbit
            first = {
                name: arrays[name][on_it][0]
                for name in ("period_events", "period_returns", "disorder_parameter")
            }
            counts = {"runs": int(on_it.sum()), "share": float(on_it.mean())}
            rows.append(
                chain | {"period_time": arrays["period_time"][on_it].mean()} | first | counts
            )
    return _columns(rows, _REACHED)


def period_quantiles(
    runs: Any, *, quantiles: tuple[float, ...] = QUARTILES
) -> dict[str, np.ndarray]:
    """Quantiles of the periods that the runs of each chain end on, in time and in slips.

    Parameters
    ----------
    runs : Dataset of kind settling or motion, or its arrays (P,)
        As for `orbits_reached`.
    quantiles : tuple of float
        Shares, between 0 and 1. Each periodic run counts once.

    Returns
    -------
    dict of arrays (C,)
        A row for each chain, by rising n_blocks and belt_velocity: runs; periodic, how many of them
        end on an orbit; orbits, how many different ones; longest_time and longest_events; and
        time_25, events_25 and so on for each quantile, NaN without a periodic run.
    """
    rows = []
    for chain, arrays in _chains(runs):
        times = _closed_times(arrays)
        closed = np.isfinite(times)
        slips = np.where(closed, arrays["period_events"], np.nan)
        number = tell_orbits(times, arrays["period_events"])
        row = chain | {
            "runs": times.size,
            "periodic": int(closed.sum()),
            "orbits": int(number.max(initial=-1) + 1),
            "longest_time": _quantile(times, 1.0),
            "longest_events": _quantile(slips, 1.0),
        }
        for share in quantiles:
            row[f"time_{100 * share:g}"] = _quantile(times, share)
            row[f"events_{100 * share:g}"] = _quantile(slips, share)
        rows.append(row)
    return _columns(rows, tuple(rows[0]) if rows else ())


_REACHED = (
    "n_blocks",
    "belt_velocity",
    "period_time",
    "period_events",
    "period_returns",
    "disorder_parameter",
    "runs",
    "share",
)


def _chains(runs: Any) -> list[tuple[dict, dict[str, np.ndarray]]]:
    """The arrays of the runs of each chain."""
    arrays = {name: np.asarray(values) for name, values in getattr(runs, "arrays", runs).items()}
    names = ("n_blocks", "belt_velocity")
    keys = np.column_stack([arrays[name] for name in names])
    found = []
    for key in np.unique(keys, axis=0):
        here = np.all(keys == key, axis=1)
        chain = {"n_blocks": int(key[0]), "belt_velocity": float(key[1])}
        found.append((chain, {name: values[here] for name, values in arrays.items()}))
    return found


def _closed_times(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Periods (M,), NaN for runs that are not periodic."""
    return np.where(arrays["state"].astype(str) == PERIODIC, arrays["period_time"], np.nan)


def _quantile(values: np.ndarray, share: float) -> float:
    """By the value of a run, not between two of them."""
    known = values[np.isfinite(values)]
    return float(np.quantile(known, share, method="inverted_cdf")) if known.size else np.nan


def _columns(rows: list[dict], names: tuple[str, ...]) -> dict[str, np.ndarray]:
    return {name: np.array([row[name] for row in rows]) for name in names}

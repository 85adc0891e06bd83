"""Traces of the last block with its laminar phases, as several figures show them."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.stats import intermittency


def phases(series, laminar_time):
    """Begin and end of the laminar phases of the last block after the transient: (L, 2)."""
    about = series.attributes
    span = {"start": about["transient"], "stop": about["duration"]}
    events, n_blocks = series.arrays["events"], about["n_blocks"]
    *_, relative_velocity = panels.last_block(series)
    # without an event the last block rides on the belt for good, or slips for good
    if not np.any(events["block"] == n_blocks) and np.any(relative_velocity != 0):
        return np.array([[span["start"], span["stop"]]])
    return intermittency.last_block_phases(events, n_blocks, laminar_time, **span)


def half_laminar(series, laminar_time, length):
    """(begin, end) of the part of this length, after the transient, nearest to half laminar.

    The earliest of several: of a run that has one motion only, the begin.
    """
    start, stop = (float(series.attributes[name]) for name in ("transient", "duration"))
    begins = np.arange(start, max(stop - length, start) + 1e-6, length / 10)
    laminar = phases(series, laminar_time)
    ends = np.clip(
        laminar, begins[:, np.newaxis, np.newaxis], begins[:, np.newaxis, np.newaxis] + length
    )
    share = np.diff(ends, axis=2).sum(axis=(1, 2)) / length
    begin = float(begins[np.argmin(np.abs(share - 0.5).round(9))])
    return begin, begin + length


def trace(axes, series, laminar_time, window, *, zero=0.0):
    """x_N(t) within `window` = (begin, end), laminar phases shaded and counted in the title.

    zero : instant from which the time on the axis is counted.
    """
    time, position, _ = panels.last_block(series)
    shown = (time >= window[0]) & (time <= window[1])
    panels.trace(axes, time[shown] - zero, position[shown], ylabel=panels.POSITION)
    laminar = phases(series, laminar_time)
    for begin, end in np.clip(laminar, *window) - zero:
        if end > begin:
            axes.axvspan(begin, end, color=style.ORANGE, alpha=0.3, linewidth=0, zorder=0)
    about = series.attributes
    length = about["duration"] - about["transient"]
    share = np.diff(laminar, axis=1).sum() / length if length else 0.0
    many = "1 laminar phase" if len(laminar) == 1 else f"{len(laminar)} laminar phases"
    point = rf"$u = {about['belt_velocity']:g}$, $\sigma = {about['noise']:g}$"
    panels.remark(axes, f"{point}: {many}, {share:.0%} of $t$ = {length:g}")

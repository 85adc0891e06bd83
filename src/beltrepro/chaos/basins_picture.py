"""Basins at a glance: r of the attractors, and which share of the starts reaches each."""

from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

from beltrepro.base.names import SYMBOLS
from beltrepro.simulation.picture import LOOK, put
from beltrepro.stats import estimates

# Told apart by colour-blind readers, and told again after as many.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
_MARKERS = {"periodic": "o", "irregular": "x", "equilibrium slip": "s"}
_BAR = 0.8  # width of a bar as a share of the distance of two


def plot(basins: Any, path: str | Path | None = None) -> Figure:
    """Draw basins; write the figure to a file, or show it."""
    return put(lambda: draw(basins), path, repr(basins))


def draw(basins: Any) -> Figure:
    """Above r, branches as lines; below the shares, one value as bars with their intervals."""
    with matplotlib.style.context(["default", LOOK]):
        figure = Figure(figsize=(5.2, 4.6), layout="constrained")
        disorder, shares = figure.subplots(2, 1)
        _draw_disorder(disorder, basins)
        if basins.values.size > 1:
            _draw_shares(shares, basins)
            shares.sharex(disorder)
        else:
            _draw_share_of_each(shares, basins)
    return figure


def _colour(label: int) -> str:
    return _COLOURS[(label - 1) % len(_COLOURS)]


def _draw_disorder(axes, basins):
    """r of each attractor; a line is one periodic orbit, followed."""
    for label, branch in basins.branches.items():
        axes.plot(branch.parameter, branch.disorder_parameter, color=_colour(label), linewidth=1)
    for state, marker in _MARKERS.items():
        those = [attractor for attractor in basins.attractors if attractor.state == state]
        places = [[one.value for one in those], [one.disorder_parameter for one in those]]
        colours = [_colour(attractor.label) for attractor in those]
        axes.scatter(*places, s=14, marker=marker, c=colours, label=state if those else "")
    symbol = {name: symbol for symbol, name in SYMBOLS.items()}[basins.quantity]
    label = f"${symbol}$" if len(symbol) == 1 else symbol  # Delta_l_max is no formula
    axes.set(xlabel=label, ylabel="$r$", yscale="log")
    axes.legend()


def _draw_shares(axes, basins):
    """Shares of the starts at each value, on top of each other."""
    values = basins.values
    width = _BAR * np.diff(values).min()
    bottom = dict.fromkeys(values.tolist(), 0.0)
    for attractor in basins.attractors:
        share = attractor.reached_by / attractor.starts
        look = {"color": _colour(attractor.label), "edgecolor": "white", "linewidth": 0.3}
        axes.bar(attractor.value, share, width, bottom=bottom[attractor.value], **look)
        bottom[attractor.value] += share
    axes.set(ylabel="share of the starts", ylim=(0, 1))


def _draw_share_of_each(axes, basins):
    """Shares of the starts at the only value."""
    for attractor in basins.attractors:
        share = estimates.share(attractor.reached_by, attractor.starts)
        ends = [[share.value - share.low], [share.high - share.value]]
        colour = _colour(attractor.label)
        axes.bar(attractor.label, share.value, _BAR, yerr=ends, color=colour, capsize=2)
    axes.set(xlabel="attractor", ylabel="share of the starts", ylim=(0, 1))
    axes.set_xticks(basins.labels)

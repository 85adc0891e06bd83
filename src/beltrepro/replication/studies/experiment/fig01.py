"""Fig. 1: the chain on the belt."""

import numpy as np
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch, Rectangle

from beltrepro.replication.drawing import style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(uses=(), number="1")

N_BLOCKS = 5
_BLOCK = 0.62  # side of a block; places of blocks are 1, 2, ... N
_ROLLER = 0.22


@style.styled
def draw(data):
    """Drawing of the model of Sec. III; shows no data."""
    figure = style.page(1.1)
    axes = figure.subplots()
    _wall(axes)
    _belt(axes)
    edges = [0.0]
    for place in 1.35 * np.arange(1, N_BLOCKS + 1):
        _spring(axes, edges[-1], place - _BLOCK / 2)
        _block(axes, place, last=len(edges) == N_BLOCKS)
        edges.append(place + _BLOCK / 2)
    end = edges[-1]
    axes.text(0.5, 0.55, "$k$", ha="center", size=8)
    _measure(axes, end - _BLOCK / 2)
    axes.set(xlim=(-0.35, end + 1.25), ylim=(-0.6, 1.4), aspect="equal")
    axes.axis("off")
    return figure


def _wall(axes):
    axes.add_patch(
        Rectangle((-0.2, -0.55), 0.2, 1.5, facecolor="0.85", edgecolor="0.5", hatch="////", lw=0)
    )
    axes.plot([0, 0], [-0.55, 0.95], color="black", linewidth=1.4)


def _belt(axes):
    begin, end = 0.25, 1.35 * N_BLOCKS + 0.95
    corner, size = (begin + _ROLLER, -2 * _ROLLER), (end - begin - 2 * _ROLLER, 2 * _ROLLER)
    look = {"facecolor": "0.93", "edgecolor": "black", "linewidth": 1.2}
    rounded = f"round,pad=0,rounding_size={_ROLLER}"
    axes.add_patch(FancyBboxPatch(corner, *size, boxstyle=rounded, **look))
    for place in np.linspace(begin + 2 * _ROLLER, end - 2 * _ROLLER, 6):
        centre = (place, -_ROLLER)
        axes.add_patch(Circle(centre, 0.72 * _ROLLER, facecolor="white", edgecolor="0.35"))
        axes.add_patch(Circle(centre, 0.03, color="0.35"))
    _arrow(axes, (end - 0.12, 0.22), (end + 0.62, 0.22), style.VERMILION)
    axes.text(end + 0.25, 0.32, "$u$", ha="center", size=9, color=style.VERMILION)


def _block(axes, place, *, last):
    colour, ink = ("white", "black") if last else ("0.25", "white")
    look = {"facecolor": colour, "edgecolor": "black", "linewidth": 1.2}
    axes.add_patch(Rectangle((place - _BLOCK / 2, 0.02), _BLOCK, _BLOCK, **look))
    axes.text(place, _BLOCK / 2, "$m$", ha="center", va="center", size=8, color=ink)


def _spring(axes, begin, end, *, turns=6, height=0.10):
    middle = _BLOCK / 2
    lead = 0.15 * (end - begin)
    along = np.linspace(begin + lead, end - lead, 40 * turns)
    wave = height * np.sin(np.linspace(0, 2 * np.pi * turns, along.size))
    axes.plot(
        [begin, *along, end], [middle, *(middle + wave), middle], color=style.BLUE, linewidth=0.8
    )


def _measure(axes, place):
    """The position of the last block, from the wall."""
    height = _BLOCK + 0.42
    axes.plot([place] * 2, [_BLOCK + 0.05, height + 0.1], "k:", linewidth=0.8)
    _arrow(axes, (0, height), (place, height), "black", style="<|-|>")
    axes.text(place / 2, height + 0.08, "$x_N$", ha="center", size=9)


def _arrow(axes, begin, end, colour, style="-|>"):
    look = {"arrowstyle": style, "mutation_scale": 7, "color": colour, "linewidth": 1.3}
    axes.add_patch(FancyArrowPatch(begin, end, shrinkA=0, shrinkB=0, **look))

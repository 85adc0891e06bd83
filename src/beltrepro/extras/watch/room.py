"""What stands still in the picture: the belt's edge, the wall and a tape measure, in metres."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from beltrepro.extras.watch import look
from beltrepro.model import ChainParameters
from beltrepro.model.spring import spring_extension
from beltrepro.model.units import LENGTH_M
from beltrepro.replication.camera.scene import Scene

SCENE = Scene()  # sizes of what lies on the belt
_SPACING = SCENE.mark_spacing
BELT_HALF_WIDTH = 0.07
_TAPE_TOP = -BELT_HALF_WIDTH - 0.005
TAPE = (_TAPE_TOP - SCENE.tape_width - 0.01, _TAPE_TOP)  # its edges across the belt, m
ACROSS = (TAPE[0] - 0.03, BELT_HALF_WIDTH + 0.01)
WALL = 0.02

_ROOM_BEYOND = 1.05  # of the length at which the springs balance static friction
_FLATTEST = 60.0  # pixels that the picture has across the belt, also where that is not to scale
_NARROWEST_MARKS, _NARROWEST_NUMBERS = 2.5, 36.0  # pixels from one to the next
_NUMBERED = (10, 20, 50, 100, 200, 500)  # marks from one number to the next


def visible_length(chain: ChainParameters) -> float:
    """Length of belt that a chain needs, in metres."""
    pulls = chain.static_friction * np.arange(chain.n_blocks, 0, -1)
    stretched = (chain.rest_length + spring_extension(pulls, chain)).sum()
    return float(LENGTH_M * stretched * _ROOM_BEYOND)


class Room:
    """The belt under a chain, drawn on axes."""

    def __init__(self, axes: Axes, chain: ChainParameters) -> None:
        box, across = axes.bbox, ACROSS[1] - ACROSS[0]
        # a short chain leaves belt free, so that the picture is as wide as the axes
        widest = across * box.width / box.height - WALL
        self.end = max(visible_length(chain), widest)
        self.pixels_per_metre = box.width / (self.end + WALL)
        to_scale = across * self.pixels_per_metre >= _FLATTEST
        self.pixels_across = self.pixels_per_metre if to_scale else box.height / across
        axes.set(xlim=(-WALL, self.end), ylim=ACROSS, aspect="equal" if to_scale else "auto")
        axes.axis("off")
        height = 2 * BELT_HALF_WIDTH
        corner = (0.0, -BELT_HALF_WIDTH)
        axes.add_patch(Rectangle(corner, self.end, height, facecolor=look.BELT, zorder=1))
        wall = Rectangle((-WALL, -BELT_HALF_WIDTH), WALL, height, hatch="////", linewidth=0)
        wall.set(facecolor=look.ROOM, edgecolor=look.SOFT)
        axes.add_patch(wall)
        self._draw_tape(axes)

    def _draw_tape(self, axes: Axes) -> None:
        """A mark every centimetre from the wall, if there is room; longer ones every ten."""
        pixels = _SPACING * self.pixels_per_metre
        finest = next(each for each in (1, 10, 100) if each * pixels >= _NARROWEST_MARKS)
        numbered = next(each for each in _NUMBERED if each * pixels >= _NARROWEST_NUMBERS)
        marks = np.arange(0, self.end / _SPACING, finest)
        lengths = np.where(marks % 10 == 0, SCENE.long_mark_length, SCENE.mark_length)
        top = TAPE[1]
        lines = [
            [(place, top - length), (place, top)]
            for place, length in zip(_SPACING * marks, lengths, strict=True)
        ]
        thin = min(0.9, 0.3 * finest * pixels)
        # marks lie between pixels where they are
        tape = LineCollection(lines, colors=look.TEXT, linewidths=thin, snap=False)
        axes.add_collection(tape, autolim=False)
        for mark in np.arange(0, self.end / _SPACING - 0.6 * numbered, numbered):
            axes.text(mark * _SPACING, TAPE[0], f"{mark:g}", ha="center", va="top", fontsize=8)
        axes.text(self.end, TAPE[0], "cm", ha="right", va="top", fontsize=8)


def signs_explained() -> list[Line2D]:
    """A legend's lines for the signs of stick and slip."""
    return [
        Line2D([], [], color=colour, marker=shape, linestyle="none", label=words)
        for shape, colour, words in (
            ("s", look.STUCK, "stuck to the belt"),
            ("<", look.SLIPPING, "slips back over the belt"),
            (">", look.SLIPPING, "slips forward"),
        )
    ]

"""The chain on its belt, seen from above, to scale in metres; and its last block in time."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from beltrepro.extras.watch import look
from beltrepro.extras.watch.player import Player
from beltrepro.model import ChainParameters
from beltrepro.model.spring import spring_extension
from beltrepro.model.units import FORCE_N, LENGTH_M, TIME_S
from beltrepro.replication.camera.scene import Scene

SCENE = Scene()  # sizes of what lies on the belt
_SPACING = SCENE.mark_spacing
BLOCK_ALONG, BLOCK_ACROSS = SCENE.block_length, SCENE.block_width
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
    pulls = np.cumsum(chain.by_block("static_friction")[::-1])[::-1]
    stretched = (chain.by_block("rest_length") + spring_extension(pulls, chain)).sum()
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
        finest = next(step for step in (1, 10, 100) if step * pixels >= _NARROWEST_MARKS)
        numbered = next(step for step in _NUMBERED if step * pixels >= _NARROWEST_NUMBERS)
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
    words = "stuck to the belt", "slips back over the belt", "slips forward"
    return [
        Line2D([], [], color=colour, marker=shape, linestyle="none", label=label)
        for (shape, (_, colour)), label in zip(_STATES.items(), words, strict=True)
    ]


_SIGN = 0.018  # m, of a sign; in points at least and at most:
_SIGN_POINTS, _EDGE_POINTS = (5.0, 8.0), (1.0, 2.5)
_BELT_MARKS = 0.1  # m between lines across the belt
# twice as wide as in the scene: a line is harder to see than a spring
_COILS, _COIL_HEIGHT = SCENE.coils, SCENE.spring_width
_RIM = 0.005  # m of black around the white block: nothing bright touches it, so a tracker finds it
_THIN = 1.3  # points; springs without force, and twice that at full colour
_STATES = {"s": (0, look.STUCK), "<": (-1, look.SLIPPING), ">": (1, look.SLIPPING)}


class ChainPicture:
    """Artists that show a chain: belt, springs, blocks and signs of stick and slip."""

    def __init__(self, axes: Axes, player: Player) -> None:
        chain = player.parameters
        self.room = Room(axes, chain)
        points = 72 / axes.figure.dpi  # in a pixel
        sign = float(np.clip(_SIGN * self.room.pixels_per_metre * points, *_SIGN_POINTS))
        edge = float(np.clip(0.3 * sign, *_EDGE_POINTS))
        self._above = (
            BLOCK_ACROSS / 2 + (0.5 * sign + 1.5 * edge) / points / self.room.pixels_across
        )
        # force in newton at which a spring has its full colour: kinetic friction of all blocks
        friction = (chain.by_block("static_friction") * np.maximum(chain.friction_ratio, 0.1)).sum()
        self.strong = FORCE_N * friction
        scale = Normalize(-self.strong, self.strong)
        self.colours = ScalarMappable(scale, look.SPRINGS)
        self.marks = LineCollection([], colors=look.BELT_MARKS, linewidths=1.5, zorder=2)
        self.springs = LineCollection([], cmap=look.SPRINGS, norm=scale, zorder=3)
        black: Any = {"facecolor": look.BLOCK, "linewidth": edge, "zorder": 5}
        white = black | {"facecolor": look.LAST_BLOCK, "zorder": 6}
        sides = BLOCK_ALONG, BLOCK_ACROSS
        self.blocks = [_block(*sides, **black) for _ in range(chain.n_blocks - 1)]
        self.blocks.append(_block(*sides, **white))
        wide = BLOCK_ALONG + 2 * _RIM, BLOCK_ACROSS + 2 * _RIM
        self.rim = _block(*wide, facecolor=look.BLOCK, linewidth=0, zorder=5.5)
        how: Any = {"markersize": sign, "linestyle": "none", "zorder": 7}
        self.signs = {
            shape: Line2D([], [], color=colour, marker=shape, **how)
            for shape, (_, colour) in _STATES.items()
        }
        self.artists = [self.marks, self.springs, self.rim, *self.blocks, *self.signs.values()]
        for artist in self.artists:
            axes.add_artist(artist)
        self.show(player)

    def show(self, player: Player) -> None:
        """Move the artists to where the chain is."""
        places, directions = LENGTH_M * player.positions, player.directions
        self.marks.set_segments(list(_belt_marks(LENGTH_M * player.belt, self.room.end)))
        self.springs.set_segments(list(_springs(places)))
        forces = FORCE_N * player.tensions
        self.springs.set_array(forces)
        strengths = np.minimum(np.abs(forces) / self.strong, 1)
        self.springs.set_linewidth((_THIN * (1 + strengths)).tolist())
        for block, place, direction in zip(self.blocks, places, directions, strict=True):
            block.set_x(place - BLOCK_ALONG / 2)
            block.set_edgecolor(look.STUCK if direction == 0 else look.SLIPPING)
        self.rim.set_x(places[-1] - BLOCK_ALONG / 2 - _RIM)
        for shape, (direction, _) in _STATES.items():
            chosen = places[directions == direction]
            self.signs[shape].set_data(chosen, np.full(len(chosen), self._above))


def _block(along: float, across: float, **how: Any) -> Rectangle:
    """A rectangle in the lane of the blocks, with edges between pixels where they are."""
    return Rectangle((0, -across / 2), along, across, snap=False, **how)


def _belt_marks(moved: float, end: float) -> np.ndarray:
    """Lines across the belt (L, 2, 2) that move with it."""
    places = np.arange(moved % _BELT_MARKS, end, _BELT_MARKS)
    lines = np.empty((len(places), 2, 2))
    lines[:, :, 0] = places[:, None]
    lines[:, :, 1] = -BELT_HALF_WIDTH, BELT_HALF_WIDTH
    return lines


def _springs(places: np.ndarray) -> np.ndarray:
    """Zigzags (N, points, 2) from the wall to the first block, and from block to block."""
    near = np.concatenate([[0.0], places[:-1] + BLOCK_ALONG / 2])
    far = places - BLOCK_ALONG / 2
    along = np.concatenate([[0.0], np.linspace(0.1, 0.9, 2 * _COILS), [1.0]])
    lines = np.empty((len(places), len(along), 2))
    lines[:, :, 0] = near[:, None] + (far - near)[:, None] * along
    lines[:, :, 1] = _COIL_HEIGHT * (-1.0) ** np.arange(len(along))
    lines[:, [0, 1, -2, -1], 1] = 0.0
    return lines


_STEP = 0.05  # the scale of r ends at a multiple of it


class Strips:
    """Two curves that end now, over a span of model time."""

    def __init__(self, length: Axes, disorder: Axes, player: Player, span: float) -> None:
        for axes in (length, disorder):
            axes.set_xlim(-span * TIME_S, 0)
        rest = LENGTH_M * player.parameters.rest_positions[-1]
        length.set(ylim=(0.6 * rest, visible_length(player.parameters)), ylabel="$x_N$ (m)")
        length.tick_params(labelbottom=False)
        disorder.set(ylim=(0, 5 * _STEP), ylabel="$r$", xlabel="seconds of the chain before now")
        self._disorder_axes = disorder
        (self.length,) = length.plot([], [], color=look.TEXT)
        (self.disorder,) = disorder.plot([], [], color=look.TEXT)
        self.artists = [self.length, self.disorder]
        self.show(player)

    def show(self, player: Player) -> bool:
        """Draw the curves up to now."""
        record = player.record
        before = TIME_S * (record.time - player.time)
        self.length.set_data(before, LENGTH_M * record.length)
        self.disorder.set_data(before[-len(record.disorder) :], record.disorder)
        highest = record.disorder.max()
        grows = bool(highest > self._disorder_axes.get_ylim()[1])
        if grows:
            self._disorder_axes.set_ylim(0, _STEP * np.ceil(1.2 * highest / _STEP))
        return grows

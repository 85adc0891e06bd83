"""The chain on its belt, seen from above, to scale in metres."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from beltrepro.extras.watch import look
from beltrepro.extras.watch.player import Player
from beltrepro.extras.watch.room import BELT_HALF_WIDTH, SCENE, Room
from beltrepro.model import ChainParameters
from beltrepro.model.units import FORCE_N, LENGTH_M

BLOCK_ALONG, BLOCK_ACROSS = SCENE.block_length, SCENE.block_width

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
        self.strong = _strong(chain)
        scale = Normalize(-self.strong, self.strong)
        self.colours = ScalarMappable(scale, look.SPRINGS)
        self.marks = LineCollection([], colors=look.BELT_MARKS, linewidths=1.5, zorder=2)
        self.springs = LineCollection([], cmap=look.SPRINGS, norm=scale, zorder=3)
        self.rim = _rim()
        self.blocks = [_block(edge, last=i + 1 == chain.n_blocks) for i in range(chain.n_blocks)]
        self.signs = {shape: _sign(shape, colour, sign) for shape, (_, colour) in _STATES.items()}
        axes.add_collection(self.marks, autolim=False)
        axes.add_collection(self.springs, autolim=False)
        for patch in (self.rim, *self.blocks):
            axes.add_patch(patch)
        for sign in self.signs.values():
            axes.add_line(sign)
        self.artists = [self.marks, self.springs, self.rim, *self.blocks, *self.signs.values()]
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


def _strong(chain: ChainParameters) -> float:
    """Force in newton at which a spring has its full colour: kinetic friction of all blocks."""
    return FORCE_N * chain.n_blocks * chain.static_friction * max(chain.friction_ratio, 0.1)


def _block(edge: float, *, last: bool) -> Rectangle:
    return Rectangle(
        (0, -BLOCK_ACROSS / 2),
        BLOCK_ALONG,
        BLOCK_ACROSS,
        facecolor=look.LAST_BLOCK if last else look.BLOCK,
        linewidth=edge,
        snap=False,  # edges lie between pixels where they are
        zorder=6 if last else 5,
    )


def _rim() -> Rectangle:
    corner = (0, -BLOCK_ACROSS / 2 - _RIM)
    sides = (BLOCK_ALONG + 2 * _RIM, BLOCK_ACROSS + 2 * _RIM)
    return Rectangle(corner, *sides, facecolor=look.BLOCK, linewidth=0, zorder=5.5)


def _sign(shape: str, colour: str, size: float) -> Line2D:
    return Line2D([], [], color=colour, marker=shape, markersize=size, linestyle="none", zorder=7)


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

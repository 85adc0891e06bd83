"""The last block in time: x_N(t) and the disorder parameter, over the last thirty seconds."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from beltrepro.extras.watch import look
from beltrepro.extras.watch.player import Player
from beltrepro.extras.watch.record import KEPT
from beltrepro.extras.watch.room import visible_length
from beltrepro.model.units import LENGTH_M, TIME_S

_STEP = 0.05  # the scale of r ends at a multiple of it


class Strips:
    """Two curves that end now."""

    def __init__(self, length: Axes, disorder: Axes, player: Player) -> None:
        for axes in (length, disorder):
            axes.set_xlim(-KEPT * TIME_S, 0)
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
        self.disorder.set_data(before, record.disorder)
        highest = np.max(record.disorder, initial=0.0)
        grows = bool(highest > self._disorder_axes.get_ylim()[1])
        if grows:
            self._disorder_axes.set_ylim(0, _STEP * np.ceil(1.2 * highest / _STEP))
        return grows

"""The whole picture: a line of numbers, the chain on its belt, x_N(t) and r; and films of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.extras.watch import look
from beltrepro.extras.watch.player import KEPT, Clock, Player
from beltrepro.extras.watch.scenery import ChainPicture, Strips, signs_explained
from beltrepro.model.units import LENGTH_M, TIME_S, VELOCITY_M_S

SIZE = (12.8, 7.2)  # inches; at 100 dots an inch a film of 1280 by 720
DOTS = 100
_LEFT, _RIGHT = 0.06, 0.97


class View:
    """Draws a player. What stands still is drawn once, the rest again for each frame."""

    def __init__(
        self,
        player: Player,
        clock: Clock,
        figure: Figure | None = None,
        *,
        foot: float = 0.0,
        span: float = KEPT,
    ) -> None:
        with matplotlib.style.context(look.STYLE):
            if figure is None:
                figure = Figure(figsize=SIZE, dpi=DOTS, facecolor=look.ROOM)
                FigureCanvasAgg(figure)
            self.figure = figure
            self._compose(player, foot, span)
        self._still: Any = None
        self.show(player, clock)
        for artist in self._moving:
            artist.set_animated(self.canvas.supports_blit)
        self.canvas.mpl_connect("draw_event", self._drawn)

    def _compose(self, player: Player, foot: float, span: float) -> None:
        width, unit = _RIGHT - _LEFT, 1 - foot
        belt = self.figure.add_axes((_LEFT, foot + 0.52 * unit, width, 0.31 * unit))
        length = self.figure.add_axes((_LEFT, foot + 0.27 * unit, width, 0.22 * unit))
        disorder = self.figure.add_axes((_LEFT, foot + 0.10 * unit, width, 0.14 * unit))
        self.picture = ChainPicture(belt, player)
        self.strips = Strips(length, disorder, player, span)
        self.settings = self.figure.text(_RIGHT, 0.955, "", fontsize=13, va="center", ha="right")
        self.numbers = self.figure.text(_LEFT, 0.955, "", fontsize=13, va="center")
        scale = self.figure.add_axes((_LEFT, 0.875, 0.2, 0.014))
        self.figure.legend(
            handles=signs_explained(), loc="upper right", bbox_to_anchor=(_RIGHT, 0.915), ncols=3,
            frameon=False, fontsize=9, borderaxespad=0, handletextpad=0.2,
        )  # fmt: skip
        self.figure.colorbar(self.picture.colours, cax=scale, orientation="horizontal")
        scale.set_title("pull of a spring (N): below 0 compressed", fontsize=9, pad=3, loc="left")
        self._moving = [*self.picture.artists, *self.strips.artists, self.numbers]

    @property
    def canvas(self) -> Any:
        """The canvas of the figure."""
        return self.figure.canvas

    def show(self, player: Player, clock: Clock) -> bool:
        """Move all artists to where the chain is, without drawing."""
        self.picture.show(player)
        self.numbers.set_text(_numbers(player))
        before = self.settings.get_text()
        self.settings.set_text(_settings(player, clock))
        return self.strips.show(player) or self.settings.get_text() != before

    def draw(self, player: Player, clock: Clock) -> None:
        """Draw a frame on the canvas."""
        grown = self.show(player, clock)
        if grown or self._still is None:
            self.canvas.draw()  # calls _drawn
            return
        self.canvas.restore_region(self._still)
        self._draw_moving()
        self.canvas.blit(self.figure.bbox)

    def pixels(self) -> np.ndarray:
        """The picture that was drawn last."""
        return np.asarray(self.canvas.buffer_rgba())[:, :, :3].copy()

    @property
    def metres_per_pixel(self) -> float:
        """Scale of the picture of the belt."""
        axes = self.picture.blocks[0].axes
        assert axes is not None
        (begin, _), (end, _) = axes.transData.transform([(0.0, 0.0), (1.0, 0.0)])
        return 1.0 / (end - begin)

    def _drawn(self, event: Any) -> None:
        """After a full drawing: keep what stands still, and draw the rest over it."""
        if self.canvas.supports_blit:
            self._still = self.canvas.copy_from_bbox(self.figure.bbox)
            self._draw_moving()

    def _draw_moving(self) -> None:
        for artist in self._moving:
            self.figure.draw_artist(artist)


def _numbers(player: Player) -> str:
    time_s, record = TIME_S * player.time, player.record
    length_m = LENGTH_M * record.mean_length
    means = f"r = {record.disorder_parameter:.3f}     mean length {length_m:.3f} m"
    return f"t = {time_s:.1f} s     since {TIME_S * record.since:.1f} s: {means}"


def _settings(player: Player, clock: Clock) -> str:
    chain = player.parameters
    parts = [
        "paused" if clock.paused else "",
        f"N = {chain.n_blocks}",
        f"u = {chain.belt_velocity:.4g} ({VELOCITY_M_S * chain.belt_velocity:.2f} m/s)",
        f"σ = {chain.noise:.3g}",
        f"speed × {clock.shown_speed:g}",
    ]
    return "     ".join(filter(None, parts))


def check_film(path: Path, duration: float, clock: Clock) -> None:
    """Check the settings of a film before anything is simulated."""
    if path.suffix.lower() != ".mp4":
        raise InputError(f"output = {path}: must end in .mp4")
    checks.positive("duration", duration)
    if round(duration * clock.frames_per_second) < 1:
        raise InputError(
            f"duration = {duration:g}: a film of at least one frame needs "
            f"{1 / clock.frames_per_second:.3g} s"
        )


def span_of(clock: Clock, duration: float) -> float:
    """Model time over which a film draws its curves: what it shows, so that they are full."""
    frames = round(duration * clock.frames_per_second)
    return min(KEPT, frames * clock.ticks_of_frame * clock.tick)


def write_film(
    path: Path,
    player: Player,
    clock: Clock,
    duration: float,
    progress: Callable[[float], None] | None = None,
) -> View:
    """Write a film of a chain from now on; the file appears under its name when it is complete."""
    from beltrepro.replication.camera.video import Frame, write_video

    rate = clock.frames_per_second
    count = round(duration * rate)
    view = View(player, clock, span=span_of(clock, duration))

    def frames() -> Iterator[Frame]:
        now = player
        for number in range(count):
            now = now.advance(clock.ticks_of_frame if number else 0)
            view.draw(now, clock)
            yield Frame(number / rate, view.pixels())
            if progress:
                progress((number + 1) / count)

    write_video(path, frames(), frames_per_second=rate, preset="medium")
    return view

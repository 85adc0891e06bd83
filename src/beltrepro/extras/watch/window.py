"""The window: frames in real time, keys, and sliders for the belt velocity and the noise."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import matplotlib
import matplotlib.style
from matplotlib.figure import Figure
from matplotlib.widgets import Slider

from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.extras.watch import look
from beltrepro.extras.watch.player import Clock, Player
from beltrepro.extras.watch.view import SIZE, View
from beltrepro.simulation.picture import find_display

KEYS = "space: pause     →: one step     ↑ ↓: faster, slower     c: r from here on     q: close"
NO_DISPLAY = "no display to open a window on: write a film with --output chain.mp4"


class Window:
    """A view that goes on by itself, with keys and sliders."""

    def __init__(self, player: Player, clock: Clock, figure: Figure) -> None:
        self.player, self.clock = player, clock
        self.view = View(player, clock, figure, foot=0.12)
        with matplotlib.style.context(look.STYLE):
            chain = player.parameters
            ends = max(50.0, chain.belt_velocity), max(10.0, chain.noise)  # of the paper's scans
            figure.text(0.06, 0.02, KEYS, fontsize=10, color=look.TEXT)
            self.complaint = figure.text(0.97, 0.02, "", ha="right", color=look.SLIPPING)
            self.velocity = _slider(
                figure, 0.16, "belt velocity u", (0.1, ends[0]), chain.belt_velocity
            )
            self.noise = _slider(figure, 0.62, "noise σ", (0.0, ends[1]), chain.noise)
        figure.canvas.mpl_connect("key_press_event", self._key)
        self._last = time.monotonic()
        self._owed = 0.0  # ticks that are due

    def tick(self, seconds: float) -> None:
        """Go on by a time of the real world, with the sliders as they stand, and draw."""
        clock = self.clock
        if not clock.paused:
            self._owed += min(seconds, 0.25) * clock.frames_per_second * clock.ticks_of_frame
        ticks = int(self._owed)
        self._owed -= ticks
        self._advance(ticks)
        self.view.draw(self.player, self.clock)

    def on_timer(self) -> None:
        """Go on by the time since the last call, but not by a time that the machine slept."""
        now = time.monotonic()
        seconds, self._last = now - self._last, now
        self.tick(seconds)

    def _advance(self, ticks: int) -> None:
        """Go on under what the sliders say; if the chain cannot, say so and wait."""
        law = {"belt_velocity": self.velocity.val, "noise": self.noise.val}
        try:
            self.player = self.player.under(replace(self.player.parameters, **law))
            self.player = self.player.advance(ticks)
        except ModelStateError as error:
            self.clock = replace(self.clock, paused=True)
            self.complaint.set_text(str(error))
            self.view.canvas.draw_idle()

    def _key(self, event: Any) -> None:
        if event.key == " ":
            self.clock = replace(self.clock, paused=not self.clock.paused)
        elif event.key == "right":
            self.clock = replace(self.clock, paused=True)
            self._advance(self.clock.ticks_of_frame)
        elif event.key in ("up", "down"):
            self.clock = self.clock.changed(1 if event.key == "up" else -1)
        elif event.key == "c":
            self.player = self.player.anew()
        self.view.draw(self.player, self.clock)


def check_display() -> None:
    """Check that a window can be opened; a notebook is none."""
    if not find_display(NO_DISPLAY):
        raise InputError(NO_DISPLAY)


def open_window(player: Player, clock: Clock) -> None:
    """Show a chain in a window until it is closed."""
    check_display()
    import matplotlib.pyplot as plt

    # the keys of the window are its own
    keys: dict[str, Any] = {name: [] for name in matplotlib.rcParams if name.startswith("keymap.")}
    keys |= {"keymap.quit": ["q"], "toolbar": "None"}
    matplotlib.rcParams.update(keys)  # type: ignore[arg-type]
    with matplotlib.style.context(look.STYLE):
        figure = plt.figure("beltrepro watch", figsize=SIZE)
    window = Window(player, clock, figure)
    chain = player.parameters  # compile for chains with and without noise before a slider moves
    player.under(replace(chain, noise=0.0 if chain.noise > 0 else 1.0))
    timer = figure.canvas.new_timer(interval=round(1000 / clock.frames_per_second))
    timer.add_callback(window.on_timer)
    figure.canvas.mpl_connect("close_event", lambda event: timer.stop())
    timer.start()
    plt.show()


def _slider(figure: Figure, left: float, name: str, ends: tuple[float, float], now: float) -> Any:
    axes = figure.add_axes((left, 0.065, 0.3, 0.03))
    handle = {"facecolor": look.TEXT, "edgecolor": look.ROOM}
    colours: Any = {"color": look.STUCK, "track_color": look.BELT, "initcolor": "none"}
    slider = Slider(axes, name, *ends, valinit=now, valfmt="%.2f", handle_style=handle, **colours)
    slider.label.set_x(-0.04)  # beside the handle, also where that stands at 0
    return slider

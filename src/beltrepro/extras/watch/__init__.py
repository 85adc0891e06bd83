"""Watching a chain in real time: in a window, or as a film.

`Player` is a value: what is shown at an instant, and how it goes on. `Clock` says how much of it a
frame takes. `View` draws a player; `Window` and `write_film` make frames of it.
"""

from beltrepro.extras.watch.player import Clock, Player, begin
from beltrepro.extras.watch.view import View, check_film, write_film
from beltrepro.extras.watch.window import Window, check_display, open_window

__all__ = [
    "Clock",
    "Player",
    "View",
    "Window",
    "begin",
    "check_display",
    "check_film",
    "open_window",
    "write_film",
]

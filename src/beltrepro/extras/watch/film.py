"""A film of a chain as it is watched: an mp4 file, or a gif by Pillow."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb

from beltrepro.base import checks
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.extras.watch import look
from beltrepro.extras.watch.clock import Clock
from beltrepro.extras.watch.player import Player
from beltrepro.extras.watch.view import View

SUFFIXES = (".mp4", ".gif")
_GIF_FRAMES_PER_SECOND = 50.0  # browsers show shorter frames of a gif longer


def check_film(path: Path, duration: float, clock: Clock) -> None:
    """Check the settings of a film before anything is simulated."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"output = {path}: must end in .mp4 or .gif")
    if path.is_dir() or not path.absolute().parent.is_dir():
        problem = "is a folder" if path.is_dir() else "its folder does not exist"
        raise InputError(f"output = {path}: {problem}")
    checks.positive("duration", duration)
    if frames_of(duration, clock) < 1:
        raise InputError(
            f"duration = {duration:g}: a film of at least one frame needs "
            f"{1 / clock.frames_per_second:.3g} s"
        )
    if path.suffix.lower() == ".gif" and clock.frames_per_second > _GIF_FRAMES_PER_SECOND:
        raise InputError(
            f"fps = {clock.frames_per_second:g}: a gif has at most {_GIF_FRAMES_PER_SECOND:g}"
        )


def frames_of(duration: float, clock: Clock) -> int:
    """How many frames a film has."""
    return round(duration * clock.frames_per_second)


def write_film(
    path: Path,
    player: Player,
    clock: Clock,
    duration: float,
    progress: Callable[[float], None] | None = None,
) -> View:
    """Write a film of a chain from now on; the file appears under its name when it is complete."""
    check_film(path, duration, clock)
    from beltrepro.replication.camera.video import Frame, write_video

    view = View(player, clock)
    count, rate = frames_of(duration, clock), clock.frames_per_second
    pictures = _pictures(view, player, clock, count, progress or (lambda fraction: None))
    if path.suffix.lower() == ".gif":
        with replacing(path) as part:
            _write_gif(part, pictures, count, rate)
    else:
        frames = (Frame(number / rate, picture) for number, picture in enumerate(pictures))
        write_video(path, frames, frames_per_second=rate, preset="medium")
    return view


def _pictures(
    view: View, player: Player, clock: Clock, count: int, progress: Callable[[float], None]
) -> Iterator[np.ndarray]:
    for number in range(count):
        player = player.advance(clock.ticks_of_frame if number else 0)
        view.draw(player, clock)
        yield view.pixels()
        progress((number + 1) / count)


def _write_gif(path: Path, shown: Iterator[np.ndarray], count: int, rate: float) -> None:
    from PIL import Image

    # a gif counts in hundredths of a second; rounded instants, not durations, keep its length
    instants = np.round(100 * np.arange(count + 1) / rate)
    first = next(shown)
    palette = _palette(first)
    pictures = (
        Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
        for picture in itertools.chain([first], shown)
    )
    next(pictures).save(
        path,
        save_all=True,
        append_images=pictures,
        duration=[10 * int(length) for length in np.diff(instants)],
        loop=0,
    )


def _palette(picture: np.ndarray) -> Any:
    """The 256 colours of a gif: those that tell something exactly, and those of a frame."""
    from PIL import Image

    telling = [*map(to_rgb, (look.STUCK, look.SLIPPING)), *look.SPRINGS(np.linspace(0, 1, 62))]
    exact = [round(255 * each) for colour in telling for each in colour[:3]]
    others = 256 - len(telling)
    found = Image.fromarray(picture).quantize(others).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette([*exact, *found[: 3 * others]])
    return palette

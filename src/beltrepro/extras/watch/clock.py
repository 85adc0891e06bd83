"""How fast a chain is shown: model time for each frame, in whole ticks."""

from __future__ import annotations

from dataclasses import dataclass, replace

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.model.units import TIME_S

DOUBLINGS = 4  # of the speed, up or down by keys
SPEEDS = (0.05, 50.0)
FRAMES_PER_SECOND = (1.0, 120.0)


@dataclass(frozen=True)
class Clock:
    """How fast a chain is shown, and whether it is paused.

    A frame shows a whole number of ticks. At the slowest speed it is one, so that any speed within
    reach of the keys shows instants of one grid.
    """

    # seconds of the chain in a second of the film, without doublings; 1 is real time. From 0.05
    # to 50
    speed: float = 1.0
    frames_per_second: float = 24.0  # from 1 to 120
    # how often the speed was doubled; negative where it was halved. From -4 to 4
    doublings: int = 0
    paused: bool = False  # whether frames stand still

    def __post_init__(self) -> None:
        for name, (low, high) in {"speed": SPEEDS, "fps": FRAMES_PER_SECOND}.items():
            field = "frames_per_second" if name == "fps" else name
            value = checks.finite_number(name, getattr(self, field))
            if not low <= value <= high:
                raise InputError(f"{name} = {value:g}: must be from {low:g} to {high:g}")
            object.__setattr__(self, field, value)

    @property
    def tick(self) -> float:
        """Model time of a tick."""
        # a power of two: instants on the grid of ticks are also those on the grid of frames
        return self.speed / self.frames_per_second / TIME_S / 2**DOUBLINGS

    @property
    def ticks_of_frame(self) -> int:
        """Ticks from one frame to the next: 0 when paused."""
        return 0 if self.paused else self.ticks_of_step

    @property
    def ticks_of_step(self) -> int:
        """Ticks of a single step: those of a frame, also when paused."""
        return 2 ** (DOUBLINGS + self.doublings)

    @property
    def shown_speed(self) -> float:
        """Seconds of the chain in a second, with doublings."""
        return self.speed * 2.0**self.doublings

    def toggled(self) -> Clock:
        """Paused if it ran, running if it was paused."""
        return replace(self, paused=not self.paused)

    def stopped(self) -> Clock:
        """Paused."""
        return replace(self, paused=True)

    def changed(self, doublings: int) -> Clock:
        """Faster or slower, as far as the speed goes."""
        wanted = self.doublings + doublings
        return replace(self, doublings=max(-DOUBLINGS, min(DOUBLINGS, wanted)))

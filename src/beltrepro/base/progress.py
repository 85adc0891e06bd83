"""How far a computation is: a bar on a terminal, lines in a log."""

import logging
import sys
import time

from tqdm import tqdm

logger = logging.getLogger("beltrepro")


class Progress:
    """Shows how far a simulation is; call it with the fraction done, 0 to 1.

    On a terminal a bar; in a job of the workflow, or without a terminal, a line at the start and
    then every few percent, with the time left: in the log, or on stderr if there is none.

    Parameters
    ----------
    label : str
        What is being computed.
    every : float
        Fraction between lines.
    pause : float
        Seconds between lines, at least.
    bar : bool, optional
        Forces a bar (True) or lines (False).
    """

    def __init__(
        self, label: str, *, every: float = 0.05, pause: float = 1.0, bar: bool | None = None
    ) -> None:
        self._label = label
        self._every, self._pause = every, pause
        self._start = self._last = time.monotonic()
        self._shown = 0.0
        self._bar = None
        is_seen = sys.stderr and sys.stderr.isatty() and not _has_log()  # None if it is closed
        if is_seen if bar is None else bar:
            self._bar = tqdm(total=100, desc=label, unit="%", bar_format=_BAR)
        else:
            self._line("started")

    def __call__(self, fraction: float) -> None:
        if self._bar is not None:
            self._bar.update(100 * fraction - self._bar.n)
            if fraction >= 1:
                self._bar.close()
            return
        now = time.monotonic()
        is_far = fraction >= self._shown + self._every - 1e-9  # ten steps of 0.05 are less than 0.5
        if (is_far and now >= self._last + self._pause) or fraction >= 1 > self._shown:
            left = (now - self._start) * (1 - fraction) / fraction
            self._line(f"{100 * fraction:.0f}% done, {tqdm.format_interval(left)} left")
            self._shown, self._last = fraction, now

    def _line(self, text: str) -> None:
        if _has_log():
            logger.info("%s: %s", self._label, text)
        elif sys.stderr:
            print(f"{self._label}: {text}", file=sys.stderr, flush=True)


_BAR = "{desc}: {percentage:3.0f}%|{bar}| {elapsed}, {remaining} left"


def _has_log() -> bool:
    """Whether somebody keeps a log, as each job of the workflow does."""
    return logger.isEnabledFor(logging.INFO) and logger.hasHandlers()

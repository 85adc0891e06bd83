"""How far a computation is: a bar on a terminal, lines in a log."""

import logging
import sys
import time

logger = logging.getLogger("beltrepro")

_lines_only = False


def quiet_terminal() -> None:
    """Lines in the log from now on, also on a terminal: a job of the workflow has one."""
    global _lines_only
    _lines_only = True


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
        if bar if bar is not None else sys.stderr.isatty() and not _lines_only:
            from tqdm import tqdm

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
        far_enough = fraction >= self._shown + self._every - 1e-9
        due = far_enough and now >= self._last + self._pause
        if due or fraction >= 1 > self._shown:
            left = (now - self._start) * (1 - fraction) / fraction
            self._line(f"{100 * fraction:.0f}% done, {_duration(left)} left")
            self._shown, self._last = fraction, now

    def _line(self, text: str) -> None:
        """A line in the log, or on stderr where nobody keeps one."""
        if logger.isEnabledFor(logging.INFO) and logger.hasHandlers():
            logger.info("%s: %s", self._label, text)
        else:
            print(f"{self._label}: {text}", file=sys.stderr, flush=True)


_BAR = "{desc}: {percentage:3.0f}%|{bar}| {elapsed}, {remaining} left"


def _duration(seconds: float) -> str:
    """Seconds as text of at most two units: "40 s", "3 min 20 s", "2 h 5 min"."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"

"""What every script of the workflow shares: its log, its errors in one line, its progress."""

import logging
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from beltrepro import lifecycle
from beltrepro.errors import InputError, ModelStateError

logger = logging.getLogger("beltrepro")

_in_job = False


def run(main: Callable[[Any], None], snakemake: Any) -> None:
    """Run one job: call `main(snakemake)` with logging to the rule's log file.

    An error that a user can act on (InputError, ModelStateError) is one line in the log and on
    stderr. Any other leaves its traceback in the log and one line on stderr that points there.
    Both end the process with status 1.

    Parameters
    ----------
    main : callable
        The script's work.
    snakemake : object
        What Snakemake gives to a script: rule, log, input, output, params.
    """
    global _in_job
    _in_job = True
    lifecycle.end_with_parent()
    log = Path(snakemake.log[0])
    log.parent.mkdir(parents=True, exist_ok=True)
    logging.basicConfig(
        filename=log,
        filemode="w",
        format="%(asctime)s %(levelname)s %(message)s",
        datefmt="%H:%M:%S",
        level=logging.INFO,
        force=True,
    )
    logging.captureWarnings(True)
    try:
        main(snakemake)
    except (InputError, ModelStateError) as error:
        logger.error("%s", error)
        sys.exit(f"error in rule {snakemake.rule}: {error}")
    except Exception as error:
        logger.error("%s", traceback.format_exc())
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        sys.exit(f"error in rule {snakemake.rule}: {reason} (traceback in {log})")
    logger.info("done")


def use_threads(threads: int) -> None:
    """Limit Numba to the threads of the job: by itself it takes all cores.

    Parameters
    ----------
    threads : int
        Threads that Snakemake gave to the job.
    """
    import numba  # costs a second that jobs without simulation need not pay

    available = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
    numba.set_num_threads(min(threads, available))


class Progress:
    """Shows how far a simulation is; call it with the fraction done, 0 to 1.

    On a terminal a bar; in a job of the workflow, or without a terminal, a line in the log at the
    start and then every few percent, with the time left.

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
        if bar if bar is not None else sys.stderr.isatty() and not _in_job:
            from tqdm import tqdm

            self._bar = tqdm(total=100, desc=label, unit="%", bar_format=_BAR)
        else:
            logger.info("%s: started", label)

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
            logger.info("%s: %.0f%% done, %s left", self._label, 100 * fraction, _duration(left))
            self._shown, self._last = fraction, now


_BAR = "{desc}: {percentage:3.0f}%|{bar}| {elapsed}, {remaining} left"


def _duration(seconds: float) -> str:
    """Seconds as text of at most two units: "40 s", "3 min 20 s", "2 h 5 min"."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"

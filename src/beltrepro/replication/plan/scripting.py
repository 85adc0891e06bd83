"""What every script of the workflow shares: its log, its errors in one line."""

import logging
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from beltrepro.base import process
from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.replication.plan import lock

logger = logging.getLogger("beltrepro")


def run(main: Callable[[Any], None], snakemake: Any) -> None:
    """Run one job: call `main(snakemake)` with logging to the rule's log.

    An error is one line on stderr, and its first line in the log has " ERROR "; unless a user can
    act on it, a traceback follows there.
    """
    started = time.process_time()
    process.set_right()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends jobs, too: without a traceback
    lock.end_with_run()
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
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        logger.error("%s\n%s", reason, traceback.format_exc())
        sys.exit(f"error in rule {snakemake.rule}: {reason} (traceback in {log})")
    whole = sum(os.times()[:4])  # of processes that it has started, too
    logger.info("done: %.2f s of processor time, %.2f of it to start Python", whole, started)

"""What every script of the workflow shares: its log, its errors in one line."""

import logging
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from beltrepro.base import progress
from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.replication.plan import lifecycle, manifest

logger = logging.getLogger("beltrepro")


def run(main: Callable[[Any], None], snakemake: Any) -> None:
    """Run one job: call `main(snakemake)` with logging to the rule's log file, and list its files.

    An error that a user can act on (InputError, ModelStateError) is one line in the log and on
    stderr. Any other leaves its traceback in the log and one line on stderr that points there.
    Both end the process with status 1.
    """
    progress.quiet_terminal()
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
        manifest.add(Path(*log.parts[:2]), map(Path, snakemake.output))
    except (InputError, ModelStateError) as error:
        logger.error("%s", error)
        sys.exit(f"error in rule {snakemake.rule}: {error}")
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        logger.error("%s\n%s", reason, traceback.format_exc())  # the first line is shown
        sys.exit(f"error in rule {snakemake.rule}: {reason} (traceback in {log})")
    logger.info("done")


def use_threads(threads: int) -> None:
    """Limit Numba to the threads of the job: by itself it takes all cores."""
    import numba  # costs a second that jobs without simulation need not pay

    available = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
    numba.set_num_threads(min(threads, available))

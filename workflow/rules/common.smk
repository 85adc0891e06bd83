# What the rules share: the settings and files of the run, and how it begins and fails.

import logging
import os
import sys
from pathlib import Path

from snakemake.cli import get_argument_parser
from snakemake.logging import logger
from snakemake_interface_logger_plugins.common import LogEvent

from beltrepro.base import process
from beltrepro.base.names import hint
from beltrepro.replication.plan import lock
from beltrepro.replication.plan.workflow import RunProgress, Workflow, one_line


configfile: "config.yaml"


process.set_right()  # jobs inherit what is set here
with one_line():
    FLOW = Workflow(config)
RUN = FLOW.plan.run
FILES = "beltrepro.replication.plan.io"  # code behind what reads or joins files of results
os.environ[lock.RUN] = str(os.getpid())  # jobs must not outlive this process


pathvars:
    results=f"results/{RUN}",
    logs=f"results/{RUN}/logs",
    benchmarks=f"results/{RUN}/benchmarks",


wildcard_constraints:
    **FLOW.wildcards(),


def refuse_unknown_targets():
    """End with one line if the command line asks for what no rule makes."""
    # .../bin/snakemake, or .../snakemake/__main__.py; other programs have arguments of their own
    is_command = workflow.is_main_process and "snakemake" in Path(sys.argv[0]).parts[-2:]
    targets = [one.name for one in workflow.rules if not one.has_wildcards()]
    for name in get_argument_parser().parse_known_args()[0].targets if is_command else ():
        path = os.path.relpath(name)
        is_file = any(one.is_producer(path) for one in workflow.rules)
        if name not in targets and not is_file:
            allowed = f"files of this run and {', '.join(targets)}{hint(name, targets)}"
            sys.exit(f"error: target {name!r}: allowed are {allowed}")


def begin():
    """Before the first job: take the folder of results, and let failed jobs here say it themselves."""
    if 0 in (workflow.resource_settings.cores, workflow.resource_settings.nodes):
        sys.exit("error: --cores or --jobs 0: must be at least 1, or no job ever begins")
    with one_line():
        lock.take(FLOW.results)
    if workflow.local_exec:
        is_terminal = sys.stderr.isatty()
        for handler in logger.handlers:
            if not isinstance(handler, logging.FileHandler):
                handler.addFilter(is_no_news if is_terminal else is_no_failure)
        if is_terminal:
            logger.addHandler(RunProgress())
        # Jobs here need no limit on how many start in a second. Its clock would wake the scheduler
        # once a second for each job that has ended: after 100 of them 100 times a second.
        workflow.scheduler.job_rate_limiter = None


def is_no_failure(record):
    """Whether a record is other than what Snakemake says of a job that has failed."""
    is_error = getattr(record, "event", None) is LogEvent.JOB_ERROR
    return not is_error and "CalledProcessError" not in str(record.msg)


def is_no_news(record):
    """Whether a record says neither of a failed job nor what `RunProgress` shows in one line."""
    return is_no_failure(record) and record.levelno > logging.INFO

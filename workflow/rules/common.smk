# What the rules share: the files and jobs of the run, and how a run begins, stops and fails.

import atexit
import os
import sys

from snakemake.logging import logger

from beltrepro.base import provenance
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import lifecycle, snakemake_call
from beltrepro.replication.plan.failures import Failures
from beltrepro.replication.plan.workflow import Workflow

try:
    if workflow.is_main_process:
        snakemake_call.check_counts(workflow.resource_settings)
    FLOW = Workflow(config)
except InputError as error:
    sys.exit(f"error: {error}")

RUN = FLOW.plan.run

# Claims take long, and wait for nearly all datasets. So these come first, and figures are drawn
# while claims are measured.
BEFORE_FIGURES = 1


pathvars:
    results=f"results/{RUN}",
    logs=f"results/{RUN}/logs",
    benchmarks=f"results/{RUN}/benchmarks",


wildcard_constraints:
    **FLOW.wildcards(),


# --- what a job asks of a cluster ---


def at_attempt(amount):
    """At least half more than the published run took; each attempt asks for as much again."""
    return lambda wildcards, attempt: attempt * amount


# --- beginning, stopping, failing ---

WAS_LOCKED = lifecycle.is_locked(FLOW.results)
os.environ[lifecycle.PARENT] = str(os.getpid())
shell.prefix(lifecycle.JOB_PREFIX)
FAILURES = Failures(logger)
if workflow.is_main_process:
    lifecycle.stop_at_once(FLOW.results)


def begin():
    """Before the first job: take the folder of results, and end at once when told to."""
    try:
        lifecycle.begin(FLOW.results, WAS_LOCKED)
    except InputError as error:
        sys.exit(f"error: {error}")
    if workflow.local_exec:
        lifecycle.stop_at_once(FLOW.results)  # again: Snakemake has taken SIGTERM
        # Jobs here need no limit on how many start in a second. Its clock would wake the scheduler
        # once a second for each job that has ended: after 100 of them 100 times a second.
        workflow.scheduler.job_rate_limiter = None
    else:
        lifecycle.cancel_at_stop()


def refuse_unknown_targets():
    """End with one line if a target of the command line is none; when all rules are known."""
    if workflow.is_main_process:
        snakemake_call.end_if_unknown(
            workflow.rules,
            lambda path: FLOW.is_made(
                path, lambda name: any(rule.is_producer(name) for rule in workflow.rules)
            ),
        )

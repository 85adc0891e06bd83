"""What must be there before jobs are sent to Slurm: one line at once for what cannot work.

The plugin of Snakemake sends the jobs and asks for them. Where a program of Slurm is missing, or
where nothing answers whether a job has ended, it waits for ever; and a partition that there is not
it asks for job by job.
"""

import importlib.util
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable
from typing import Any

from beltrepro.base.errors import InputError
from beltrepro.base.names import hint

PLUGIN = "snakemake_executor_plugin_slurm"
PROGRAMS = ("sbatch", "squeue", "scancel", "sinfo", "sacct")
# the question by which the plugin learns from the database which jobs have ended
ASK_DATABASE = ("sacct", "-X", "--noheader", "--clusters", "all", "--format=JobIdRaw,State")
ASK_DATABASE += ("--starttime", "now", "--endtime", "now", "--name", "beltrepro")
ELSEWHERE = ("cluster", "clusters", "slurm_cluster")  # resources that name other clusters
SECONDS_BETWEEN_QUESTIONS = 180  # of the plugin, at most
_PATIENCE = 60  # seconds for an answer


def end_if_not_installed() -> None:
    """End the process with one line if Snakemake cannot send to Slurm; the profile calls it."""
    if importlib.util.find_spec(PLUGIN) is None:
        sys.exit("error: executor slurm: its plugin is not installed; type `make slurm`")


def prepare(settings: Any, resources: Iterable[Any]) -> None:
    """Refuse what cannot work, and choose the program that says which jobs have ended.

    settings : of the plugin; `status_command` is set where the database of jobs does not answer.
    resources : of the jobs; `slurm_partition` and `slurm_account` are read.
    """
    absent = [name for name in PROGRAMS if shutil.which(name) is None]
    if absent:
        raise InputError(
            f"executor slurm: {', '.join(absent)} not found on the PATH; start Snakemake where the "
            "programs of Slurm are, or without --profile profiles/slurm"
        )
    resources = list(resources)
    if not any(job.get(name) for job in resources for name in ELSEWHERE):
        _check_partitions({str(job.get("slurm_partition") or "") for job in resources} - {""})
    _, error = _answer(*ASK_DATABASE)
    if not error:
        return
    for account in filter(None, (job.get("slurm_account") for job in resources)):
        raise InputError(f"slurm_account={account}: {error}; allowed is None")
    _check_memory_of_jobs(error)
    settings.status_command = "squeue"


def _check_partitions(partitions: set[str]) -> None:
    """Whether Slurm has them; one of them may be several, separated by commas."""
    if not partitions:
        return
    names, error = _answer("sinfo", "--all", "--noheader", "--format=%R")
    if error:
        raise InputError(f"executor slurm: {error}")
    allowed = sorted(set(names.split()))
    for partition in sorted(partitions):
        for name in partition.split(","):
            if name not in allowed:
                raise InputError(
                    f"slurm_partition={partition}: allowed are {', '.join(allowed)}"
                    f"{hint(name, allowed)}"
                )


def _check_memory_of_jobs(error: str) -> None:
    """Without a database of jobs, Slurm must remember those that have ended until it is asked."""
    config, _ = _answer("scontrol", "show", "config")
    age = re.search(r"^MinJobAge\s*=\s*(\d+)", config, re.M)
    if age is None or int(age[1]) <= SECONDS_BETWEEN_QUESTIONS:
        seconds = f"after {age[1]} s" if age else "(MinJobAge is not known)"
        raise InputError(
            f"executor slurm: nothing says which jobs have ended ({error}), and Slurm forgets them "
            f"{seconds}: MinJobAge above {SECONDS_BETWEEN_QUESTIONS} s is needed in slurm.conf"
        )


def _answer(*command: str) -> tuple[str, str]:
    """What a program prints, and why it failed in one line; empty if it did not."""
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=_PATIENCE)
    except OSError as error:
        return "", f"{command[0]}: {error.strerror}"
    except subprocess.TimeoutExpired:
        return "", f"{command[0]}: no answer in {_PATIENCE} s"
    if ended.returncode == 0:
        return ended.stdout, ""
    words = " ".join(ended.stderr.split()) or f"status {ended.returncode}"
    return "", f"{command[0]}: {words.removeprefix(f'{command[0]}: ')}"

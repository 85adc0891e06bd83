"""How long a preset takes on many cores, from the measured time of some of its jobs.

    python -m beltrepro.replication.plan.walltime results/paper/timing.csv --preset paper \\
        --cores 10 100 1000

`snakemake timing` writes timing.csv. Another preset can be judged by it, and so can a variant in a
file of its own (`--config variant.yaml`), as long as it has the same classes of jobs.

Each job goes to the core that is free first, in the order of the plan (list scheduling: R. L.
Graham, Bell System Technical Journal 45, 1563, 1966). This takes at most twice the shortest time
possible. Joining, tables and figures are left out: they take minutes.
"""

from __future__ import annotations

import argparse
import heapq
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from beltrepro.base.errors import InputError
from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.jobs import Job, simulation_jobs
from beltrepro.replication.plan.plan import make_plan

if TYPE_CHECKING:
    import pandas as pd

Seconds = Sequence[float] | np.ndarray
CORES = (1, 10, 100, 1000)
OVERHEAD = 10.0  # seconds: two starts of Snakemake (7 s of processor time measured), and Slurm
RATE = 5.0  # jobs sent in a second; 8 were measured with a Slurm that had nothing else to do


def job_seconds(jobs: Sequence[Job], timing: pd.DataFrame) -> np.ndarray:
    """Time of each job: its work times what a unit of work costs in its class."""
    costs = {
        (row.kind, row.method, row.noise == "with"): row.seconds_per_work
        for row in timing.itertuples()
        if np.isfinite(row.seconds_per_work)
    }
    unknown = {job.cost_class for job in jobs} - costs.keys()
    if unknown:
        kind, method, noise = sorted(unknown)[0]
        words = f"{kind} by {method} {'with' if noise else 'without'} noise"
        raise InputError(f"timing.csv: no job of {words} was timed; run `snakemake timing` again")
    return np.array([costs[job.cost_class] * job.work for job in jobs])


def wall_seconds(
    seconds: Seconds, cores: int, *, overhead: float = OVERHEAD, rate: float = RATE
) -> float:
    """Time until the last of some jobs ends, on this many cores."""
    free = [0.0] * min(cores, len(seconds))
    end = 0.0
    for number, needed in enumerate(seconds):
        start = max(heapq.heappop(free), number / rate)
        heapq.heappush(free, start + overhead + needed)
        end = max(end, start + overhead + needed)
    return end


def table(
    seconds: Seconds,
    cores: Sequence[int] = CORES,
    *,
    overhead: float = OVERHEAD,
    rate: float = RATE,
) -> pd.DataFrame:
    """Wall time on several numbers of cores, and what sets it."""
    import pandas as pd  # half a second that importers need not pay

    total = float(np.sum(seconds)) + overhead * len(seconds)
    rows = []
    for count in cores:
        wall = wall_seconds(seconds, count, overhead=overhead, rate=rate)
        bounds = {
            "work": total / count,
            "longest job": overhead + max(seconds),
            "sending": len(seconds) / rate,
        }
        limit = max(bounds, key=lambda name: bounds[name])
        rows.append((count, total / 3600, wall / 3600, total / (wall * count), limit))
    return pd.DataFrame(rows, columns=["cores", "core_hours", "hours", "busy", "limit"])


def main(words: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(
        prog="python -m beltrepro.replication.plan.walltime", description=__doc__
    )
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    add = parser.add_argument
    add("timing", help="timing.csv of a run")
    add("--preset", help="which to judge; that of the configuration if not given")
    add("--config", nargs="+", default=["config.yaml"], help="files, later ones over earlier ones")
    add("--cores", nargs="+", type=_positive, default=CORES)
    add("--overhead", type=float, default=OVERHEAD, help="seconds of each job for its start")
    add("--rate", type=float, default=RATE, help="jobs sent in a second")
    arguments = parser.parse_args(words)
    try:
        print(_answer(arguments))
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


def _answer(arguments: argparse.Namespace) -> str:
    import pandas as pd

    try:
        timing = pd.read_csv(arguments.timing)
    except OSError as error:
        raise InputError(f"{arguments.timing}: {error.strerror}") from None
    if "seconds_per_work" not in timing:
        raise InputError(f"{arguments.timing}: not a table that `snakemake timing` wrote")
    config: dict = {}
    for path in arguments.config:
        config = _merged(config, load_config(path))
    if arguments.preset:
        config["preset"] = arguments.preset
    plan = make_plan(config)
    seconds = job_seconds(simulation_jobs(plan), timing)
    answer = table(seconds, arguments.cores, overhead=arguments.overhead, rate=arguments.rate)
    return (
        f"{plan.preset}: {len(seconds)} jobs, {seconds.sum() / 3600:.3g} core-hours and "
        f"{arguments.overhead:g} s of overhead for each; longest {seconds.max() / 60:.3g} min\n"
        + answer.to_string(index=False, float_format=lambda value: f"{value:.3g}")
    )


def _merged(one: dict, other: dict) -> dict:
    """Both, the other over the one, as Snakemake merges configuration files."""
    merged = dict(one)
    for key, value in other.items():
        both = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = _merged(merged[key], value) if both else value
    return merged


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text}: must be 1 or more")
    return value


if __name__ == "__main__":
    sys.exit(main())

"""The simulation jobs of a plan, what all of them take, judged from a sample, and on many cores.

Jobs of one class (kind of dataset, method, with noise or without) differ in their work: blocks of
all chains times model time, with a weight for short time steps. Within a class, time is taken to be
proportional to work, and so is the size of the results (ratio estimator: W. G. Cochran, Sampling
Techniques, 3rd ed., Wiley 1977, ch. 6).
"""

from __future__ import annotations

import argparse
import heapq
import itertools
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from beltrepro.base.errors import InputError
from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.plan import Plan, make_plan

if TYPE_CHECKING:
    import pandas as pd

ONE_IN = 10  # jobs of each class, for one in the sample
COLUMNS = {
    "kind": "kind of the datasets",
    "method": "integrator",
    "noise": "with or without",
    "jobs": "number of simulation jobs, without those that add runs",
    "jobs_run": "number of those that ran",
    "hours_run": "core-hours that these took",
    "hours": "core-hours of all jobs, estimated",
    "standard_error": "of hours",
    "hours_at_most": "hours, and those of all runs that more_runs allows to be added",
    "seconds_per_work": "seconds for a block and a unit of model time",
    "memory_mb": "largest memory of a job that ran, MB",
    "megabytes": "size of the results of all jobs, MB, estimated; datasets are as large again",
    "megabytes_error": "standard error of megabytes",
}


@dataclass(frozen=True)
class Job:
    """One simulation job, which advances one batch."""

    kind: str  # kind of the dataset; method of its points
    method: str
    noise: bool  # whether its points have noise
    name: str  # of its result below results/<run>/, without suffix
    work: float  # blocks of all chains times model time; at most, if it adds runs
    adds: bool = False  # whether it only adds runs where they are needed

    @property
    def cost_class(self) -> tuple[str, str, bool]:
        """Jobs of one class cost the same for the same work."""
        return self.kind, self.method, self.noise


def simulation_jobs(plan: Plan) -> list[Job]:
    """All simulation jobs of a plan, of those that add runs all that there can be."""
    jobs = [
        Job(
            kind=dataset.kind.name,
            method=batch.most[0].method,
            noise=batch.most[0].noise > 0,
            name=f"batches/{dataset.name}/{batch.name}",
            work=dataset.work(batch.most),
            adds=bool(batch.looks_at),
        )
        for dataset in plan.datasets.values()
        for batch in dataset.batches.values()
    ]
    return sorted(jobs, key=lambda job: (job.cost_class, job.adds))


def draw(jobs: list[Job], seed: int) -> list[Job]:
    """One in ONE_IN jobs of every class, at least one, with chances proportional to their work.

    The jobs of a class are laid end to end, as long as their work, and taken at equal distances
    from a random start: so the sample follows the order of the jobs, in which neighbours cost
    nearly the same, and no small job, which costs mostly its start, stands for the large ones. A
    job as long as the distance is always taken, and the others share the places left.
    """
    stream = np.random.default_rng(seed)
    drawn = []
    for _, group in itertools.groupby(jobs, key=lambda job: job.cost_class):
        members = list(group)
        work = np.array([job.work for job in members])
        count = math.ceil(len(members) / ONE_IN)
        drawn += [members[number] for number in _chosen(work, count, stream)]
    return drawn


def _chosen(work: np.ndarray, count: int, stream: np.random.Generator) -> np.ndarray:
    """Numbers of `count` of the jobs with this work."""
    always = np.zeros(work.size, dtype=bool)
    while always.sum() < count:
        distance = work[~always].sum() / (count - always.sum())
        longer = ~always & (work >= distance)
        if not longer.any():
            places = (stream.random() + np.arange(count - always.sum())) * distance
            rest = np.flatnonzero(~always)
            always[rest[np.searchsorted(np.cumsum(work[rest]), places)]] = True
        always |= longer
    return np.flatnonzero(always)


def estimate(
    jobs: list[Job],
    seconds: dict[str, float],
    memory: dict[str, float] | None = None,
    size: dict[str, float] | None = None,
) -> pd.DataFrame:
    """Time, memory and disk of all jobs from those of some: a row a class, and one for the sum.

    Jobs that add runs count in `hours_at_most` only: what they do is not known before.
    """
    import pandas as pd  # half a second that Snakemake need not pay in every job

    rows = []
    for (kind, method, noise), group in itertools.groupby(jobs, key=lambda job: job.cost_class):
        alike = list(group)
        members = [job for job in alike if not job.adds]
        work = np.array([job.work for job in members if job.name in seconds])
        time = np.array([seconds[job.name] for job in members if job.name in seconds])
        hours, error = _ratio_estimate(time / 3600, work, [job.work for job in members])
        words = kind, method, "with" if noise else "without"
        cost = time.sum() / work.sum() if work.size else np.nan
        ran = len(members), time.size, time.sum() / 3600
        most = hours + cost * sum(job.work for job in alike if job.adds) / 3600
        room = _room(members, memory or {}, size or {})
        rows.append((*words, *ran, hours, error, most, cost, *room))
    table = pd.DataFrame(rows, columns=COLUMNS)
    # a class of which no job ran leaves the sum unknown
    total = table.sum(numeric_only=True, skipna=False).to_dict()
    total |= {
        "kind": "sum",
        "method": "",
        "noise": "",
        "standard_error": _norm(table["standard_error"]),
        "seconds_per_work": np.nan,
        "memory_mb": table["memory_mb"].max(),
        "megabytes_error": _norm(table["megabytes_error"]),
    }
    table.loc[len(table)] = total
    return table.astype({"jobs": int, "jobs_run": int})


def _room(members, memory, size):
    """Memory and disk of the jobs of a class: largest MB, and MB of all with their error."""
    largest = max((memory[job.name] for job in members if job.name in memory), default=np.nan)
    work = np.array([job.work for job in members if job.name in size])
    megabytes = np.array([size[job.name] for job in members if job.name in size]) / 1e6
    return largest, *_ratio_estimate(megabytes, work, [job.work for job in members])


def _ratio_estimate(value, size, all_sizes):
    """Sum of a value over a population from its values in a sample, and the standard error."""
    if not value.size:
        return np.nan, np.nan
    ratio = value.sum() / size.sum()
    total = ratio * np.sum(all_sizes)
    population, sample = len(all_sizes), value.size
    if sample == population:
        return total, 0.0
    if sample < 2:
        return total, np.nan
    variance = np.sum((value - ratio * size) ** 2) / (sample - 1)
    return total, population * math.sqrt((1 / sample - 1 / population) * variance)


def _norm(errors):
    return float(np.sqrt(np.nansum(np.square(errors))))


# --- on many cores --------------------------------------------------------------------------------

_COMMAND = """\
How long a preset takes on many cores, from the measured time of some of its jobs:

    python -m beltrepro.replication.plan.jobs results/paper/timing.csv --cores 10 100 1000

`snakemake timing` writes timing.csv. Another preset can be judged by it, and so can a variant in a
file of its own (`--config variant.yaml`), as long as it has the same classes of jobs. Each job goes
to the core that is free first (list scheduling: R. L. Graham, Bell System Technical Journal 45,
1563, 1966), which takes at most twice the shortest time possible. All runs that `more_runs` allows
are counted; that their rounds wait for each other is not. Joining, tables and figures are left out:
they take minutes."""
OVERHEAD = 10.0  # seconds: two starts of Snakemake (7 s of processor time measured), and Slurm
RATE = 5.0  # jobs sent in a second; 8 were measured with a Slurm that had nothing else to do


def job_seconds(jobs: Sequence[Job], timing: pd.DataFrame) -> np.ndarray:
    """Time of each job: its work times what a unit of work costs in its class."""
    costs = {
        (row.kind, row.method, row.noise == "with"): row.seconds_per_work
        for row in timing.itertuples()
        if np.isfinite(row.seconds_per_work)
    }
    for kind, method, noise in sorted({job.cost_class for job in jobs} - costs.keys()):
        words = f"{kind} by {method} {'with' if noise else 'without'} noise"
        raise InputError(f"timing.csv: no job of {words} was timed; run `snakemake timing` again")
    return np.array([costs[job.cost_class] * job.work for job in jobs])


def wall_seconds(seconds: Sequence[float] | np.ndarray, cores: int, rate: float = RATE) -> float:
    """Time until the last of some jobs ends, on this many cores."""
    free = [0.0] * min(cores, len(seconds))
    end = 0.0
    for number, needed in enumerate(seconds):
        start = max(heapq.heappop(free), number / rate)
        heapq.heappush(free, start + needed)
        end = max(end, start + needed)
    return end


def wall_times(
    seconds: Sequence[float] | np.ndarray, cores: Sequence[int], rate: float = RATE
) -> pd.DataFrame:
    """Wall time on several numbers of cores, and what sets it."""
    import pandas as pd  # half a second that importers need not pay

    total = float(np.sum(seconds))
    rows = []
    for count in cores:
        wall = wall_seconds(seconds, count, rate)
        bounds = {
            total / count: "work",
            max(seconds): "longest job",
            len(seconds) / rate: "sending",
        }
        limit = bounds[max(bounds)]
        rows.append((count, total / 3600, wall / 3600, total / (wall * count), limit))
    return pd.DataFrame(rows, columns=["cores", "core_hours", "hours", "busy", "limit"])


def main(words: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(
        prog="python -m beltrepro.replication.plan.jobs",
        description=_COMMAND,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("timing", help="timing.csv of a run")
    add("--preset", help="which to judge; that of the configuration if not given")
    add("--config", nargs="+", default=["config.yaml"], help="files, later ones over earlier ones")
    add("--cores", nargs="+", type=_positive, default=(1, 10, 100, 1000))
    add("--overhead", type=float, default=OVERHEAD, help="seconds of each job for its start")
    arguments = parser.parse_args(words)
    try:
        print(_answer(arguments))
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


def _answer(arguments: argparse.Namespace) -> str:
    from snakemake.utils import update_config

    from beltrepro.replication.plan import tables

    timing = tables.read(arguments.timing)
    if "seconds_per_work" not in timing:
        raise InputError(f"{arguments.timing}: not a table that `snakemake timing` wrote")
    config: dict = {}
    for path in arguments.config:
        update_config(config, load_config(path))
    if arguments.preset:
        config["preset"] = arguments.preset
    plan = make_plan(config)
    jobs = simulation_jobs(plan)
    seconds = job_seconds(jobs, timing)
    lines = [
        f"{plan.preset}: {len(seconds)} jobs, {seconds.sum() / 3600:.3g} core-hours and "
        f"{arguments.overhead:g} s of overhead for each; longest {seconds.max() / 60:.3g} min"
    ]
    if (adding := seconds[[job.adds for job in jobs]]).size:
        lines.append(
            f"with {adding.size} jobs that add runs where they are needed: at most "
            f"{adding.sum() / 3600:.3g} core-hours, all counted here"
        )
    answer = wall_times(seconds + arguments.overhead, arguments.cores)
    lines.append(answer.to_string(index=False, float_format=lambda value: f"{value:.3g}"))
    return "\n".join(lines)


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text}: must be 1 or more")
    return value


if __name__ == "__main__":
    sys.exit(main())

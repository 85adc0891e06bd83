"""The simulation jobs of a plan, and what all of them take, judged from a sample.

Jobs of one class (kind of dataset, method, with noise or without) differ in their work: blocks of
all chains times model time, with a weight for short time steps. Within a class, time is taken to be
proportional to work, and so is the size of the results (ratio estimator: W. G. Cochran, Sampling
Techniques, 3rd ed., Wiley 1977, ch. 6).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from beltrepro.replication.plan.plan import Plan

if TYPE_CHECKING:
    import pandas as pd

ONE_IN = 10  # jobs of each class, for one in the sample
COLUMNS = {
    "kind": "kind of the datasets",
    "method": "integrator",
    "noise": "with or without",
    "jobs": "number of simulation jobs",
    "jobs_run": "number of those that ran",
    "hours_run": "core-hours that these took",
    "hours": "core-hours of all jobs, estimated",
    "standard_error": "of hours",
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
    work: float  # blocks of all chains times model time

    @property
    def cost_class(self) -> tuple[str, str, bool]:
        """Jobs of one class cost the same for the same work."""
        return self.kind, self.method, self.noise


def simulation_jobs(plan: Plan) -> list[Job]:
    """All simulation jobs of a plan."""
    jobs = [
        Job(
            kind=dataset.kind.name,
            method=batch[0].method,
            noise=batch[0].noise > 0,
            name=f"batches/{dataset.name}/{number:04d}",
            work=dataset.work(batch),
        )
        for dataset in plan.datasets.values()
        for number, batch in enumerate(dataset.batches)
    ]
    return sorted(jobs, key=lambda job: job.cost_class)


def draw(jobs: list[Job], seed: int, one_in: int = ONE_IN) -> list[Job]:
    """One in `one_in` jobs of every class, at least one, with chances proportional to their work.

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
        count = math.ceil(len(members) / one_in)
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
    """Time, memory and disk of all jobs from those of some: a row a class, and one for the sum."""
    import pandas as pd  # half a second that Snakemake need not pay in every job

    rows = []
    for (kind, method, noise), group in itertools.groupby(jobs, key=lambda job: job.cost_class):
        members = list(group)
        work = np.array([job.work for job in members if job.name in seconds])
        time = np.array([seconds[job.name] for job in members if job.name in seconds])
        hours, error = _ratio_estimate(time / 3600, work, [job.work for job in members])
        words = kind, method, "with" if noise else "without"
        cost = time.sum() / work.sum() if work.size else np.nan
        ran = len(members), time.size, time.sum() / 3600
        rows.append((*words, *ran, hours, error, cost, *_room(members, memory or {}, size or {})))
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

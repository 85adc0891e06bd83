"""The simulation jobs of a plan, and how long all of them take, judged from a sample.

Jobs of one kind (rule, integrator, with noise or without) differ in their work: chains times blocks
times model time, with a weight for short time steps. Within a kind, time is taken to be
proportional to work (ratio estimator: W. G. Cochran, Sampling Techniques, 3rd ed., Wiley 1977,
ch. 6).
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np
import pandas as pd

from beltrepro.config import PARTS, ROLES, Plan

ONE_IN = 10  # jobs of each kind, for one in the sample
_GRIDS = ("belt_velocity", "noise", "initial_spread")


@dataclass(frozen=True)
class Job:
    """One simulation job.

    rule : of the workflow. noise : whether any of its chains has noise.
    name : of its result below results/<preset>/, without suffix.
    work : chains times blocks times model time.
    """

    rule: str
    method: str
    noise: bool
    name: str
    work: float

    @property
    def kind(self) -> tuple[str, str, bool]:
        """Jobs of one kind cost the same for the same work."""
        return self.rule, self.method, self.noise


def simulation_jobs(plan: Plan) -> list[Job]:
    """All simulation jobs of a plan, sorted by kind."""
    jobs = []
    for scan in plan.scans.values():
        for number, block in enumerate(scan.blocks):
            work = scan.duration * sum(n_blocks for n_blocks, *_ in block.points)
            noise = any(point[2] > 0 for point in block.points)
            name = f"blocks/{scan.name}/{number:04d}"
            jobs.append(Job("scan_block", block.method, noise, name, work))
    for each in plan.series.values():
        work = each.duration * each.n_blocks
        jobs.append(Job("series", each.method, each.noise > 0, f"series/{each.name}", work))
    for each in plan.catalogues.values():
        work = each.duration * each.n_blocks * each.n_chains
        name = f"catalogues/{each.name}"
        jobs.append(Job("catalogue", each.method, each.noise > 0, name, work))
    for each in plan.ensembles.values():
        work = each.duration * each.n_blocks * each.n_members
        for number in range(len(each.belt_velocities)):
            name = f"ensembles/{each.name}/{number:04d}"
            jobs.append(Job("ensemble_member", each.method, each.noise > 0, name, work))
    for part, role in itertools.product(PARTS, ROLES):
        settings = plan.agreement.run_settings(part, role)
        chains = settings["n_runs"] * math.prod(len(settings.get(grid, [0])) for grid in _GRIDS)
        steps = sum(plan.numerics.time_step / step for step in settings["time_steps"])
        work = settings["duration"] * sum(settings["n_blocks"]) * chains * steps
        noise = max(settings.get("noise", [0])) > 0
        name = f"agreement/{part}/{role}"
        jobs.append(Job("agreement_runs", settings["method"], noise, name, work))
    return sorted(jobs, key=lambda job: job.kind)


def draw(jobs: list[Job], seed: int, one_in: int = ONE_IN) -> list[Job]:
    """One in `one_in` jobs of every kind, at least one, with chances proportional to their work.

    jobs : sorted by kind. The jobs of a kind are laid end to end, as long as their work, and taken
    at equal distances from a random start: so the sample follows the order of the jobs, in which
    neighbours cost nearly the same, and no small job, which costs mostly its start, stands for the
    large ones. A job as long as the distance is always taken.
    """
    stream = np.random.default_rng(seed)
    drawn = []
    for _, group in itertools.groupby(jobs, key=lambda job: job.kind):
        members = list(group)
        ends = np.cumsum([job.work for job in members])
        count = math.ceil(len(members) / one_in)
        places = (stream.random() + np.arange(count)) * ends[-1] / count
        drawn += [members[number] for number in np.unique(np.searchsorted(ends, places))]
    return drawn


def estimate(jobs: list[Job], seconds: dict[str, float]) -> pd.DataFrame:
    """Time of all jobs from that of some of them, a row for each kind and one for the sum.

    seconds : time of the jobs that ran, by name.
    Returns columns rule, method, noise ("with" or "without"), jobs, jobs_run, hours_run, hours and
    standard_error (core-hours; NaN where fewer than two jobs of several ran, and left out of the
    sum's).
    """
    rows = []
    for (rule, method, noise), group in itertools.groupby(jobs, key=lambda job: job.kind):
        members = list(group)
        work = np.array([job.work for job in members if job.name in seconds])
        time = np.array([seconds[job.name] for job in members if job.name in seconds])
        hours, error = _ratio_estimate(time / 3600, work, [job.work for job in members])
        kind = rule, method, "with" if noise else "without"
        rows.append((*kind, len(members), time.size, time.sum() / 3600, hours, error))
    names = ["rule", "method", "noise", "jobs", "jobs_run", "hours_run", "hours", "standard_error"]
    table = pd.DataFrame(rows, columns=names)
    # a kind of which no job ran leaves the sum unknown
    total = table.sum(numeric_only=True, skipna=False).to_dict()
    total |= {
        "rule": "sum",
        "method": "",
        "noise": "",
        "standard_error": _norm(table["standard_error"]),
    }
    table.loc[len(table)] = total
    return table.astype({"jobs": int, "jobs_run": int})


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

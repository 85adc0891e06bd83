"""One interleaved measurement: every quantity once in every round, after all have warmed up.

A disturbance of the machine then hits all competitors alike. Costs are processor time of the one
thread that works, which other programs on the machine disturb less than the clock.
"""

import datetime
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from beltrepro.base import provenance
from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.engine.vector import zeros
from beltrepro.extras.bench import smooth
from beltrepro.extras.bench.competitors import BASE, LABELS, competitor
from beltrepro.extras.bench.peak import OPERATIONS_PER_TURN, multiply_add
from beltrepro.extras.bench.plain import FLAGS, compiler
from beltrepro.model import ChainParameters

METHODS = ("verlet", "event")
_SMALLEST_SPAN = 0.1  # model time; less would measure the calls


@dataclass(frozen=True)
class Plan:
    """What is measured.

    cases : (N, sigma, u) of the main table. width : chains advanced together there.
    chain_counts : for the scaling with the number of chains, at `scaling_case`.
    block_counts : N for the scaling with N, at sigma and u of `scaling_case`.
    timing : seconds of each timing. warm_up : model time before the first.
    fill_cache : start one process for its compiled code only, before those that count.
    """

    cases: tuple[tuple[int, float, float], ...] = (
        *((n, sigma, u) for n in (5, 10) for sigma in (0.0, 1.0) for u in (1.0, 20.0)),
        (10, 1.0, 30.0),
    )
    width: int = 64
    chain_counts: tuple[int, ...] = (1, 8, 32, 64, 256)
    block_counts: tuple[int, ...] = (1, 2, 3, 5, 7, 10, 16, 24, 32)
    scaling_case: tuple[int, float, float] = (10, 1.0, 20.0)
    timing: float = 0.3
    warm_up: float = 500.0
    fill_cache: bool = True


QUICK = Plan(
    cases=((5, 0.0, 20.0), (5, 1.0, 20.0)),
    chain_counts=(1, 8, 64),
    block_counts=(1, 10),
    timing=0.02,
    warm_up=10.0,
    fill_cache=False,
)


def measure(
    rounds: int = 5,
    *,
    quick: bool = False,
    only: Sequence[str] | None = None,
    progress: Callable[[float], None] | None = None,
) -> dict:
    """Measure everything `beltrepro bench` shows."""
    if rounds < 1:
        raise InputError(f"rounds = {rounds}: must be 1 or greater")
    names = list(LABELS) if only is None else [BASE, *(name for name in only if name != BASE)]
    for name in names:
        if name not in LABELS:
            raise InputError(f"only = {name!r}: allowed are {', '.join(LABELS)}")
    names = [name for name in LABELS if name in names]
    plan = QUICK if quick else Plan()
    methods = [name for name in METHODS if name in names]
    result: dict = {
        "conditions": _conditions(rounds, plan, quick, only),
        "names": names,
        "cases": [],
        "chains": [],
        "blocks": [],
        "cores": {},
        "peak": [],
        "memory": {},
        "first_step": {},
        "wall": [],
    }
    tasks = _tasks(plan, names, methods, result)
    report = progress or (lambda fraction: None)
    total, done = (rounds + 1) * len(tasks), 0
    ready = []
    try:
        for task in tasks:
            ready.append(task())
            done += 1
            report(done / total)
        for _ in range(rounds):
            for timing in ready:
                if timing is not None:
                    timing.take()
                done += 1
                report(done / total)
    finally:
        for timing in ready:
            if timing is not None:
                timing.close()
    return result


def _tasks(plan, names, methods, result):
    """Functions that prepare a timing each, or give None where a competitor cannot run."""
    tasks = []

    def cost(row, name, case, width):
        tasks.append(lambda: _Cost.prepare(row, name, case, width, plan, result["wall"]))

    for case in plan.cases:
        row = dict(zip(("n_blocks", "noise", "belt_velocity"), case, strict=True), ns={})
        result["cases"].append(row)
        for name in names:
            cost(row, name, case, plan.width)
    for chains in plan.chain_counts if methods else ():
        row = {"chains": chains, "ns": {}}
        result["chains"].append(row)
        for name in methods:
            cost(row, name, plan.scaling_case, chains)
    for n_blocks in plan.block_counts:
        row = {"n_blocks": n_blocks, "ns": {}}
        result["blocks"].append(row)
        for name in names:
            cost(row, name, (n_blocks, *plan.scaling_case[1:]), plan.width)
    tasks.append(lambda: _Peak(result["peak"], plan))
    tasks += [lambda name=name: _Cores(result, name, plan) for name in methods]
    tasks += [lambda name=name: _FirstStep(result["first_step"], name, plan) for name in methods]
    return tasks


class _Cost:
    """Nanoseconds per chain and unit of model time of one competitor."""

    def __init__(self, runner, values, walls, seconds):
        self._runner, self._values, self._walls = runner, values, walls
        self._span = 1.0
        for _ in range(20):
            elapsed = max(self._advance()[0], 1e-6)
            if elapsed > seconds / 4:
                break
            self._span *= min(20.0, max(2.0, seconds / elapsed))
        self._span = max(_SMALLEST_SPAN, round(self._span * seconds / elapsed, 1))

    @classmethod
    def prepare(cls, row, name, case, width, plan, walls):
        n_blocks, noise, belt_velocity = case
        chain = ChainParameters(n_blocks, belt_velocity, noise)
        runner = competitor(name, chain, width, plan.warm_up)
        if runner is None:
            return None
        return cls(runner, row["ns"].setdefault(name, []), walls, plan.timing)

    def _advance(self):
        wall, processor = time.perf_counter(), time.process_time()
        self._runner.advance(self._span)
        return time.process_time() - processor, time.perf_counter() - wall

    def take(self):
        processor, wall = self._advance()
        self._values.append(1e9 * processor / (self._span * self._runner.chains))
        self._walls.append(wall / processor)

    def close(self):
        self._runner = None


class _Peak:
    """Operations per second of nothing but multiply-adds."""

    def __init__(self, values, plan):
        self._results = values
        self._numbers = zeros((12, 8))
        multiply_add(self._numbers, 1)
        self._turns = int(plan.timing * 2e8)

    def take(self):
        start = time.process_time()
        multiply_add(self._numbers, self._turns)
        elapsed = time.process_time() - start
        self._results.append(OPERATIONS_PER_TURN * self._turns / elapsed)

    def close(self):
        pass


class _Cores:
    """Work per time of two processes over that of one."""

    def __init__(self, result, method, plan):
        self._memory = result["memory"].setdefault(method, {})
        self._gains = result["cores"].setdefault(method, {"wall": [], "processor": []})
        n_blocks, noise, belt_velocity = plan.scaling_case
        settings = [method, n_blocks, belt_velocity, noise, plan.width, plan.warm_up]
        self._workers = []
        for _ in range(2):
            self._workers.append(_worker(*settings))
        ready = [_reply(worker) for worker in self._workers]
        self._memory["start"] = ready[0]["bytes"]
        self._span, seconds = 1.0, max(plan.timing, 0.1)
        elapsed = self._together(1)[0]
        if elapsed < seconds / 4:
            self._span = min(20.0, seconds / elapsed)
            elapsed = self._together(1)[0]
        self._span = max(_SMALLEST_SPAN, round(self._span * seconds / elapsed, 1))

    def _together(self, number):
        """Wall time until all have done their span, and their mean processor time."""
        workers = self._workers[:number]
        start = time.perf_counter()
        for worker in workers:
            _ask(worker, self._span)
        replies = [_reply(worker) for worker in workers]
        wall = time.perf_counter() - start
        return wall, float(np.mean([reply["processor"] for reply in replies]))

    def take(self):
        alone, beside = self._together(1), self._together(2)
        for kind, one, two in zip(("wall", "processor"), alone, beside, strict=True):
            self._gains[kind].append(2 * one / two)

    def close(self):
        try:
            _ask(self._workers[0], "memory")
            self._memory["end"] = _reply(self._workers[0])["bytes"]
        except (OSError, ModelStateError):
            pass
        for worker in self._workers:
            worker.stdin.close()
            worker.wait()
            worker.stdout.close()


class _FirstStep:
    """Seconds from the start of a fresh process to its first step, compiled code in the cache."""

    _CODE = (
        "from beltrepro import ChainParameters, simulate\n"
        "simulate(ChainParameters(5, 20.0, 1.0), duration=1.0, method={!r},"
        " sample_interval=None)\n"
        "print('done', flush=True)\n"
    )

    def __init__(self, values, method, plan):
        self._code = self._CODE.format(method)
        self._values = values.setdefault(method, [])
        if plan.fill_cache:
            self._start()

    def _start(self):
        start = time.perf_counter()
        with subprocess.Popen(
            [sys.executable, "-c", self._code], stdout=subprocess.PIPE, text=True
        ) as process:
            line = process.stdout.readline()
            elapsed = time.perf_counter() - start
        if line.strip() != "done":
            raise ModelStateError("bench: a fresh process did not reach its first step")
        return elapsed

    def take(self):
        self._values.append(self._start())

    def close(self):
        pass


def _worker(*settings):
    return subprocess.Popen(
        [sys.executable, "-m", "beltrepro.extras.bench.worker", *map(str, settings)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def _ask(worker, question):
    worker.stdin.write(f"{question}\n")
    worker.stdin.flush()


def _reply(worker):
    line = worker.stdout.readline()
    if not line:
        raise ModelStateError("bench: a worker process ended early")
    return json.loads(line)


def _conditions(rounds, plan, quick, only):
    versions = provenance.library_versions()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "processor": provenance.processor(),
        "cores": cores,
        "versions": {name: versions[name] for name in ("python", "numpy", "scipy", "numba")},
        "compiler": compiler(),
        "compiler_flags": " ".join(FLAGS),
        "heyoka": smooth.heyoka_version(),
        "solve_ivp": {"method": smooth.METHOD, "tolerance": smooth.TOLERANCE},
        "code_version": provenance.code_version(),
        "date": datetime.date.today().isoformat(),
        "rounds": rounds,
        "quick": quick,
        "only": None if only is None else ",".join(only),
        "timing": plan.timing,
        "warm_up": plan.warm_up,
        "width": plan.width,
        "scaling_case": list(plan.scaling_case),
    }

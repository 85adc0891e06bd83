"""Interleaved measurements: every quantity once in every round, after all have warmed up.

A disturbance of the machine then hits all competitors alike. Costs are processor time of the one
thread that works, which other programs on the machine disturb less than the clock.
"""

import datetime
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import beltrepro
from beltrepro.base import provenance
from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.engine.simd import WIDE_LANES
from beltrepro.engine.vector import zeros
from beltrepro.extras.bench import smooth
from beltrepro.extras.bench.competitors import BASE, LABELS, competitor
from beltrepro.extras.bench.peak import CHAINS, OPERATIONS_PER_TURN, multiply_add
from beltrepro.extras.bench.plain import FLAGS, compiler
from beltrepro.model import ChainParameters

METHODS = ("verlet", "event")
_SMALLEST_SPAN = 0.1  # model time; less would measure the calls
_CASE = ("n_blocks", "noise", "belt_velocity")
_FIRST_STEP = (
    "from beltrepro import ChainParameters as C, simulate; "
    "simulate(C(5, 20.0, 1.0), duration=1.0, method={!r}, sample_interval=None)"
)


@dataclass(frozen=True)
class Scope:
    """What is measured."""

    # (N, sigma, u) of the main table
    cases: tuple[tuple[int, float, float], ...] = (
        *((n, sigma, u) for n in (5, 10) for sigma in (0.0, 1.0) for u in (1.0, 20.0)),
        (10, 1.0, 30.0),
    )
    width: int = 64  # chains advanced together there
    chain_counts: tuple[int, ...] = (1, 8, 32, 64, 256)  # at `scaling_case`
    block_counts: tuple[int, ...] = (1, 2, 3, 5, 7, 10, 16, 24, 32)  # at its sigma and u
    scaling_case: tuple[int, float, float] = (10, 1.0, 20.0)
    timing: float = 0.3  # seconds of each timing
    warm_up: float = 500.0  # model time before the first
    fill_cache: bool = True  # start one process for its compiled code only, before those that count


QUICK = Scope(
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
    _check(rounds, only or (), LABELS)
    names = [name for name in LABELS if only is None or name in (BASE, *only)]
    scope = QUICK if quick else Scope()
    result: dict = {"conditions": _conditions(rounds, scope, quick, only), "names": names}
    result |= {part: [] for part in ("cases", "chains", "blocks", "peak", "wall")}
    result |= {part: {} for part in ("cores", "memory", "first_step")}
    tasks = _tasks(scope, names, result)
    total = (rounds + 1) * len(tasks)
    for done in range(total):
        next(tasks[done % len(tasks)], None)
        if progress:
            progress((done + 1) / total)
    return result


def compare(
    tree: Path,
    rounds: int = 5,
    *,
    quick: bool = False,
    only: Sequence[str] | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[dict]:
    """Costs of the integrators in this source tree and in another one, in turns."""
    _check(rounds, only or (), METHODS)
    if not (tree / "src" / "beltrepro").is_dir():
        raise InputError(f"against = {tree}: no source tree, it lacks src/beltrepro")
    scope = QUICK if quick else Scope()
    rows = [
        dict(zip(_CASE, case, strict=True)) | {"method": method, "chains": scope.width}
        for case in scope.cases
        for method in only or METHODS
    ]
    with Worker() as here, Worker(tree.resolve() / "src") as there:
        for done, row in enumerate(rows):
            for worker in (here, there):
                worker.run(row, 1.0)  # loads what was compiled
            span = _span(lambda span, row=row: here.timed(row, span)[0], max(scope.timing, 0.1))
            row |= {"here": [], "there": [], "call_here": [], "call_there": []}
            for number in range(rounds):
                # each goes first in every other round
                for side in ("there", "here") if number % 2 else ("here", "there"):
                    seconds, call = (here if side == "here" else there).timed(row, span)
                    row[side].append(1e9 * seconds / (span * scope.width))
                    row[f"call_{side}"].append(call)
            if progress:
                progress((done + 1) / len(rows))
    return rows


def _check(rounds, only, allowed):
    if rounds < 1:
        raise InputError(f"rounds = {rounds}: must be 1 or greater")
    for name in only:
        if name not in allowed:
            raise InputError(f"only = {name!r}: allowed are {', '.join(allowed)}")


def _tasks(scope, names, result) -> list[Iterator[None]]:
    """Measurements that prepare themselves at the first `next`, and take a timing at each other.

    One ends at once where its competitor cannot run.
    """
    tasks = []
    methods = [name for name in METHODS if name in names]

    def add(part, row, competitors, case, width):
        row["ns"] = {}
        result[part].append(row)
        for name in competitors:
            tasks.append(_cost(row["ns"], result["wall"], name, case, width, scope))

    for case in scope.cases:
        add("cases", dict(zip(_CASE, case, strict=True)), names, case, scope.width)
    for chains in scope.chain_counts if methods else ():
        add("chains", {"chains": chains}, methods, scope.scaling_case, chains)
    for n_blocks in scope.block_counts:
        case = (n_blocks, *scope.scaling_case[1:])
        add("blocks", {"n_blocks": n_blocks}, names, case, scope.width)
    tasks.append(_peak(result["peak"], scope))
    tasks += [_cores(result, name, scope) for name in methods]
    tasks += [_first_step(result["first_step"], name, scope) for name in methods]
    return tasks


def _span(seconds_of, timing):
    """Model time that takes about `timing` seconds."""
    span = 1.0
    for _ in range(20):
        elapsed = max(seconds_of(span), 1e-6)
        if elapsed > timing / 4:
            break
        span *= min(20.0, max(2.0, timing / elapsed))
    return max(_SMALLEST_SPAN, round(span * timing / elapsed, 1))


def _cost(costs, walls, name, case, width, scope):
    """Nanoseconds per chain and unit of model time of one competitor."""
    n_blocks, noise, belt_velocity = case
    chain = ChainParameters(n_blocks, belt_velocity, noise)
    runner = competitor(name, chain, width, scope.warm_up)
    if runner is None:
        return

    def seconds(span):
        start = time.process_time()
        runner.advance(span)
        return time.process_time() - start

    span = _span(seconds, scope.timing)
    costs[name] = []
    while True:
        yield
        start = time.perf_counter()
        processor = seconds(span)
        walls.append((time.perf_counter() - start) / processor)
        costs[name].append(1e9 * processor / (span * runner.chains))


def _peak(values, scope):
    """Operations per second of nothing but multiply-adds."""
    numbers, turns = zeros((CHAINS, WIDE_LANES)), int(scope.timing * 2e8)
    multiply_add(numbers, 1)
    while True:
        yield
        start = time.process_time()
        multiply_add(numbers, turns)
        values.append(OPERATIONS_PER_TURN * turns / (time.process_time() - start))


def _cores(result, method, scope):
    """Work per time of two processes over that of one."""
    case = dict(zip(_CASE, scope.scaling_case, strict=True))
    case |= {"method": method, "chains": scope.width}
    memory = result["memory"][method] = {}
    gains = result["cores"][method] = {"wall": [], "processor": []}
    with Worker() as first, Worker() as second:
        memory["start"] = max(worker.run(case, 1.0)["bytes"] for worker in (first, second))
        span = _span(lambda span: first.run(case, span)["processor"], max(scope.timing, 0.1))
        while True:
            yield
            alone, beside = [_together(pair, case, span) for pair in ((first,), (first, second))]
            memory["end"] = beside["bytes"]
            for kind, values in gains.items():
                values.append(2 * alone[kind] / beside[kind])


def _together(workers, case, span):
    """Wall time until all have done their span, their mean processor time, memory of the first."""
    start = time.perf_counter()
    for worker in workers:
        worker.ask(case, span)
    replies = [worker.reply() for worker in workers]
    wall = time.perf_counter() - start
    processor = float(np.mean([reply["processor"] for reply in replies]))
    return {"wall": wall, "processor": processor, "bytes": replies[0]["bytes"]}


def _first_step(values, method, scope):
    """Seconds that a fresh process of one step takes, compiled code in the cache."""
    command = [sys.executable, "-W", "ignore", "-c", _FIRST_STEP.format(method)]
    if scope.fill_cache:
        subprocess.run(command, check=True)
    values[method] = []
    while True:
        yield
        start = time.perf_counter()
        subprocess.run(command, check=True)
        values[method].append(time.perf_counter() - start)


class Worker:
    """A process that simulates on request, with the package of this source tree or of another."""

    def __init__(self, source: Path | None = None):
        source = source or Path(beltrepro.__file__).parents[1]
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-W", "ignore", str(Path(__file__).with_name("worker.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": str(source)},
        )

    def run(self, case, span):
        """What `worker.py` answers."""
        self.ask(case, span)
        return self.reply()

    def timed(self, case, span):
        """Seconds of a span, and those that a call costs besides."""
        call = self.run(case, _SMALLEST_SPAN)["processor"]
        return self.run(case, _SMALLEST_SPAN + span)["processor"] - call, call

    def ask(self, case, span):
        """Let it begin."""
        print(json.dumps(case | {"span": span}), file=self._process.stdin, flush=True)

    def reply(self):
        """Wait for its answer."""
        line = self._process.stdout.readline()
        if not line:
            raise ModelStateError("bench: a worker process ended early")
        return json.loads(line)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()


def _conditions(rounds, scope, quick, only):
    versions = provenance.library_versions()
    return {
        "processor": provenance.processor(),
        "cores": len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count(),
        "versions": {name: versions[name] for name in ("python", "numpy", "scipy", "numba")},
        "compiler": compiler(),
        "compiler_flags": " ".join(FLAGS),
        "solve_ivp": {"method": smooth.METHOD, "tolerance": smooth.TOLERANCE},
        "code_version": provenance.code_version(),
        "date": datetime.date.today().isoformat(),
        "rounds": rounds,
        "quick": quick,
        "only": None if only is None else ",".join(only),
        **{name: getattr(scope, name) for name in ("timing", "warm_up", "width", "scaling_case")},
    }

"""How fast the integrators are, beside the scheme of the paper's Appendix as a plain loop in C.

    python benchmarks/bench.py --output docs/benchmark.md

A cost is the processor time of one thread for one chain and one unit of model time. The loop in C
advances one chain, the integrators 64 together. All are measured in turn in each round, so that a
disturbance of the machine hits them alike; medians over the rounds are shown.
"""

import argparse
import ctypes
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from beltrepro.base import provenance
from beltrepro.engine.integrator import Sampling
from beltrepro.engine.noise import stream_key
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.simulation.setup import METHODS

CASES = [(5, 0, 1), (5, 0, 20), (5, 1, 20), (10, 0, 20), (10, 1, 20), (10, 1, 30)]  # N, sigma, u
CHAINS = 64
TIME_STEP = 0.001
SAMPLE_STRIDE = 100  # steps between samples of x_N, as in a scan
WARM_UP = 1000.0  # model time
SOURCE = Path(__file__).with_name("naive_loop.c")
FLAGS = ("-O3", "-march=native", "-std=c99", "-shared", "-fPIC")


class PlainLoop:
    """One chain, from rest, advanced by the loop in C."""

    chains = 1

    def __init__(self, chain: ChainParameters, advance_chain):
        random = np.random.default_rng(stream_key(chain, 1, 0))
        state = np.zeros((6, chain.n_blocks))  # x, x before, v, a before, F_st, direction of slip
        state[0] = chain.rest_positions
        state[1] = state[0] - chain.belt_velocity * TIME_STEP
        state[2] = chain.belt_velocity
        state[4] = chain.static_friction + chain.noise * random.standard_normal(chain.n_blocks)
        stream = random.integers(2**64, size=4, dtype=np.uint64)
        self._arrays = state, stream, np.zeros(4)
        self._law = chain.n_blocks, chain.belt_velocity, chain.noise, TIME_STEP
        self._advance_chain = advance_chain

    def advance(self, span: float) -> None:
        self._advance_chain(*self._law, round(span / TIME_STEP), *self._arrays)


class Together:
    """Chains with starts 0.001 apart, advanced together by an integrator."""

    chains = CHAINS

    def __init__(self, chain: ChainParameters, method: str):
        spread = 1e-3 * np.random.default_rng(1).standard_normal((CHAINS, chain.n_blocks))
        starts = enumerate(chain.rest_positions + spread)
        states = [ChainState.at_rest(chain, start, replicate=number) for number, start in starts]
        sampling = Sampling(SAMPLE_STRIDE, TIME_STEP)
        how = {"time_step": TIME_STEP, "sampling": sampling, "sampled_blocks": 1}
        self._integrator = METHODS[method](states, **how)

    def advance(self, span: float) -> None:
        for _ in self._integrator.advance(self._integrator.time + span):
            pass


def compiled_loop():
    """The function of naive_loop.c, compiled now."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, "naive_loop.so")
        subprocess.run(["cc", *FLAGS, "-o", library, SOURCE, "-lm"], check=True)
        function = ctypes.CDLL(str(library)).advance_chain
    real, whole = ctypes.c_double, ctypes.c_int64
    arrays = (np.ctypeslib.ndpointer(kind, flags="C") for kind in (float, np.uint64, float))
    function.argtypes = [whole, real, real, real, whole, *arrays]
    function.restype = None
    return function


def cost(runner, span: float) -> float:
    """Microseconds for one chain and one unit of time."""
    begin = time.process_time()
    runner.advance(span)
    return 1e6 * (time.process_time() - begin) / (span * runner.chains)


def measured(case: tuple, loop, rounds: int, seconds: float) -> list[float]:
    """Median costs of a case: of the loop in C, `verlet` and `event`."""
    n_blocks, noise, belt_velocity = case
    chain = ChainParameters(n_blocks, belt_velocity, noise=noise)
    runners = [PlainLoop(chain, loop), Together(chain, "verlet"), Together(chain, "event")]
    spans = []
    for runner in runners:
        runner.advance(WARM_UP)
        spans.append(max(1.0, 1e6 * seconds / (cost(runner, 100.0) * runner.chains)))
    costs = [[cost(*pair) for pair in zip(runners, spans, strict=True)] for _ in range(rounds)]
    return [statistics.median(column) for column in zip(*costs, strict=True)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=0.3, help="of each measurement")
    parser.add_argument("--output", type=Path, help="Markdown file; printed if not given")
    options = parser.parse_args()
    loop = compiled_loop()
    about = provenance.machine()["processor"], f"beltrepro {provenance.code_version()}"
    lines = ["# Benchmark", "", __doc__.split("\n\n")[2].strip(), "", ", ".join(about) + ".", ""]
    lines += ["| N | σ | u | C (µs) | `verlet` (µs) | `event` (µs) |", "|" + " --- |" * 6]
    for case in CASES:
        costs = measured(case, loop, options.rounds, options.seconds)
        lines.append(f"| {' | '.join([*map(str, case), *(f'{one:.3g}' for one in costs)])} |")
    text = "\n".join(lines) + "\n"
    options.output.write_text(text, encoding="utf-8") if options.output else print(text)


if __name__ == "__main__":
    main()

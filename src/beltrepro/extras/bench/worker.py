"""A process of its own that advances chains on request: `python -m beltrepro.extras.bench.worker`.

Arguments: method, N, u, sigma, number of chains, warm-up. It answers every line of its input with
one line of JSON: a number is a span of model time to advance, "memory" asks for the peak memory.
"""

import json
import resource
import sys
import time
from pathlib import Path

from beltrepro import ChainParameters


def peak_memory() -> float:
    """Largest resident memory of this process so far, bytes."""
    try:
        status = Path("/proc/self/status").read_text()
        return 1024.0 * float(status.partition("VmHWM:")[2].split()[0])
    except (OSError, IndexError):
        unit = 1 if sys.platform == "darwin" else 1024
        return float(unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


def _answer(line, runner):
    if line == "memory":
        return {"bytes": peak_memory()}
    wall, processor = time.perf_counter(), time.process_time()
    runner.advance(float(line))
    return {
        "wall": time.perf_counter() - wall,
        "processor": time.process_time() - processor,
    }


def main(arguments: list[str]) -> None:
    """Serve until the input ends; says {"bytes": ...} first, the peak memory when ready."""
    method, n_blocks, belt_velocity, noise, chains, warm_up = arguments
    from beltrepro.extras.bench.competitors import competitor

    chain = ChainParameters(int(n_blocks), float(belt_velocity), float(noise))
    runner = competitor(method, chain, int(chains), float(warm_up))
    print(json.dumps(_answer("memory", runner)), flush=True)
    for line in sys.stdin:
        print(json.dumps(_answer(line.strip(), runner)), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

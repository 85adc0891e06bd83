"""A process of its own that simulates on request; `measuring.Worker` starts it, for any tree.

It uses only what trees of other versions have, too. Each line of its input is a case as JSON:
method, n_blocks, belt_velocity, noise, chains, and the span of model time. Each answer is one line:
processor time in seconds, and the largest memory of the process so far in bytes.
"""

import json
import resource
import sys
import time
from pathlib import Path

from beltrepro import ChainParameters, scan


def _peak_memory() -> float:
    try:
        status = Path("/proc/self/status").read_text()
        return 1024.0 * float(status.partition("VmHWM:")[2].split()[0])
    except (OSError, IndexError):
        unit = 1 if sys.platform == "darwin" else 1024
        return float(unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


for line in sys.stdin:
    case = json.loads(line)
    chain = ChainParameters(case["n_blocks"], case["belt_velocity"], case["noise"])
    several = {"replicate": list(range(case["chains"])), "initial_spread": 1.0}
    start = time.process_time()
    scan([chain] * case["chains"], duration=case["span"], method=case["method"], **several)
    elapsed = time.process_time() - start
    print(json.dumps({"processor": elapsed, "bytes": _peak_memory()}), flush=True)

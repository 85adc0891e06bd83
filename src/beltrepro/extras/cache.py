"""Compiles all integrators before they are needed: `python -m beltrepro.extras.cache`."""

import logging
import time
from functools import partial

from beltrepro import ChainParameters, catalogue, lyapunov_spectrum, scan, simulate

KINDS = {
    "verlet": (simulate, scan, catalogue),
    "event": (
        *(simulate, scan, catalogue, lyapunov_spectrum),
        partial(lyapunov_spectrum, noise_clock="laboratory"),
    ),
}


def compile_kernels(method: str) -> None:
    """Simulate something of each kind for a moment; together that needs every kernel."""
    for noise in (0.0, 1.0):
        for function in KINDS[method]:
            chain = ChainParameters(2, 10.0, noise)
            function(chain, method=method, duration=30.0, transient=10.0)


if __name__ == "__main__":
    logging.getLogger("beltrepro").addHandler(logging.NullHandler())  # it is told here
    for method in KINDS:
        began = time.monotonic()
        compile_kernels(method)
        print(f"{method}: {time.monotonic() - began:.1f} s", flush=True)

"""Compiles all integrators before they are needed: `python -m beltrepro.extras.cache`."""

import logging
import time

from beltrepro import ChainParameters, catalogue, lyapunov_spectrum, scan, simulate

KINDS = {
    "verlet": (simulate, scan, catalogue),
    "event": (simulate, scan, catalogue, lyapunov_spectrum),
}


def main() -> None:
    """Simulate something of each kind for a moment; together that needs every kernel."""
    logger = logging.getLogger("beltrepro")
    logger.addHandler(logging.NullHandler())  # what is compiled is told here
    for noise in (0.0, 1.0):
        for method, functions in KINDS.items():
            began = time.monotonic()
            print(f"{method}, sigma = {noise:g} ... ", end="", flush=True)
            for function in functions:
                chain = ChainParameters(2, 10.0, noise)
                function(chain, method=method, duration=30.0, transient=10.0)
            print(f"{time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    main()

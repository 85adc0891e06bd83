"""Compiles all integrators before they are needed: `python -m beltrepro.extras.cache`."""

import logging
import time

from beltrepro import ChainParameters, catalogue, lyapunov_spectrum, scan, simulate
from beltrepro.simulation.setup import METHODS


def main() -> None:
    """Simulate something of each kind for a moment; together that needs every kernel."""
    logging.getLogger("beltrepro").addHandler(
        logging.NullHandler()
    )  # what is compiled is told here
    kinds = dict.fromkeys(METHODS, (simulate, scan, catalogue))
    for noise in (0.0, 1.0):
        for kind, functions in (kinds | {"exponents": (lyapunov_spectrum,)}).items():
            began = time.monotonic()
            print(f"{kind}, sigma = {noise:g} ... ", end="", flush=True)
            for function in functions:
                method = kind if kind in METHODS else "event"
                chain = ChainParameters(2, 10.0, noise)
                function(chain, method=method, duration=30.0, transient=10.0)
            print(f"{time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    main()

"""`beltrepro cache`: compile all integrators before they are needed."""

import argparse
import logging
import time
from functools import partial
from typing import Any

from beltrepro.cli import options as shared


def add(commands: Any) -> None:
    """Add the command."""
    shared.command(
        commands,
        run,
        "compile all integrators now, not when they are first needed",
        "Compile the machine code of all kinds of run for this processor: a minute or "
        "two, once. Otherwise the first run of a kind does it, in up to 20 s.",
    )


def run(options: argparse.Namespace) -> None:
    """Simulate something of each kind for a moment."""
    logging.getLogger("beltrepro").addHandler(logging.NullHandler())  # it is told here
    for words, call in _kinds().items():
        began = time.monotonic()
        print(f"{words} ... ", end="", flush=True)
        call()
        print(f"{time.monotonic() - began:.1f} s")


def _kinds() -> dict[str, Any]:
    """Calls that together need every kernel, by what they are."""
    from beltrepro import ChainParameters, chaos, simulation
    from beltrepro.simulation import METHODS

    quiet, noisy = ChainParameters(2, 10.0), ChainParameters(2, 10.0, 1.0)
    short: dict[str, Any] = {"duration": 30.0, "transient": 10.0}

    def runs(chain: ChainParameters, method: str) -> None:
        for function in (simulation.simulate, simulation.scan, simulation.catalogue):
            function(chain, method=method, **short)

    calls: dict[str, Any] = {}
    for words, chain in (("without noise", quiet), ("with noise", noisy)):
        for method in METHODS:
            calls[f"{method}, {words}"] = partial(runs, chain, method)
        calls[f"exponents, {words}"] = partial(chaos.lyapunov_spectrum, chain, **short)
    return calls

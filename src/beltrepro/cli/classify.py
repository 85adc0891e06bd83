"""`beltrepro classify`: what kind of motion one chain ends in."""

import argparse
from typing import Any

from beltrepro.cli import options as shared


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "tell what kind of motion one chain ends in",
        "Tell what kind of motion one chain ends in: equilibrium slip, periodic, quasi-periodic, "
        "chaotic or transient (with noise also noise-driven), by recurrence of its state and its "
        "largest Lyapunov exponent. Only event has one. Several motions can coexist: with an "
        "initial spread another replicate or seed starts elsewhere.",
        epilog=shared.UNITS,
    )
    shared.add_run(parser, seed=1, replicate=0)
    shared.add_spread(parser)


def run(options: argparse.Namespace) -> None:
    """Classify, and print the motion."""
    chain = shared.chain_of(options)
    from beltrepro.chaos import classify

    settings = shared.settings_of(options) | {"initial_spread": options.initial_spread}
    motion = dict(vars(classify(chain, **settings)))
    del settings["progress"], motion["parameters"]
    shared.print_result(shared.of_chain(chain) | settings | motion, options.json)

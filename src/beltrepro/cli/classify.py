"""`beltrepro classify`: what kind of motion one chain ends in, and how far its orbit reaches."""

import argparse
from typing import Any

from beltrepro.base.errors import InputError
from beltrepro.cli import options as shared


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "tell what kind of motion one chain ends in",
        "Tell what kind of motion one chain ends in: equilibrium slip, periodic, quasi-periodic, "
        "chaotic or transient (with noise also noise-driven), by recurrence of its state and its "
        "largest Lyapunov exponent. With --lower and --upper its periodic orbit is followed along "
        "the belt velocity or another constant of the chain, down and up, to where it ends: at a "
        "grazing, a fold, a period doubling, a torus, or the edge of the range. Only event has all "
        "this. Several motions can coexist: with an initial spread another replicate or seed "
        "starts elsewhere.",
        epilog=shared.UNITS,
    )
    shared.add_run(parser, seed=1, replicate=0)
    shared.add_spread(parser)
    option = parser.add_argument_group("branch of its periodic orbit").add_argument
    option("--lower", type=float, help="least value to look at")
    option("--upper", type=float, help="greatest value to look at")
    words = "what changes: belt_velocity, static_friction, ... (belt_velocity)"
    option("--quantity", default="belt_velocity", help=words)
    option("--step", type=float, help="largest step (a fiftieth of the range)")
    option("--unstable", action="store_true", help="go on where the orbit does not attract")


def run(options: argparse.Namespace) -> None:
    """Classify, or follow the orbit, and print what it is."""
    chain = shared.chain_of(options)
    settings = shared.settings_of(options) | {"initial_spread": options.initial_spread}
    if options.lower is not None or options.upper is not None:
        _follow(chain, settings, options)
        return
    for name in ("step", "unstable"):
        if getattr(options, name):
            raise InputError(f"{name}: only a branch has one, give --lower and --upper too")
    from beltrepro import classify

    motion = dict(vars(classify(chain, **settings)))
    del settings["progress"], motion["parameters"]
    shared.print_result(shared.of_chain(chain) | settings | motion, options.json)


def _follow(chain: Any, settings: dict[str, Any], options: argparse.Namespace) -> None:
    """Find the orbit, follow it, and print its ends and the table."""
    from beltrepro import orbit_branch, periodic_orbit
    from beltrepro.chaos.continuation import check_course

    course = {name: getattr(options, name) for name in ("lower", "upper", "step")}
    check_course(chain, options.quantity, **course)  # before the orbit is sought
    orbit = periodic_orbit(chain, **settings)
    how = {"unstable": options.unstable, "tolerance": options.tolerance}
    progress = shared.progress_of("branch")
    branch = orbit_branch(orbit, options.quantity, progress=progress, **course, **how)
    del settings["progress"]
    result = shared.of_chain(chain) | settings | {"quantity": branch.quantity, "word": branch.word}
    for side in ("lower", "upper"):
        result[side] = getattr(branch, side)
        result[f"{side}_end"] = getattr(branch, f"{side}_end").text
    result["passed"] = [f"{point.parameter:.6g}: {point.text}" for point in branch.passed]
    table = branch.table()
    if options.json:
        result["orbits"] = table.to_dict("list")
    shared.print_result(result, options.json)
    if not options.json:
        print(f"\n{table.to_string(index=False, float_format='{:.6g}'.format)}")

"""`beltrepro branch`: a periodic orbit followed along a constant of the chain."""

import argparse
from typing import Any

from beltrepro.cli import options as shared


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "follow the periodic orbit of one chain along the belt velocity",
        "Find the periodic orbit in which one chain ends, and follow it along the belt velocity or "
        "another constant of the chain, down and up, to where it ends: at a grazing, a fold, a "
        "period doubling, a torus, or the edge of the range. Only event has periodic orbits. "
        "Several motions can coexist: with an initial spread another replicate or seed starts "
        "elsewhere.",
        epilog=shared.UNITS,
    )
    shared.add_run(parser, seed=1, replicate=0)
    shared.add_spread(parser)
    option = parser.add_argument
    option("--lower", type=float, required=True, help="least value to look at")
    option("--upper", type=float, required=True, help="greatest value to look at")
    words = "what changes: belt_velocity, static_friction, ... (belt_velocity)"
    option("--quantity", default="belt_velocity", help=words)
    option("--step", type=float, help="largest step (a fiftieth of the range)")
    words = "go on where the orbit does not attract"
    option("--unstable", action="store_true", help=words)


def run(options: argparse.Namespace) -> None:
    """Find the orbit, follow it, and print its ends and the table."""
    chain = shared.chain_of(options)
    from beltrepro.chaos import continuation, orbit_branch, periodic_orbit

    course = {name: getattr(options, name) for name in ("lower", "upper", "step")}
    continuation.check_course(chain, options.quantity, **course)  # before the orbit is sought
    settings = shared.settings_of(options) | {"initial_spread": options.initial_spread}
    orbit = periodic_orbit(chain, **settings)
    course["unstable"] = options.unstable
    progress = shared.progress_of("branch")
    branch = orbit_branch(
        orbit, options.quantity, tolerance=options.tolerance, progress=progress, **course
    )
    del settings["progress"]
    ends = {f"{side}_end": getattr(branch, f"{side}_end").text for side in ("lower", "upper")}
    result = shared.of_chain(chain) | settings | {"quantity": branch.quantity}
    result |= {"word": branch.word, "lower": branch.lower, "upper": branch.upper, **ends}
    result["passed"] = [f"{point.parameter:.6g}: {point.text}" for point in branch.passed]
    table = branch.table()
    if options.json:
        shared.print_result(result | {"orbits": table.to_dict("list")}, as_json=True)
        return
    shared.print_result(result, as_json=False)
    print(f"\n{table.to_string(index=False, float_format='{:.6g}'.format)}")

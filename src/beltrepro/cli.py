"""The command `beltrepro`: single runs without the workflow."""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from beltrepro import ChainParameters, __version__
from beltrepro.errors import InputError, ModelStateError
from beltrepro.scripting import Progress

_UNITS = """\
All numbers are in model units: mass 0.1158 kg, spring constant 19.8 N/m, length 1.4 mm; so one unit
of time is 0.0765 s, of velocity 0.0183 m/s, of force 0.0277 N. A paper-length run has duration 2e6
and transient 1e6.

The file of --output holds time (T), positions, velocities and friction (T, N) of the samples, in
the laboratory frame, and the events; groups initial_state and final_state; and the settings as
attributes. In Python: beltrepro.Run.load(FILE).
"""


_FILM = 20.0  # seconds of a film, if nothing else is said


def main(arguments: list[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    arguments : list of str, optional
        Words after the command's name; those of the shell if not given.

    Returns
    -------
    int
        Exit status: 0, 2 for bad input, 1 for a failed run, 130 when interrupted.
    """
    parser = _parser()
    options = parser.parse_args(arguments)
    try:
        return options.action(options)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except (ModelStateError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="beltrepro", description="Chaos on the conveyor belt: simulate chains of blocks."
    )
    parser.add_argument("--version", action="version", version=f"beltrepro {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    simulate = commands.add_parser(
        "simulate",
        help="simulate one chain",
        description="Simulate one chain from all blocks stuck and undeformed springs.",
        epilog=_UNITS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_run(simulate, method="verlet", seed=None, replicate=None)
    add = simulate.add_argument
    add("--sample-interval", type=float, default=0.1, help="time between samples in --output")
    add(
        "--from-state",
        type=Path,
        metavar="FILE",
        help="go on where the run in this file, written by --output, has ended",
    )
    add("--output", type=Path, help="write the run to this HDF5 file, see below")
    simulate.set_defaults(action=_simulate)
    _add_classify(commands)
    _add_watch(commands)
    _add_bench(commands)
    return parser


def _add_run(
    command: argparse.ArgumentParser, *, method: str, seed: int | None, replicate: int | None
) -> None:
    """Options of a command that follows one chain, with their defaults."""
    _add_chain(command)
    add = command.add_argument
    add("--duration", type=float, required=True, help="time simulated, transient included")
    add("--transient", type=float, default=0.0, help="time left out of what is measured")
    add("--method", default=method, help=f"verlet, the paper's scheme, or event, exact ({method})")
    add("--time-step", type=float, default=0.001, help="dt (paper: 0.001)")
    add(
        "--tolerance",
        type=float,
        help="truncation allowed in a step of event (its own: 1e-10, more with noise)",
    )
    add("--seed", type=int, default=seed, help="fixes the random numbers; 1 if not given")
    add(
        "--replicate",
        type=int,
        default=replicate,
        help=f"another one has other random numbers; {replicate or 0} if not given",
    )
    add("--json", action="store_true", help="print the result as JSON")


def _add_chain(command: argparse.ArgumentParser) -> None:
    """Options that say which chain."""
    add = command.add_argument
    add("--n-blocks", type=int, required=True, help="number of blocks N")
    add("--belt-velocity", type=float, required=True, help="belt velocity u, units of 0.0183 m/s")
    add("--noise", type=float, default=0.0, help="noise strength sigma, units of 0.0277 N")


def _add_classify(commands: Any) -> None:
    classify = commands.add_parser(
        "classify",
        help="tell what kind of motion one chain ends in",
        description="Tell what kind of motion one chain ends in: equilibrium slip, periodic, "
        "quasi-periodic, chaotic or transient (with noise also noise-driven), by recurrence of "
        "its state and its largest Lyapunov exponent. Only event has one. The seed decides where "
        "the chain starts, because several motions can coexist.",
        epilog=_UNITS.partition("\n\n")[0],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_run(classify, method="event", seed=1, replicate=1)
    classify.add_argument(
        "--initial-spread",
        type=float,
        default=1.0,
        help="standard deviation of random displacements of the blocks at the start (1); "
        "replicate 0 has none",
    )
    classify.set_defaults(action=_classify)


def _add_watch(commands: Any) -> None:
    watch = commands.add_parser(
        "watch",
        help="watch one chain in a window, or film it",
        description="Watch one chain from above, in real time: which blocks stick and slip, the "
        "pull of the springs, x_N(t) and r. In the window, sliders change the belt velocity and "
        "the noise at once, and keys, which it lists, pause, step and change the speed. With "
        "--output it writes a film and needs no display. The motion is that of event.",
        epilog="Belt velocity, noise and transient are in model units: 0.0183 m/s, 0.0277 N and "
        "0.0765 s.",
    )
    add = watch.add_argument
    _add_chain(watch)
    add("--transient", type=float, default=0.0, help="model time that passes unseen first")
    add("--seed", type=int, default=1, help="fixes the random numbers (1)")
    add("--speed", type=float, default=1.0, help="seconds of the chain in a second shown (1)")
    add("--fps", type=float, default=24.0, help="frames in a second (24)")
    add("--output", type=Path, metavar="FILE", help="write a film, .mp4 or .gif")
    add("--duration", type=float, help="seconds of the film (20)")
    watch.set_defaults(action=_watch)


def _add_bench(commands: Any) -> None:
    bench = commands.add_parser(
        "bench",
        help="measure the speed of the integrators",
        description="Measure, in one interleaved run: nanoseconds per chain and unit of model "
        "time, beside plain loops and general solvers; scaling with chains, blocks and cores; "
        "peak memory; time to the first step. A few minutes; best on a machine that does nothing "
        "else.",
        epilog="Competitors: numba and c (a plain loop over one chain), scipy (solve_ivp) and "
        "heyoka (only without noise), steps (verlet without leaps; only without noise), verlet, "
        "event, tangent (event with a deviation vector). What cannot run here is n/a: c without a "
        "compiler, heyoka if it is not installed.",
    )
    add = bench.add_argument
    add("--rounds", type=int, default=5, help="timings of each quantity; the median counts")
    add("--quick", action="store_true", help="few cases, short timings: to see that it works")
    add("--only", metavar="NAME,NAME", help="some competitors; the loop in numba is always there")
    add("--json", action="store_true", help="print every timing as JSON instead of tables")
    add("--output", type=Path, help="write the tables to this Markdown file")
    bench.set_defaults(action=_bench)


def _chain(options: argparse.Namespace) -> ChainParameters:
    return ChainParameters(options.n_blocks, options.belt_velocity, options.noise)


def _numerics(options: argparse.Namespace) -> dict[str, Any]:
    """How a chain is followed."""
    names = ("duration", "transient", "method", "time_step", "tolerance", "seed", "replicate")
    progress = Progress(_chain(options).describe()) if sys.stderr.isatty() else None
    return {name: getattr(options, name) for name in names} | {"progress": progress}


def _simulate(options: argparse.Namespace) -> int:
    chain = _chain(options)
    _check_output(options.output)
    from beltrepro.simulation import Run, simulate

    run = simulate(
        chain,
        **_numerics(options),
        initial_state=Run.load(options.from_state).final_state if options.from_state else None,
        sample_interval=options.sample_interval if options.output else None,
    )
    assert isinstance(run, Run)  # as it was one chain
    if options.output:
        run.save(options.output)
    _print(_summary(run), options.json)
    return 0


def _summary(run: Any) -> dict[str, Any]:
    """What the command prints of a run."""
    chain = run.parameters
    return {
        "n_blocks": chain.n_blocks,
        "belt_velocity": chain.belt_velocity,
        "noise": chain.noise,
        "duration": run.duration,
        "transient": run.transient,
        "method": run.method,
        "time_step": run.time_step,
        **({} if run.tolerance is None else {"tolerance": run.tolerance}),
        "seed": run.seed,
        "replicate": run.replicate,
        "disorder_parameter": run.disorder_parameter,
        "mean_length": run.mean_length,
        "energy_residual": run.energy_residual,
        "events": len(run.events),
    }


def _classify(options: argparse.Namespace) -> int:
    chain = _chain(options)
    from beltrepro.chaos import classify

    settings = _numerics(options) | {"initial_spread": options.initial_spread}
    found = dict(vars(classify(chain, **settings)))
    del settings["progress"], found["parameters"]
    quantities = ("n_blocks", "belt_velocity", "noise")
    _print({name: getattr(chain, name) for name in quantities} | settings | found, options.json)
    return 0


def _watch(options: argparse.Namespace) -> int:
    chain = _chain(options)
    from beltrepro import watching

    clock = watching.Clock(options.speed, options.fps)
    if options.output is None:
        if options.duration is not None:
            raise InputError(
                f"duration = {options.duration:g}: only a film has one, give --output too"
            )
        watching.check_display()
        watching.open_window(watching.begin(chain, clock, options.transient, options.seed), clock)
        return 0
    duration = _FILM if options.duration is None else options.duration
    watching.check_film(options.output, duration, clock)
    progress = Progress("film") if sys.stderr.isatty() else None
    player = watching.begin(chain, clock, options.transient, options.seed)
    view = watching.write_film(options.output, player, clock, duration, progress)
    print(f"{options.output}: {1000 * view.metres_per_pixel:.4g} mm of the belt in a pixel")
    return 0


def _print(result: dict, as_json: bool) -> None:
    if as_json:
        known = {name: None if value != value else value for name, value in result.items()}
        print(json.dumps(known, indent=2))  # JSON has no NaN
        return
    width = max(map(len, result))
    for name, value in result.items():
        shown = f"{value:.6g}" if isinstance(value, float) else value
        print(f"{name:<{width}}  {shown}")


def _bench(options: argparse.Namespace) -> int:
    _check_output(options.output)
    from beltrepro.bench import measuring, table

    result = measuring.measure(
        options.rounds,
        quick=options.quick,
        only=[name.strip() for name in options.only.split(",")] if options.only else None,
        progress=Progress("bench") if sys.stderr.isatty() else None,
    )
    if options.output:
        options.output.write_text(table.as_markdown(result), encoding="utf-8")
    print(json.dumps(result, indent=2) if options.json else table.as_text(result))
    return 0


def _check_output(path: Path | None) -> None:
    if path is not None and not path.absolute().parent.is_dir():
        raise InputError(f"output = {path}: its folder does not exist")


if __name__ == "__main__":
    sys.exit(main())

"""Commands that follow chains: simulate, scan, plot, classify, watch."""

import argparse
import sys
from pathlib import Path
from typing import Any

import beltrepro
from beltrepro.base.checks import positive, within
from beltrepro.base.errors import InputError, needing
from beltrepro.cli import options as shared

_SHOWN = ("disorder_parameter", "mean_length", "section_count", "laminar_fraction")
_FILE = """ The file of --output holds time (T), positions, velocities and friction (T, N) of the
samples, in the laboratory frame, and the events; groups initial_state and final_state; and the
settings as attributes. In Python: beltrepro.Run.load(FILE)."""


@shared.command(
    *shared.NUMERICS,
    ("seed", int, None, "fixes the random numbers (1, or that of --from-state)"),
    ("replicate", int, None, "number of the repetition (0, or that of --from-state)"),
    shared.JSON,
    ("sample_interval", float, 0.1, "time between samples in --output (0.1)"),
    ("from_state", Path, None, "go on where the run in this file ended, with the chain given here"),
    ("output", Path, None, "write the run to this .h5 file, see below"),
    *shared.chain_options(),
    epilog=shared.UNITS + _FILE,
    suffixes=(".h5",),
)
def simulate(options: argparse.Namespace) -> None:
    """Simulate one chain from all blocks stuck and undeformed springs."""
    chain, settings = shared.chain_of(options), shared.settings_of(options)
    positive("sample_interval", options.sample_interval)  # also where there are no samples
    before = beltrepro.Run.load(options.from_state) if options.from_state else None
    if before and before.parameters != chain:
        old, new = (
            shared.values(before.parameters, *shared.CHAIN),
            shared.values(chain, *shared.CHAIN),
        )
        changes = ", ".join(f"{n} {old[n]} -> {new[n]}" for n in new if old[n] != new[n])
        print(f"warning: not the chain of {options.from_state}: {changes}", file=sys.stderr)
    run = beltrepro.simulate(
        chain,
        **settings,
        initial_state=before.final_state if before else None,
        sample_interval=options.sample_interval if options.output else None,
        progress=shared.progress_of(chain.describe()),
    )
    assert isinstance(run, beltrepro.Run)  # as it was one chain
    if options.output:
        run.save(options.output)
    measured = ("disorder_parameter", "mean_length", "energy_residual", "sum_rule_residual")
    result = shared.values(run, *settings, *measured) | {"events": len(run.events)}
    if run.tolerance is None:
        del result["tolerance"]
    shared.print_result(result, options.json, chain)


@shared.command(
    *shared.NUMERICS,
    shared.SEED,
    ("replicates", int, 1, "runs at each combination (1)"),
    shared.SPREAD,
    ("workers", int, None, "cores to use; all of them if not given"),
    ("json", bool, False, "print the table as JSON"),
    ("output", Path, None, "write the table to this .csv file, or all arrays to this .h5 file"),
    *shared.chain_options(shared.grid),
    epilog="All numbers are in model units, as in `beltrepro simulate --help`. In Python: "
    "beltrepro.scan and beltrepro.Grid.",
    suffixes=(".csv", ".h5"),
)
def scan(options: argparse.Namespace) -> None:
    """Measure r over a grid of chains.

    Chains at every combination of some values are simulated, and r, the mean length, slips and
    laminar phases of each are measured. A quantity of the chain is a number, a list 1,2,5 or a
    range START:STOP:STEP with both ends.
    """
    if options.json or options.output is None or options.output.suffix.lower() == ".csv":
        with needing("a table"):  # before hours of computing
            import pandas  # noqa: F401
    chains = beltrepro.Grid(**shared.values(options, *shared.CHAIN, "replicates"))
    names = (name for name, *_ in (*shared.NUMERICS, shared.SEED, shared.SPREAD))
    settings = shared.values(options, *names, "workers")
    results = beltrepro.scan(
        chains, **settings, section_values=0, progress=shared.progress_of("scan")
    )
    if options.output:
        results.save(options.output)
    if options.json:
        print(results.table().to_json(orient="records", indent=2, double_precision=15))
    elif options.output:
        print(f"{options.output}: {len(chains)} points")
    else:
        table = results.table()[[*results.axes, *_SHOWN]]
        print(table.to_string(index=False, float_format="{:.6g}".format))


@shared.command(
    ("run", Path, shared.PLACED, "the file of the run, .h5"),
    (
        "output",
        Path,
        None,
        "write the figure, .png, .pdf or .svg; without it a window opens, or the figure is written "
        "beside the run as .png where there is no display",
    ),
    suffixes=(".png", ".pdf", ".svg"),
)
def plot(options: argparse.Namespace) -> None:
    """Draw a run.

    The picture has x_N(t), r as it settles, and the slips of each block, of a run that
    `beltrepro simulate --output` wrote. In Python: beltrepro.Run.plot.
    """
    run = beltrepro.Run.load(options.run)
    with needing("a picture of a run"):
        from beltrepro.simulation import picture
    if options.output is None and not picture.display():
        options.output = options.run.with_suffix(".png")
        shared.check_output(options.output, options.force, options.suffixes)
        print(f"no display: the figure is written to {options.output}")
    run.plot(options.output)


@shared.command(
    *shared.NUMERICS,
    shared.SEED,
    shared.REPLICATE,
    shared.SPREAD,
    shared.JSON,
    *shared.chain_options(),
    "branch of its periodic orbit",
    ("lower", float, None, "least value to look at"),
    ("upper", float, None, "greatest value to look at"),
    ("quantity", str, "belt_velocity", "what changes, as static_friction"),
    ("step", float, None, "largest step (a fiftieth of the range)"),
    ("unstable", bool, False, "go on where the orbit does not attract"),
    epilog=shared.UNITS,
)
def classify(options: argparse.Namespace) -> None:
    """Tell what kind of motion one chain ends in.

    It is equilibrium slip, periodic, quasi-periodic, chaotic or transient (with noise also
    noise-driven), by recurrence of its state and its largest Lyapunov exponent. With --lower and
    --upper its periodic orbit is followed along the belt velocity or another constant of the chain,
    down and up, to where it ends: at a grazing, a fold, a period doubling, a torus, or the edge of
    the range. Only event has all this. Several motions can coexist: with an initial spread another
    replicate or seed starts elsewhere.
    """
    from beltrepro.simulation.setup import TOLERANCES  # loads numba

    chain = shared.chain_of(options)
    settings = shared.settings_of(options) | shared.values(options, "initial_spread")
    progress = shared.progress_of(chain.describe())
    used = settings | {"tolerance": options.tolerance or TOLERANCES["event"]}
    if options.lower is not None or options.upper is not None:
        orbit = beltrepro.periodic_orbit(chain, **settings, progress=progress)
        _follow(orbit, used, options)
        return
    for name in ("step", "unstable"):
        if getattr(options, name):
            raise InputError(f"{name}: only a branch has one, give --lower and --upper too")
    motion = beltrepro.classify(chain, **settings, progress=progress)
    measured = {name: value for name, value in vars(motion).items() if name != "parameters"}
    shared.print_result(used | measured, options.json, chain)


def _follow(orbit: Any, settings: dict[str, Any], options: argparse.Namespace) -> None:
    """Follow an orbit, and print its ends and the table."""
    course = shared.values(options, "lower", "upper", "step", "unstable", "tolerance")
    branch = beltrepro.orbit_branch(
        orbit, options.quantity, progress=shared.progress_of("branch"), **course
    )
    result = (
        settings
        | shared.values(branch, "quantity", "word", "lower", "upper")
        | {
            "lower_end": branch.lower_end.text,
            "upper_end": branch.upper_end.text,
            "passed": [f"{point.parameter:.6g}: {point.text}" for point in branch.passed],
        }
    )
    table = branch.table()
    if options.json:
        result["orbits"] = table.to_dict("list")
    shared.print_result(result, options.json, orbit.parameters)
    if not options.json:
        print(f"\n{table.to_string(index=False, float_format='{:.6g}'.format)}")


@shared.command(
    ("transient", float, 2615.0, "model time that passes unseen first (2615: 200 s, as the paper)"),
    shared.SEED,
    ("speed", float, 1.0, "seconds of the chain in a second shown (1)"),
    ("fps", float, 24.0, "frames in a second (24)"),
    ("output", Path, None, "write a film, .mp4"),
    ("duration", float, None, "seconds of the film (20)"),
    *shared.chain_options(),
    epilog="Belt velocity, noise and transient are in model units: 0.0183 m/s, 0.0277 N and "
    "0.0765 s.",
    suffixes=(".mp4",),
)
def watch(options: argparse.Namespace) -> None:
    """Watch one chain in a window, or film it.

    It is seen from above, in real time: which blocks stick and slip, the pull of the springs,
    x_N(t) and r. In the window, sliders change the belt velocity and the noise at once, and keys,
    which its title lists, pause, step and change the speed. With --output it writes a film and
    needs no display. The motion is that of event.
    """
    with needing("beltrepro watch", "watch"):
        from beltrepro.extras import watch as watching
    ends = watching.SPEEDS
    speed = within("speed", options.speed, ge=ends[0], le=ends[1])
    rate = within("fps", options.fps, ge=1, le=120)
    if options.duration is not None and not options.output:
        text = f"duration = {options.duration:g}: only a film has one, give --output too"
        raise InputError(text)
    chain = watching.Watched(shared.chain_of(options), options.transient, options.seed)
    if options.output:
        duration = 20.0 if options.duration is None else options.duration
        progress = shared.progress_of("film")
        count = watching.write_film(options.output, chain, speed, rate, duration, progress)
        print(f"{options.output}: {count} frames")
    else:
        watching.open_window(chain, speed, rate)

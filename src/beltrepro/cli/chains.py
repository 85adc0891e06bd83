"""Commands that follow chains: simulate, scan, plot, classify, watch."""

import argparse
from pathlib import Path

import beltrepro
from beltrepro.base.checks import within
from beltrepro.base.errors import InputError, needing
from beltrepro.cli import options as shared

_SHOWN = ("disorder_parameter", "mean_length", "section_count", "laminar_fraction")
_FILE = """ The file of --output holds time (T), positions, velocities and friction (T, N) of the
samples, in the laboratory frame, and the events; groups initial_state and final_state; and the
settings as attributes. In Python: beltrepro.Run.load(FILE)."""


@shared.command(
    *shared.ONE_CHAIN,
    shared.JSON,
    (
        "sample_interval",
        float,
        None,
        "time between samples in --output (0.1); changes r of 2500 time units by 1e-5",
    ),
    ("output", Path, None, "write the run to this .h5 file, see below"),
    *shared.chain_options(),
    epilog=shared.UNITS + _FILE,
    suffixes=(".h5",),
)
def simulate(options: argparse.Namespace) -> None:
    """Simulate one chain from all blocks stuck and undeformed springs."""
    chain, settings = shared.chain_of(options), shared.settings_of(options)
    shared.only_with_output(options, "sample_interval")
    interval = 0.1 if options.sample_interval is None else options.sample_interval
    run = beltrepro.simulate(
        chain,
        **settings,
        sample_interval=interval if options.output else None,
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
    ("on_error", str, "raise", "a chain that fails: raise ends all, nan leaves it out (raise)"),
    ("store", Path, None, "keep what is finished in this .h5 file, and compute what it lacks"),
    shared.JSON,
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
    range START:STOP:STEP with both ends (STOP if a step meets it).
    """
    if options.json or options.output is None or options.output.suffix.lower() == ".csv":
        with needing("a table"):  # before hours of computing
            import pandas  # noqa: F401
    if options.output and options.store and options.output.resolve() == options.store.resolve():
        raise InputError(f"output = {options.output}: is the store, which keeps all runs anyway")
    shared.check_axes(options)
    chains = beltrepro.Grid(**shared.values(options, *shared.CHAIN, "replicates"))
    names = (name for name, *_ in (*shared.NUMERICS, shared.SEED, shared.SPREAD))
    settings = shared.values(options, *names, "workers", "on_error", "store")
    results = beltrepro.scan(
        chains, **settings, section_values=0, progress=shared.progress_of("scan")
    )
    if options.output:
        results.save(options.output)
    if options.json:
        shared.print_json(results.table().to_dict("records"))
    elif options.output:
        print(f"{options.output}: {len(chains)} points")
    else:
        table = results.table()[[*results.axes, *_SHOWN]]
        print(table.to_string(index=False, float_format="{:.6g}".format))


@shared.command(
    ("run", Path, shared.PLACED, "the file of the run, .h5"),
    ("output", Path, None, "write the figure, .png, .pdf or .svg; without it a window opens"),
    suffixes=(".png", ".pdf", ".svg"),
)
def plot(options: argparse.Namespace) -> None:
    """Draw a run.

    The picture has x_N(t), r as it settles, and the slips of each block, of a run that
    `beltrepro simulate --output` wrote. In Python: beltrepro.Run.plot.
    """
    beltrepro.Run.load(options.run).plot(options.output)


@shared.command(
    *shared.ONE_CHAIN,
    shared.SPREAD,
    shared.JSON,
    *shared.chain_options(),
    epilog=shared.UNITS,
)
def classify(options: argparse.Namespace) -> None:
    """Tell what kind of motion one chain ends in.

    It is equilibrium slip, periodic, quasi-periodic, chaotic, stable chaos or transient (with noise
    also noise-driven), by recurrence of its state and its Lyapunov exponents. Only event has this.
    Several motions can coexist: with an initial spread each replicate but 0 starts elsewhere.
    """
    from beltrepro.simulation.setup import TOLERANCES  # loads numba

    chain = shared.chain_of(options)
    settings = shared.settings_of(options) | shared.values(options, "initial_spread")
    progress = shared.progress_of(chain.describe())
    used = settings | {"tolerance": options.tolerance or TOLERANCES["event"]}
    motion = beltrepro.classify(chain, **settings, progress=progress)
    measured = {name: value for name, value in vars(motion).items() if name != "parameters"}
    shared.print_result(used | measured, options.json, chain)


@shared.command(
    ("transient", float, 2615.0, "model time that passes unseen first (2615: 200 s, as the paper)"),
    shared.SEED,
    ("speed", float, 1.0, "seconds of the chain in a second shown (1)"),
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
    shared.only_with_output(options, "duration")
    chain = watching.Watched(shared.chain_of(options), options.transient, options.seed)
    if options.output:
        duration = 20.0 if options.duration is None else options.duration
        progress = shared.progress_of("film")
        count = watching.write_film(options.output, chain, speed, duration, progress)
        print(f"{options.output}: {count} frames")
    else:
        watching.open_window(chain, speed)

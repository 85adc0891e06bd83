"""The command `beltrepro`: single runs without the workflow."""

import argparse
import json
import os
import sys
from collections import Counter
from pathlib import Path
from typing import Any

from beltrepro import __version__
from beltrepro.base.checks import positive
from beltrepro.base.errors import InputError, ModelStateError, needing
from beltrepro.cli import cache, claims, plot, publish, scan
from beltrepro.cli.options import (
    Parser,
    add_chain,
    add_output,
    add_run,
    chain_of,
    check_output,
    numerics,
    own_constants,
    print_result,
    progress_of,
)
from beltrepro.replication.camera.scene import camera_settings

_UNITS = """\
All numbers are in model units: mass 0.1158 kg, spring constant 19.8 N/m, length 1.4 mm; so one unit
of time is 0.0765 s, of velocity 0.0183 m/s, of force 0.0277 N. A paper-length run has duration 2e6
and transient 1e6.

The file of --output holds time (T), positions, velocities and friction (T, N) of the samples, in
the laboratory frame, and the events; groups initial_state and final_state; and the settings as
attributes. In Python: beltrepro.Run.load(FILE).
"""


_FILM = 20.0  # seconds of a film, if nothing else is said
_LEAST_IN_WINDOW = 3  # samples that tell an amplitude


def main(arguments: list[str] | None = None) -> int:
    """Run the command."""
    parser = _parser()
    options = parser.parse_args(arguments)
    try:
        with needing(f"beltrepro {options.command}"):
            status = options.action(options)
        sys.stdout.flush()
        return status
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # What is still to be written at the exit must find a reader.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except (ModelStateError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="beltrepro", description="Chaos on the conveyor belt: simulate chains of blocks."
    )
    parser.add_argument("--version", action="version", version=f"beltrepro {__version__}")
    commands = parser.add_subparsers(required=True, dest="command", metavar="COMMAND")
    simulate = commands.add_parser(
        "simulate",
        help="simulate one chain",
        description="Simulate one chain from all blocks stuck and undeformed springs.",
        epilog=_UNITS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_run(simulate)
    add = simulate.add_argument
    add("--sample-interval", type=float, default=0.1, help="time between samples in --output")
    add(
        "--from-state",
        type=Path,
        metavar="FILE",
        help="go on where the run in this file, written by --output, has ended",
    )
    add_output(simulate, "write the run to this .h5 file, see below")
    simulate.set_defaults(action=_simulate)
    scan.add(commands)
    plot.add(commands)
    _add_classify(commands)
    _add_watch(commands)
    _add_bench(commands)
    _add_film(commands)
    _add_track(commands)
    _add_analyse(commands)
    _add_verify(commands)
    claims.add(commands)
    cache.add(commands)
    publish.add(commands)
    return parser


def _add_classify(commands: Any) -> None:
    classify = commands.add_parser(
        "classify",
        help="tell what kind of motion one chain ends in",
        description="Tell what kind of motion one chain ends in: equilibrium slip, periodic, "
        "quasi-periodic, chaotic or transient (with noise also noise-driven), by recurrence of "
        "its state and its largest Lyapunov exponent. Only event has one. Several motions can "
        "coexist: with an initial spread another replicate or seed starts elsewhere.",
        epilog=_UNITS.partition("\n\n")[0],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_run(classify)
    classify.add_argument(
        "--initial-spread",
        type=float,
        default=0.0,
        help="standard deviation of random displacements of the blocks at the start (0); "
        "replicate 0 has none",
    )
    classify.set_defaults(action=_classify, seed=1, replicate=0)


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
    add_chain(watch)
    add("--transient", type=float, default=0.0, help="model time that passes unseen first")
    add("--seed", type=int, default=1, help="fixes the random numbers (1)")
    add("--speed", type=float, default=1.0, help="seconds of the chain in a second shown (1)")
    add("--fps", type=float, default=24.0, help="frames in a second (24)")
    add_output(watch, "write a film, .mp4 or .gif")
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
    add(
        "--against",
        type=Path,
        metavar="FOLDER",
        help="another source tree: only verlet and event, here and there in turns",
    )
    add("--json", action="store_true", help="print every timing as JSON instead of tables")
    add_output(bench, "write the tables to this Markdown file, .md")
    bench.set_defaults(action=_bench)


def _add_film(commands: Any) -> None:
    film = commands.add_parser(
        "film",
        help="film one chain, as a camera above the treadmill would",
        description="Simulate one chain and write what a camera above the belt would take of it: "
        "an ordinary video, which `beltrepro track` can measure. The transient is not filmed.",
        epilog=_UNITS.partition("\n\n")[0],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_run(film)
    add_output(film, "the video, .mp4, .mov or .mkv", required=True)
    camera = film.add_argument_group("camera").add_argument
    for name, setting in camera_settings().items():
        kind = int if isinstance(setting.default, int) else float
        words, default = setting.metadata["words"], setting.default
        shown = "" if default is None else f" ({default})"
        camera(f"--{name.replace('_', '-')}", type=kind, default=default, help=words + shown)
    film.set_defaults(action=_film, seed=1, replicate=0)


def _add_track(commands: Any) -> None:
    track = commands.add_parser(
        "track",
        help="track the white block in a video",
        description="Find the white block in each frame of a video from above the belt. Belt and "
        "scale are found by a tape measure beside the chain (docs/experiment.md).",
    )
    add = track.add_argument
    add("video", type=Path, help="the video, in any format that FFmpeg reads")
    add_output(track, "write time_s, x_m, error_m to this CSV file", required=True)
    add("--scale", type=float, metavar="METRES_PER_PIXEL", help="scale, if there is no tape")
    add("--first-mark", type=float, help="what the tape reads at the first mark that is seen, m")
    add("--support", default="auto", help="side where the chain is held: left, right or auto")
    add("--block-length", type=float, default=0.04, help="of a block, along the belt, m (0.04)")
    add("--block-width", type=float, default=0.08, help="of a block, across the belt, m (0.08)")
    add("--mark-spacing", type=float, default=0.01, help="of the marks of the tape, m (0.01)")
    add("--json", action="store_true", help="print the result as JSON")
    track.set_defaults(action=_track)


def _add_analyse(commands: Any) -> None:
    analyse = commands.add_parser(
        "analyse",
        help="analyse a recording of the last block",
        description="Compute r, the mean length, stretches of small amplitude and spectra of a "
        "recording: a CSV file with the columns time_s and x_m (from the support, metres).",
    )
    add = analyse.add_argument
    add("recording", type=Path, help="the CSV file, for instance of `beltrepro track`")
    add_output(analyse, "draw it like Figs. 4 and 5 of the paper: .png, .pdf or .svg")
    add("--transient", type=float, default=0.0, help="seconds left out first (paper: 200)")
    add("--window", type=float, default=5.0, help="seconds over which an amplitude is taken (5)")
    add("--quiet", type=float, default=0.05, help="amplitude over length that is small (0.05)")
    add("--json", action="store_true", help="print the result as JSON")
    analyse.set_defaults(action=_analyse)


def _simulate(options: argparse.Namespace) -> int:
    chain = chain_of(options)
    check_output(options, ".h5")
    positive("sample_interval", options.sample_interval)  # also where there are no samples
    from beltrepro.simulation import Run, simulate

    run = simulate(
        chain,
        **numerics(options),
        initial_state=Run.load(options.from_state).final_state if options.from_state else None,
        sample_interval=options.sample_interval if options.output else None,
    )
    assert isinstance(run, Run)  # as it was one chain
    if options.output:
        run.save(options.output)
    print_result(_summary(run), options.json)
    return 0


def _summary(run: Any) -> dict[str, Any]:
    """What the command prints of a run."""
    chain = run.parameters
    return {
        "n_blocks": chain.n_blocks,
        "belt_velocity": chain.belt_velocity,
        "noise": chain.noise,
        **own_constants(chain),
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
    chain = chain_of(options)
    from beltrepro.chaos import classify

    settings = numerics(options) | {"initial_spread": options.initial_spread}
    found = dict(vars(classify(chain, **settings)))
    del settings["progress"], found["parameters"]
    quantities = ("n_blocks", "belt_velocity", "noise")
    told = {name: getattr(chain, name) for name in quantities} | own_constants(chain)
    print_result(told | settings | found, options.json)
    return 0


def _watch(options: argparse.Namespace) -> int:
    chain = chain_of(options)
    with needing("beltrepro watch", "watch"):
        from beltrepro.extras import watch as watching

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
    check_output(options)
    watching.check_film(options.output, duration, clock)
    progress = progress_of("film")
    player = watching.begin(chain, clock, options.transient, options.seed)
    view = watching.write_film(options.output, player, clock, duration, progress)
    print(f"{options.output}: {1000 * view.metres_per_pixel:.4g} mm of the belt in a pixel")
    return 0


def _bench(options: argparse.Namespace) -> int:
    check_output(options, ".md")
    from beltrepro.extras.bench import measuring, table

    settings = {
        "rounds": options.rounds,
        "quick": options.quick,
        "only": [name.strip() for name in options.only.split(",")] if options.only else None,
        "progress": progress_of("bench"),
    }
    if options.against:
        if options.output:
            raise InputError("output: not with --against, which prints its table")
        result: Any = measuring.compare(options.against, **settings)
        text = table.comparison(result, str(options.against))
    else:
        result = measuring.measure(**settings)
        text = table.as_text(result)
    if options.output:
        options.output.write_text(table.as_markdown(result), encoding="utf-8")
    print(json.dumps(result, indent=2) if options.json else text)
    return 0


def _film(options: argparse.Namespace) -> int:
    chain = chain_of(options)
    check_output(options, ".mp4", ".mov", ".mkv")
    from beltrepro.model.units import TIME_S
    from beltrepro.replication.camera.camera import film
    from beltrepro.replication.camera.scene import Camera
    from beltrepro.replication.camera.video import check_suffix
    from beltrepro.simulation import Run, simulate

    check_suffix(options.output)
    camera = Camera(
        **{name: getattr(options, name) for name in camera_settings()}, seed=options.seed
    )
    run = simulate(
        chain,
        **numerics(options),
        sample_interval=1 / camera.frames_per_second / TIME_S,
        sample_start=options.transient,
    )
    assert isinstance(run, Run)  # as it was one chain
    progress = progress_of("film")
    frames = film(run, options.output, camera=camera, progress=progress)
    last = run.positions[:, -1]
    result = {
        "output": str(options.output),
        "frames": frames,
        "seconds": len(run.time) / camera.frames_per_second,
        "disorder_parameter": float(last.std() / last.mean()),
    }
    print_result(result, options.json)
    return 0


def _track(options: argparse.Namespace) -> int:
    check_output(options, ".csv")
    from beltrepro.replication.camera.scene import Scene
    from beltrepro.replication.camera.tracking import track

    sizes = ("block_length", "block_width", "mark_spacing")
    found = track(
        options.video,
        metres_per_pixel=options.scale,
        first_mark=options.first_mark,
        support=options.support,
        scene=Scene(**{name: getattr(options, name) for name in sizes}),
    )
    found.save(options.output)
    result = {
        "output": str(options.output),
        "frames": len(found.time_s),
        "seconds": float(found.time_s[-1] - found.time_s[0]),
        "metres_per_pixel": found.metres_per_pixel,
        "angle": found.angle,
        "error_m": float((found.error_m**2).mean() ** 0.5),
        "lost_s": found.lost_s.tolist(),
    }
    if not options.json:
        stretches = ", ".join(f"{begin:.2f} to {end:.2f}" for begin, end in result["lost_s"])
        result["lost_s"] = stretches or "none"
    print_result(result, options.json)
    return 0


def _analyse(options: argparse.Namespace) -> int:
    check_output(options, ".png", ".pdf", ".svg")
    from beltrepro.base.checks import not_negative, positive
    from beltrepro.replication.camera.recording import analyse
    from beltrepro.replication.camera.tables import read_track
    from beltrepro.stats.errors import NotEnoughDataError

    for check, name in ((not_negative, "transient"), (positive, "window"), (positive, "quiet")):
        check(name, getattr(options, name))
    (time_s, x_m, _), _ = read_track(options.recording)
    try:
        found = analyse(
            time_s,
            x_m,
            transient_s=options.transient,
            window_s=options.window,
            quiet=options.quiet,
        )
    except NotEnoughDataError as error:
        raise InputError(f"{options.recording}: {error}") from None
    if options.window < _LEAST_IN_WINDOW * found.interval_s:
        raise InputError(
            f"window = {options.window:g}: it must hold {_LEAST_IN_WINDOW} samples or more, and "
            f"{options.recording} has one every {found.interval_s:.3g} s"
        )
    if options.output:
        from beltrepro.replication.studies.experiment.recording_figure import save

        save(found, options.output)
    print_result(_told(found), options.json)
    return 0


def _add_verify(commands: Any) -> None:
    verify = commands.add_parser(
        "verify",
        help="check results of the workflow, and compare them with the published list",
        description="Check that every dataset and table of a run is whole, and compare it with a "
        "list of checksums: bit by bit if the processor, its instructions and the libraries are "
        "those of the list, otherwise within bounds (docs/integrity.md). Exit status 1 if "
        "anything is wrong; each line of it has the command that repairs it.",
    )
    add = verify.add_argument
    add("results", type=Path, help="folder of a run, as results/smoke")
    add("--list", type=Path, metavar="FILE", help="the list (docs/results/NAME.json)")
    add("--write", action="store_true", help="write the list from these results instead")
    verify.set_defaults(action=_verify)


def _verify(options: argparse.Namespace) -> int:
    from beltrepro.extras import verification

    path = options.list or Path("docs", "results", f"{options.results.name}.json")
    if options.write:
        count = verification.write_list(path, options.results)
        print(f"{path}: {count} datasets")
        return 0
    if not options.results.is_dir():
        raise InputError(f"{options.results}: no such folder")
    found = list(verification.compare(options.results, verification.read_list(path)))
    wrong = [each for each in found if each.outcome == verification.WRONG]
    for each in wrong:
        print(f"error: {each.words}", file=sys.stderr)
    counts = Counter(each.outcome for each in found)
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    print(verification.conclusion(found))
    return int(bool(wrong))


def _told(found: Any) -> dict[str, Any]:
    """What the command prints of a recording."""
    from beltrepro.model.units import from_si

    names = ("disorder_parameter", "mean_length", "minimum_length", "maximum_length")
    laws = {name: spectrum.law for name, spectrum in found.spectra.items() if spectrum.law}
    return {
        "samples": len(found.time_s),
        "seconds": found.observed_s,
        **{name: getattr(found, name) for name in names},
        "mean_length_model": float(from_si(found.mean_length, "length")),
        "small_amplitude_share": found.small_share,
        "lasting_small_amplitude_share": found.lasting_share,
        **{f"exponent_{name}": law.exponent for name, law in laws.items()},
        **{f"exponent_error_{name}": law.exponent_error for name, law in laws.items()},
    }


if __name__ == "__main__":
    sys.exit(main())

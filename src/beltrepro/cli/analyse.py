"""`beltrepro analyse`: what a recording of the last block tells."""

import argparse
from pathlib import Path
from typing import Any

from beltrepro.base.checks import not_negative, positive
from beltrepro.base.errors import InputError
from beltrepro.cli import options as shared
from beltrepro.model.units import from_si


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "analyse a recording of the last block",
        "Compute r, the mean length, stretches of small amplitude and spectra of a recording: a "
        "CSV file with the columns time_s and x_m (from the support, metres). Intervals (low, "
        "high) hold 95 %, for a recording of this length at its scale and zero.",
    )
    option = parser.add_argument
    option("recording", type=Path, help="the CSV file, for instance of `beltrepro track`")
    shared.add_output(parser, "draw it like Figs. 4 and 5 of the paper: .png, .pdf or .svg")
    option("--transient", type=float, default=0.0, help="seconds left out first (paper: 200)")
    option("--window", type=float, default=5.0, help="seconds over which an amplitude is taken (5)")
    words = "share of the length below which an amplitude is small (0.05)"
    option("--quiet", type=float, default=0.05, help=words)
    words = "length of a block in metres: N - 1/2 of them are taken off, as in the model (0)"
    option("--block-length", type=float, default=0.0, help=words)
    option("--n-blocks", type=int, default=5, help="blocks of the chain, N (5)")
    option("--json", action="store_true", help=shared.JSON)


def run(options: argparse.Namespace) -> None:
    """Analyse, print the numbers and draw the figure."""
    shared.check_output(options, ".png", ".pdf", ".svg")
    from beltrepro.base.errors import NotEnoughDataError
    from beltrepro.replication.camera.recording import analyse
    from beltrepro.replication.camera.scene import lengths_of_blocks
    from beltrepro.replication.camera.track import Track

    not_negative("block_length", options.block_length)
    positive("n_blocks", options.n_blocks)
    track = Track.load(options.recording)
    settings = {
        "transient_s": options.transient,
        "window_s": options.window,
        "quiet": options.quiet,
        "blocks_m": lengths_of_blocks(options.n_blocks, options.block_length),
    }
    try:
        recording = analyse(track.time_s, track.x_m, **settings)
    except NotEnoughDataError as error:
        raise InputError(f"{options.recording}: {error}") from None
    if options.window < 3 * recording.interval_s:
        raise InputError(
            f"window = {options.window:g}: it must hold 3 samples or more, and "
            f"{options.recording} has one every {recording.interval_s:.3g} s"
        )
    if options.output:
        from beltrepro.replication.studies.experiment.figures import save

        save(recording, options.output)
    result: dict[str, Any] = {
        "samples": len(recording.time_s),
        "seconds": recording.observed_s,
        **_with_ends("disorder_parameter", recording.disorder),
        **_with_ends("mean_length", recording.length),
        "independent_stretches": recording.disorder.runs,
        "minimum_length": float(recording.x_m.min()),
        "maximum_length": float(recording.x_m.max()),
        "mean_length_model": float(from_si(recording.mean_length, "length")),
        "small_amplitude_share": recording.small_share,
        "lasting_small_amplitude_share": recording.lasting_share,
    }
    for name, spectrum in recording.spectra.items():
        if spectrum.exponent:
            result |= _with_ends(f"exponent_{name}", spectrum.exponent)
    result["blocks_m"] = settings["blocks_m"]
    if not options.json and not settings["blocks_m"]:
        result["blocks_m"] = (
            "0: x_N of a real chain holds N - 1/2 block lengths that the model does not have; "
            "--block-length takes them off"
        )
    shared.print_result(result, options.json)


def _with_ends(name: str, estimate: Any) -> dict[str, float]:
    """A number and the ends of its 95 % interval."""
    return dict(zip((name, f"{name}_low", f"{name}_high"), estimate.numbers, strict=True))

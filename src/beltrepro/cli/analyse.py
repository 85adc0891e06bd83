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
        "analyse",
        run,
        "analyse a recording of the last block",
        "Compute r, the mean length, stretches of small amplitude and spectra of a recording: a "
        "CSV file with the columns time_s and x_m (from the support, metres).",
    )
    option = parser.add_argument
    option("recording", type=Path, help="the CSV file, for instance of `beltrepro track`")
    shared.add_output(parser, "draw it like Figs. 4 and 5 of the paper: .png, .pdf or .svg")
    option("--transient", type=float, default=0.0, help="seconds left out first (paper: 200)")
    option("--window", type=float, default=5.0, help="seconds over which an amplitude is taken (5)")
    option("--quiet", type=float, default=0.05, help="amplitude over length that is small (0.05)")
    option("--json", action="store_true", help=shared.JSON)


def run(options: argparse.Namespace) -> None:
    """Analyse, print the numbers and draw the figure."""
    shared.check_output(options, ".png", ".pdf", ".svg")
    from beltrepro.base.errors import NotEnoughDataError
    from beltrepro.replication.camera.recording import analyse
    from beltrepro.replication.camera.track_file import read_track

    for check, name in ((not_negative, "transient"), (positive, "window"), (positive, "quiet")):
        check(name, getattr(options, name))
    (time_s, x_m, _), _ = read_track(options.recording)
    settings = {"transient_s": options.transient, "window_s": options.window}
    try:
        recording = analyse(time_s, x_m, **settings, quiet=options.quiet)
    except NotEnoughDataError as error:
        raise InputError(f"{options.recording}: {error}") from None
    if options.window < 3 * recording.interval_s:
        raise InputError(
            f"window = {options.window:g}: it must hold 3 samples or more, and "
            f"{options.recording} has one every {recording.interval_s:.3g} s"
        )
    if options.output:
        from beltrepro.replication.studies.experiment.recording_figure import save

        save(recording, options.output)
    names = ("disorder_parameter", "mean_length", "minimum_length", "maximum_length")
    result = {
        "samples": len(recording.time_s),
        "seconds": recording.observed_s,
        **{name: getattr(recording, name) for name in names},
        "mean_length_model": float(from_si(recording.mean_length, "length")),
        "small_amplitude_share": recording.small_share,
        "lasting_small_amplitude_share": recording.lasting_share,
    }
    for part in ("exponent", "exponent_error"):
        for name, spectrum in recording.spectra.items():
            if spectrum.law:
                result[f"{part}_{name}"] = getattr(spectrum.law, part)
    shared.print_result(result, options.json)

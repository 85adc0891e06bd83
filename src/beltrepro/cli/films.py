"""Commands of the experiment: film, track, analyse."""

import argparse
import math
from pathlib import Path
from typing import Any

import beltrepro
from beltrepro.base.checks import not_negative, positive, within
from beltrepro.base.errors import InputError, NotEnoughDataError
from beltrepro.cli import options as shared
from beltrepro.model.parameters import LIMITS
from beltrepro.model.units import TIME_S, from_si
from beltrepro.replication.camera.scene import Camera, Scene, camera_settings, lengths_of_blocks


@shared.command(
    *shared.ONE_CHAIN,
    shared.JSON,
    ("output", Path, shared.REQUIRED, "the video, .mp4, .mov or .mkv"),
    *shared.chain_options(),
    "camera",
    *(
        shared.field_option(one, one.metadata["words"].rstrip(".").replace("null", "not given"))
        for one in camera_settings().values()
    ),
    epilog=f"{shared.UNITS} Only the camera's are in seconds, metres and pixels.",
    suffixes=(".mp4", ".mov", ".mkv"),
)
def film(options: argparse.Namespace) -> None:
    """Film one chain, as a camera above the treadmill would.

    The film is an ordinary video, which `beltrepro track` measures with the scale and zero that are
    printed. The transient is not filmed. The time step of verlet becomes one that divides the time
    between frames.
    """
    from beltrepro.replication.camera import camera as cameras

    chain = shared.chain_of(options)
    camera = Camera(**shared.values(options, *camera_settings()), seed=options.seed)
    interval = 1 / camera.frames_per_second / TIME_S
    if options.method == "verlet":
        steps = math.ceil(interval / within("time_step", options.time_step, **LIMITS["time_step"]))
        options.time_step = interval / steps
    run = beltrepro.simulate(
        chain,
        **shared.settings_of(options),
        sample_interval=interval,
        sample_start=options.transient,
        progress=shared.progress_of(chain.describe()),
    )
    assert isinstance(run, beltrepro.Run)  # as it was one chain
    movement, progress = cameras.Movement.of(run), shared.progress_of("film")
    frames = cameras.film(movement, options.output, camera=camera, progress=progress)
    view = cameras.Framing.of(movement, Scene(), camera)
    result = {
        "output": str(options.output),
        "frames": frames,
        "seconds": len(run.time) / camera.frames_per_second,
        "scale": view.metres_per_pixel,
        "zero": view.zero[0],
        "disorder_parameter": run.disorder_parameter,
    }
    shared.print_result(result, options.json)


@shared.command(
    ("video", Path, shared.PLACED, "the video, in any format that FFmpeg reads"),
    ("output", Path, shared.REQUIRED, "write time_s, x_m to this CSV file"),
    ("scale", float, None, "scale of the picture, metres per pixel"),
    ("zero", float, None, "column of the point where x is 0, pixels"),
    ("support", str, "left", "side where the chain is held, left or right (left)"),
    shared.JSON,
    suffixes=(".csv",),
)
def track(options: argparse.Namespace) -> None:
    """Track the white block in a video of known scale.

    It is found in each frame of a video from straight above the belt. The scale and the zero of the
    video must be known (docs/experiment.md).
    """
    from beltrepro.replication.camera import track as tracking

    track = tracking.track(options.video, **shared.values(options, "scale", "zero", "support"))
    track.save(options.output)
    result: dict[str, Any] = {
        "output": str(options.output),
        "frames": len(track.time_s),
        "seconds": float(track.time_s[-1] - track.time_s[0]),
        "angle": track.angle,
        "lost_s": track.lost_s.tolist(),
    }
    shared.print_result(result, options.json)


@shared.command(
    ("recording", Path, shared.PLACED, "the CSV file, for instance of `beltrepro track`"),
    ("output", Path, None, "draw it like Figs. 4 and 5 of the paper: .png, .pdf or .svg"),
    ("transient", float, 0.0, "seconds left out first (paper: 200)"),
    ("window", float, 5.0, "seconds over which an amplitude is taken (5)"),
    ("quiet", float, 0.05, "share of the length below which an amplitude is small (0.05)"),
    ("block_length", float, 0.0, "of a block, metres; N - 1/2 are taken off, as in the model (0)"),
    ("n_blocks", int, 5, "blocks of the chain, N (5)"),
    shared.JSON,
    suffixes=(".png", ".pdf", ".svg"),
)
def analyse(options: argparse.Namespace) -> None:
    """Analyse a recording of the last block.

    This computes r, the mean length, stretches of small amplitude and spectra of a recording: a CSV
    file with the columns time_s and x_m (from the support, metres). Intervals (low, high) hold
    95 %, for a recording of this length at its scale and zero; fewer where its regimes last for a
    tenth of it or more.
    """
    from beltrepro.replication.camera import recording as recordings
    from beltrepro.replication.camera.track import Track

    not_negative("block_length", options.block_length)
    positive("n_blocks", options.n_blocks)
    blocks_m = lengths_of_blocks(options.n_blocks, options.block_length)
    track = Track.load(options.recording)
    settings = {"transient_s": options.transient, "window_s": options.window}
    settings |= {"quiet": options.quiet, "blocks_m": blocks_m, "n_blocks": options.n_blocks}
    try:
        recording = recordings.analyse(track.time_s, track.x_m, **settings)
    except NotEnoughDataError as error:
        raise InputError(f"{options.recording}: {error}") from None
    if options.output:
        from beltrepro.replication.studies.experiment.figures import save

        save(recording, options.output)
    result: dict[str, Any] = {
        "samples": len(recording.time_s),
        "seconds": recording.observed_s,
        **_with_ends("disorder_parameter", recording.disorder),
        **_with_ends("mean_length", recording.length),
        "independent_stretches": recording.disorder.runs,
        "mean_length_model": float(from_si(recording.mean_length, "length")),
        "small_amplitude_share": recording.small_share,
        "lasting_small_amplitude_share": recording.lasting_share,
    }
    for name, spectrum in recording.spectra.items():
        if spectrum.exponent:
            result |= _with_ends(f"exponent_{name}", spectrum.exponent)
    result["blocks_m"] = blocks_m
    if not options.json and not blocks_m:
        result["blocks_m"] = (
            "0: x_N of a real chain holds N - 1/2 block lengths that the model does not have; "
            "--block-length takes them off"
        )
    shared.print_result(result, options.json)


def _with_ends(name: str, estimate: Any) -> dict[str, float]:
    """A number and the ends of its 95 % interval."""
    return dict(zip((name, f"{name}_low", f"{name}_high"), estimate.numbers, strict=True))

"""`beltrepro film`: one chain, as a camera above the treadmill would film it."""

import argparse
from typing import Any

from beltrepro.cli import options as shared
from beltrepro.replication.camera.scene import Camera, camera_settings


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "film one chain, as a camera above the treadmill would",
        "Simulate one chain and write what a camera above the belt would take of it: an ordinary "
        "video, which `beltrepro track` measures with the scale and zero that are printed. The "
        "transient is not filmed.",
        epilog=f"{shared.UNITS} Only the camera's are in seconds, metres and pixels.",
    )
    shared.add_run(parser, seed=1, replicate=0)
    shared.add_output(parser, "the video, .mp4, .mov or .mkv", required=True)
    camera = parser.add_argument_group("camera")
    for setting in camera_settings().values():
        words = setting.metadata["words"].replace("null for", "if not given,")
        shared.add_field(camera, setting, words)


def run(options: argparse.Namespace) -> None:
    """Simulate and film."""
    chain = shared.chain_of(options)
    shared.check_output(options, ".mp4", ".mov", ".mkv")
    from beltrepro import Run, simulate
    from beltrepro.model.units import TIME_S
    from beltrepro.replication.camera.camera import Framing, Movement, film
    from beltrepro.replication.camera.scene import Scene

    settings = {name: getattr(options, name) for name in camera_settings()}
    camera = Camera(**settings, seed=options.seed)
    filmed = simulate(
        chain,
        **shared.settings_of(options),
        sample_interval=1 / camera.frames_per_second / TIME_S,
        sample_start=options.transient,
    )
    assert isinstance(filmed, Run)  # as it was one chain
    frames = film(filmed, options.output, camera=camera, progress=shared.progress_of("film"))
    view = Framing.of(Movement.of(filmed), Scene(), camera)
    last = filmed.positions[:, -1]
    result = {
        "output": str(options.output),
        "frames": frames,
        "seconds": len(filmed.time) / camera.frames_per_second,
        "scale": view.metres_per_pixel,
        "zero": view.zero[0],
        "disorder_parameter": float(last.std() / last.mean()),
    }
    shared.print_result(result, options.json)

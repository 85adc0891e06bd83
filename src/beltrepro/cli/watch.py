"""`beltrepro watch`: one chain in a window, or as a film."""

import argparse
from typing import Any

from beltrepro.base.checks import within
from beltrepro.base.errors import InputError, needing
from beltrepro.cli import options as shared


def add(commands: Any) -> None:
    """Add the command."""
    parser = shared.command(
        commands,
        run,
        "watch one chain in a window, or film it",
        "Watch one chain from above, in real time: which blocks stick and slip, the pull of the "
        "springs, x_N(t) and r. In the window, sliders change the belt velocity and the noise at "
        "once, and keys, which it lists, pause, step and change the speed. With --output it writes "
        "a film and needs no display. The motion is that of event.",
        epilog="Belt velocity, noise and transient are in model units: 0.0183 m/s, 0.0277 N and "
        "0.0765 s.",
    )
    option = parser.add_argument
    shared.add_chain(parser)
    words = "model time that passes unseen and is left out of r (2615: 200 s, as in the paper)"
    option("--transient", type=float, default=2615.0, help=words)
    option("--seed", type=int, default=1, help="fixes the random numbers (1)")
    option("--speed", type=float, default=1.0, help="seconds of the chain in a second shown (1)")
    option("--fps", type=float, default=24.0, help="frames in a second (24)")
    shared.add_output(parser, "write a film, .mp4")
    option("--duration", type=float, help="seconds of the film (20)")


def run(options: argparse.Namespace) -> None:
    """Open the window, or write the film."""
    with needing("beltrepro watch", "watch"):
        from beltrepro.extras import watch

    pace = within("speed", options.speed, ge=0.05, le=50), within("fps", options.fps, ge=1, le=120)
    shared.check_output(options, ".mp4")
    chain = watch.begin(shared.chain_of(options), options.transient, options.seed)
    if options.output:
        duration = 20.0 if options.duration is None else options.duration
        progress = shared.progress_of("film")
        view = watch.write_film(options.output, chain, *pace, duration, progress)
        print(f"{options.output}: {1000 * view.metres_per_pixel:.4g} mm of the belt in a pixel")
    elif options.duration is not None:
        text = f"duration = {options.duration:g}: only a film has one, give --output too"
        raise InputError(text)
    else:
        watch.open_window(chain, *pace)

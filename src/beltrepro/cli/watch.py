"""`beltrepro watch`: one chain in a window, or as a film."""

import argparse
from typing import Any

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
    chain = shared.chain_of(options)
    with needing("beltrepro watch", "watch"):
        from beltrepro.extras import watch

    clock = watch.Clock(options.speed, options.fps)
    if options.output is None:
        if options.duration is not None:
            raise InputError(
                f"duration = {options.duration:g}: only a film has one, give --output too"
            )
        watch.check_display()
        watch.open_window(watch.begin(chain, clock, options.transient, options.seed), clock)
        return
    duration = 20.0 if options.duration is None else options.duration
    shared.check_output(options)
    watch.check_film(options.output, duration, clock)
    progress = shared.progress_of("film")
    player = watch.begin(chain, clock, options.transient, options.seed)
    view = watch.write_film(options.output, player, clock, duration, progress)
    print(f"{options.output}: {1000 * view.metres_per_pixel:.4g} mm of the belt in a pixel")

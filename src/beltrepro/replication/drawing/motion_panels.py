"""Largest exponents and names of motions, as several figures show them."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.stats import motion

EXPONENT = r"$\lambda_1$"
COLOURS = {
    motion.PERIODIC: style.SKY,
    motion.QUASI_PERIODIC: style.GREEN,
    motion.EQUILIBRIUM: style.GREY,
    motion.TRANSIENT: style.ORANGE,
    motion.CHAOTIC: style.VERMILION,
    motion.NOISE_DRIVEN: style.PURPLE,
}
LEAST_RANGE = (-0.0005, 0.002)  # of exponents on an axis
_MARKERS = {motion.CHAOTIC: "o", motion.TRANSIENT: "^"}  # the rest, regular, are squares


def exponents(axes, scan, n_blocks, *, size=2.4):
    """Largest exponent of each run of a number of blocks against u, coloured by its motion."""
    arrays = scan.arrays
    of_size = arrays["n_blocks"] == n_blocks
    states = np.asarray(arrays["state"], dtype=str)
    axes.axhline(0, color="0.5", linewidth=0.6, zorder=0)
    for state, colour in COLOURS.items():
        chosen = of_size & (states == state)
        if chosen.any():
            axes.errorbar(
                arrays["belt_velocity"][chosen],
                arrays["largest_exponent"][chosen],
                arrays["standard_error"][chosen],
                fmt=_MARKERS.get(state, "s"),
                color=colour,
                markersize=size,
                markeredgewidth=0,
                elinewidth=0.5,
                label=state,
            )
    if not of_size.any():
        panels.note(axes, f"no run with N = {n_blocks}")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, LEAST_RANGE[0]), max(high, LEAST_RANGE[1]))

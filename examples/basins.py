"""Basins of attraction: on which motion a chain without noise ends, by where it begins."""

import matplotlib.pyplot as plt
import numpy as np

from beltrepro import ChainParameters, Progress, scan

chain = ChainParameters(n_blocks=3, belt_velocity=30.0)
shifts = np.linspace(-15.0, 15.0, 41)
moves = np.array([[first, 0.0, last] for last in shifts for first in shifts])
starts = chain.rest_positions + moves
results = scan(
    chain,
    initial_positions=starts,  # of each run, all blocks at rest on the belt
    duration=3000.0,
    transient=2500.0,
    progress=Progress("basins"),
)
length = results["mean_length"].reshape(shifts.size, shifts.size)
print(f"<x_N> from {length.min():.1f} to {length.max():.1f}")

figure, axes = plt.subplots()
image = axes.pcolormesh(shifts, shifts, length)
figure.colorbar(image, label=r"$\langle x_N \rangle$ at the end")
axes.set(xlabel="shift of block 1", ylabel="shift of block 3", title="N = 3, u = 30")
figure.savefig("basins.png")

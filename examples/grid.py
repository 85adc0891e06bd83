"""r over a grid of belt velocities and noise strengths, with a progress bar."""

import matplotlib.pyplot as plt
import numpy as np

from beltrepro import Grid, Progress, scan

chains = Grid(
    n_blocks=5,
    belt_velocity=np.arange(1.0, 41.0, 1.5),
    noise=np.arange(0.0, 5.1, 0.5),
    replicates=2,
)
results = scan(
    chains,
    initial_spread=1.0,  # without noise it makes the two replicates differ
    duration=1500.0,
    transient=500.0,
    progress=Progress("r over u and σ"),
)
results.save("grid.h5")  # all that was measured; results.save("grid.csv") has the table
r = results.table().pivot_table(
    "disorder_parameter", "noise", "belt_velocity"
)  # mean of replicates
print(r.round(3))

figure, axes = plt.subplots()
image = axes.pcolormesh(r.columns, r.index, r.to_numpy())
figure.colorbar(image, label="r")
axes.set(xlabel="belt velocity u", ylabel="noise σ", title="N = 5")
figure.savefig("grid.png")

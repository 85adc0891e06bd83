"""Another friction: r of the belt velocity for three ratios of kinetic to static friction."""

import matplotlib.pyplot as plt
import numpy as np

from beltrepro import Grid, scan

chains = Grid(
    n_blocks=5,
    belt_velocity=np.arange(1.0, 50.5, 1.0),
    noise=1.0,
    friction_ratio=[0.3, 0.45, 0.6],  # the paper has 0.45
)
table = scan(chains, duration=2000.0, transient=500.0).table()
table.to_csv("another_friction.csv", index=False)
print(table.groupby("friction_ratio")["disorder_parameter"].describe())

figure, axes = plt.subplots()
for ratio, rows in table.groupby("friction_ratio"):
    axes.plot(rows["belt_velocity"], rows["disorder_parameter"], ".-", label=f"f_s = {ratio:g}")
axes.set(xlabel="belt velocity u", ylabel="r", title="N = 5, σ = 1")
axes.legend()
figure.savefig("another_friction.png")

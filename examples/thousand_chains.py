"""A thousand chains at once: how much does r vary between runs as short as the experiment?"""

import matplotlib.pyplot as plt

from beltrepro import ChainParameters, Progress, scan

CHAINS = 1000
results = scan(
    ChainParameters(n_blocks=5, belt_velocity=20.0, noise=1.0),
    replicate=range(CHAINS),  # each has random numbers of its own
    duration=3000.0,
    transient=1000.0,
    progress=Progress("1000 chains"),
)
r = results["disorder_parameter"]
print(f"r = {r.mean():.4f}, standard deviation between runs {r.std():.4f}")

figure, axes = plt.subplots()
axes.hist(r, bins=40)
axes.set(xlabel="r in 2000 units of time", ylabel="runs", title="N = 5, u = 20, σ = 1")
figure.savefig("thousand_chains.png")

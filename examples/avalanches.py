"""Avalanches: how many blocks slip together, and how much energy friction takes then."""

import matplotlib.pyplot as plt
import numpy as np

from beltrepro import ChainParameters, catalogue

RUNS = 32
chain = ChainParameters(n_blocks=10, belt_velocity=1.0, noise=1.0)
records = catalogue(chain, replicate=range(RUNS), duration=4000.0, transient=1500.0)
avalanches = records["avalanches"]
print(f"{len(avalanches)} avalanches, {len(records['slips'])} slips")

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
left.hist(avalanches["blocks"], bins=np.arange(1, 12) - 0.5, rwidth=0.8)
left.set(xlabel="blocks of an avalanche", ylabel="avalanches", yscale="log")
energy = np.sort(avalanches["dissipated"])
right.loglog(energy, 1 - np.arange(energy.size) / energy.size)
right.set(xlabel="energy E that friction takes", ylabel="share of avalanches above E")
figure.savefig("avalanches.png")

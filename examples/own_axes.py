"""
How do I draw results into my own axes?
=======================================

Methods that draw one panel take ``ax``. Without it they take a path, ``results.plot("r.png")``, or
show the picture; and keywords of matplotlib, ``color="black", linewidth=2``. They return the axes.
"""

import matplotlib.pyplot as plt
import numpy as np

from beltrepro import ChainParameters, Grid, scan, simulate

chain = ChainParameters(n_blocks=3, belt_velocity=10, mass=(1, 3, 1))
run = simulate(chain, duration=3000, transient=500)
chains = Grid(n_blocks=5, belt_velocity=np.arange(1, 41), noise=[0, 1], replicates=8)
results = scan(chains, duration=3000, transient=1000, initial_spread=1, workers=None)
figure, panels = plt.subplots(2, 2, figsize=(9, 6), layout="constrained")
run.plot_phase(ax=panels[0, 0])
run.plot_slips(ax=panels[0, 1])
results.plot(ax=panels[1, 0])
results.plot_section(ax=panels[1, 1], where={"noise": 0})
plt.show()

# %%
# These are the phase portrait of the last block, who slips when, r(u) as mean and band of 10 to
# 90 % of eight runs, a curve for each noise, and a bifurcation diagram without noise, as a
# density. 2 s. There are:
#
# .. list-table::
#
#    * - ``Run``
#      - ``plot_length(window=(900, 1000))``, ``plot_slips``, ``plot_phase(block=1)``;
#        ``plot("run.png")`` has three panels
#    * - ``Results``
#      - ``plot(y="mean_length", x="noise", by="n_blocks")``, ``plot_section(bins=600)``
#    * - ``Catalogue``
#      - ``plot(size="dissipated")``, the density of sizes; ``plot_slips``, in time and space
#    * - what ``spectrum`` and ``section`` return
#      - ``plot``: the power, with the law that was asked for; the points, or ``density=True``
#    * - ``LyapunovSpectrum``, ``PeriodicOrbit``
#      - ``plot``: the exponents; the orbit of a block
#    * - ``OrbitBranch``
#      - ``plot(y="period_time")``, dashed where the orbit does not attract
#    * - ``Basins``
#      - ``plot``, r of the attractors; ``plot_shares``

"""
What if friction depends on the velocity?
=========================================

A viscous force beside the dry one damps the chain.
"""

import matplotlib.pyplot as plt

from beltrepro import Grid, scan

chains = Grid(n_blocks=5, belt_velocity=12, viscosity=[0, 0.05, 0.1, 0.15, 0.2], replicates=8)
results = scan(chains, duration=4000, transient=1500, initial_spread=1, workers=None)
r = results.table().groupby("viscosity")["disorder_parameter"]
r.mean().plot(yerr=r.sem(), ylabel="r")
plt.show()

# %%
# r falls from 0.136 ± 0.002 without it to 0.080 ± 0.001 at η = 0.1. At 0.2 half of the runs slip
# for ever. ``weakening_velocity=[100, 200, 500]`` makes friction fall with velocity instead, and
# r grows; below 100 the blocks of this chain run into each other, which :ref:`ends a run
# <sphx_glr_cookbook_growing_scan.py>`. 1 s.

"""
How does r depend on velocity and noise?
========================================

A ``Grid`` has every combination of some values, and ``progress`` shows how far it is.
"""

import matplotlib.pyplot as plt
import numpy as np

from beltrepro import Grid, Progress, scan

u, noise = np.arange(1, 41, 1.5), np.arange(0, 5.1, 0.5)
chains = Grid(n_blocks=5, belt_velocity=u, noise=noise, replicates=2)
settings = {"initial_spread": 1, "workers": None, "progress": Progress("r over u and σ")}
results = scan(chains, duration=1500, transient=500, **settings)
r = results.table().pivot_table("disorder_parameter", "noise", "belt_velocity")
plt.pcolormesh(r.columns, r.index, r)
plt.colorbar(label="r, mean of two runs")
plt.xlabel("u")
plt.ylabel("σ")
plt.show()

# %%
# Without ``initial_spread`` the two runs without noise would be one. ``results.save("r.h5")``
# writes all that was measured, and ``results.save("r.csv")`` the table. 1 s.

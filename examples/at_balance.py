"""
How do I start 100 blocks without loading them?
===============================================

From undeformed springs the belt takes 28,000 time units to stretch this chain. ``at_balance`` draws
a start in which all blocks stick and the springs pull each with a random force below its threshold,
on average with kinetic friction.
"""

import matplotlib.pyplot as plt

from beltrepro import ChainParameters, ChainState, scan, simulate

chain = ChainParameters(n_blocks=100, belt_velocity=1)
starts = [ChainState.at_balance(chain, replicate=number) for number in range(8)]
runs = scan([chain] * 8, duration=5000, transient=1000, initial_state=starts, workers=None)
print(runs.table()[["replicate", "disorder_parameter", "mean_length"]])
figure, axes = plt.subplots()
for run in simulate([chain] * 2, duration=1000, sample_interval=1, initial_state=starts[:2]):
    axes.plot(run.time, run.positions[:, -1])
axes.set(xlabel="t", ylabel="$x_N$")
plt.show()

# %%
# The first slip is at t = 0.6, and x_N is 33,092 ± 20 from the first thousand units on; r =
# 0.0069 ± 0.0004. 6 s.
#
# So a transient of a thousand units is enough. The warning about loading counts from undeformed
# springs all the same: in a run shorter than 28,000 it may take a slow swing for loading. The
# transient that it then names is that of this start.

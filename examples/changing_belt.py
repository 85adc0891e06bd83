"""
What if the belt changes its velocity?
======================================

The belt stops at t = 400, to a velocity that is as good as zero, and goes on at 600.
"""

import matplotlib.pyplot as plt

from beltrepro import ChainParameters, simulate

chain = ChainParameters(n_blocks=5, belt_velocity=10)
run = simulate(chain, duration=1000, transient=100, belt=[(400, 1e-6), (600, 10)])
plt.plot(run.time, run.positions[:, -1])
plt.xlabel("t")
plt.ylabel("$x_N$")
plt.show()

# %%
# All blocks come to rest within two units of time and hold the tension of their springs: the last
# one stays at 694, and the first slip comes 2.5 units after the belt moves again. Steps are
# ``belt=[(0, 2), (1000, 5), (2000, 10)]``, a ramp is ``np.column_stack([times, velocities])``.
#
# It is one run, with one file and one picture, and has the bits of runs from change to change,
# each from the ``final_state`` of the one before. Its r and its ``spectrum`` mix the motions at
# all velocities. For one velocity take the samples at it, ``late = run.positions[run.time > 650,
# -1]``: r is ``late.std() / late.mean()``, and the spectrum ``spectrum(late,
# sample_interval=run.sample_interval)``.

"""
How long is the motion of 1000 starts irregular?
================================================

Each start is followed until its motion repeats itself.
"""

import matplotlib.pyplot as plt

from beltrepro import ChainParameters, time_to_orbit

chain = ChainParameters(n_blocks=5, belt_velocity=20)
runs = time_to_orbit(chain, duration=20_000, replicate=range(1000), initial_spread=5, workers=None)
plt.ecdf(runs["lifetime"], complementary=True)
plt.semilogy()
plt.xlabel("t")
plt.ylabel("share of starts that are irregular for longer")
plt.show()

# %%
# Lifetimes are about exponential: the share of starts that are irregular for longer than t is
# straight down to a tenth on the logarithmic axis. Half of these starts settle by 1,660, and all by
# 12,000. About a minute.

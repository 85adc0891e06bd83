"""
How do I cut a run, and go on from anywhere?
============================================

A ``ChainState`` is all that a chain needs to go on.
"""

from dataclasses import replace

import matplotlib.pyplot as plt

from beltrepro import ChainParameters, Run, simulate

chain = ChainParameters(n_blocks=5, belt_velocity=7.5, noise=1)
first = simulate(chain, duration=500)
first.save("first.h5")
state = Run.load("first.h5").final_state  # in another process, say
later = simulate(chain, duration=500, initial_state=state)  # from 500 to 1000
faster = simulate(replace(chain, belt_velocity=12), duration=500, initial_state=state)
push = [0, 0, 0, 0, 1]
pushed = state.moved(velocities=state.velocities + push)
others = simulate([chain] * 8, duration=500, initial_state=pushed, replicate=range(8))
print(later.time[0], faster.disorder_parameter, len(others))
figure, axes = plt.subplots()
for run in (first, later, faster):
    axes.plot(run.time, run.positions[:, -1], label=f"u = {run.parameters.belt_velocity:g}")
axes.set(xlabel="t", ylabel="$x_N$")
axes.legend()
plt.show()

# %%
# Pieces can be joined: no sample is there twice, and :doc:`cuts </integrators>` at multiples of
# 250 leave no trace. The chain may have another belt velocity, noise or law than its state, but
# not another number of blocks. Stuck blocks stay on the belt, slipping ones keep their velocity
# in the laboratory, and a threshold keeps its deviation from the mean in units of σ. The random
# numbers go on; with ``replicate`` they are others. ``ChainState.at_rest(chain, positions)`` and
# ``ChainState.in_motion(chain, positions, velocities)`` begin anywhere.

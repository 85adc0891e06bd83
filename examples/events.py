"""
How do I get the events into pandas?
====================================

Each slip and each stick of a block is an event of the run.
"""

import matplotlib.pyplot as plt
import pandas as pd

from beltrepro import ChainParameters, simulate

chain = ChainParameters(n_blocks=5, belt_velocity=10, noise=1)
run = simulate(chain, duration=1000, transient=300)
events = pd.DataFrame(run.events)
counts = events.groupby(["block", "kind"]).size().unstack()
print(counts)
counts.plot.bar(ylabel="events")
plt.show()

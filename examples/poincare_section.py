"""
What does a section of block 3 look like?
=========================================

The points are place and velocity of the last block, relative to the belt, whenever block 3 comes
back through the place at which springs and friction balance.
"""

import matplotlib.pyplot as plt

from beltrepro import ChainParameters, catalogue, section

chain = ChainParameters(n_blocks=5, belt_velocity=10, noise=1)
records = catalogue(chain, duration=20_000, transient=1_000, section_block=3)
figure, axes = plt.subplots()
section(records).plot(ax=axes)
plt.show()

# %%
# ``section_position`` puts the section elsewhere. There are 963 points in 0.1 s, and at 601 of
# them, which are drawn, the last block slips; ``records["section"]`` has all, with the other
# blocks.

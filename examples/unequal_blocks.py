"""
What if no two blocks are alike?
================================

Twenty chains for each of four widths of the distribution of static friction, 0 to 28 % of its mean.
"""

import matplotlib.pyplot as plt
import numpy as np

from beltrepro import ChainParameters, scan

random, widths = np.random.default_rng(1), (0, 5, 10, 20)
chains = [
    ChainParameters(n_blocks=5, belt_velocity=10, static_friction=random.normal(71.4, width, 5))
    for width in widths
    for _ in range(20)
]
settings = {"replicate": range(80), "initial_spread": 1, "workers": None}
results = scan(chains, duration=3000, transient=500, **settings)
r = results["disorder_parameter"].reshape(4, 20)
plt.errorbar(widths, r.mean(axis=1), r.std(axis=1) / np.sqrt(20), fmt="o")
plt.ylim(bottom=0)
plt.xlabel("width of the distribution of static friction")
plt.ylabel("r")
plt.show()

# %%
# r hardly depends on it: it is 0.125 ± 0.002, 0.129 ± 0.002, 0.127 ± 0.002 and 0.123 ± 0.006.
# Masses, friction ratios, lengths and stiffness of springs take N numbers in the same way
# (:doc:`other laws </laws>`). 5 s.

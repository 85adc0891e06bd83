"""
What is the spectrum of x_N?
============================

``spectrum`` takes a run, several in a list, or any array. Its exponent has an interval.
"""

import matplotlib.pyplot as plt

from beltrepro import ChainParameters, simulate, spectrum

chain = ChainParameters(n_blocks=5, belt_velocity=1, noise=1)
run = simulate(chain, duration=21_000, transient=1_000, sample_start=1_000)
power = spectrum(run)
law = power.law(0.005, 0.3)
print(law.exponent)
figure, axes = plt.subplots()
power.plot(ax=axes, law=law)
plt.show()

# %%
# The spectrum is flat below a frequency of 0.005. It falls by about a power law up to 0.3, and
# more steeply where single slips are. The exponent there is -2.54 (-2.60 to -2.46), with the
# interval that ten stretches of the run tell; of several runs it is shorter.
# ``spectrum(run.positions[:, 0], sample_interval=0.1)`` is the spectrum of the first block. 1 s.

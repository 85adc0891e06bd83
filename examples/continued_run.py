"""A run continued from a state: the belt speeds up in steps, then slows down. Does r come back?"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from beltrepro import ChainParameters, simulate

velocities = np.arange(2.0, 41.0, 2.0)
figure, axes = plt.subplots()
chain, state = ChainParameters(n_blocks=5, belt_velocity=2.0), None
for label, steps in (("faster", velocities), ("slower", velocities[::-1])):
    r = []
    for velocity in steps:
        run = simulate(
            replace(chain, belt_velocity=velocity),
            initial_state=state,  # where the run before has ended; None is at rest
            duration=3000.0,
            transient=1000.0,
            sample_interval=None,
        )
        state = run.final_state
        r.append(run.disorder_parameter)
    axes.plot(steps, r, "o-" if label == "faster" else "s--", label=label)
print(f"t = {state.time:g} at the end")
axes.set(xlabel="belt velocity u", ylabel="r", title="N = 5, without noise")
axes.legend()
figure.savefig("continued_run.png")

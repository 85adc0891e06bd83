"""One chain, and its picture: x_N(t), r as it settles, and the slips of each block."""

from beltrepro import ChainParameters, simulate

chain = ChainParameters(n_blocks=7, belt_velocity=12.0, noise=1.0)
run = simulate(chain, duration=2000.0, transient=500.0)
print(run)
run.plot("one_run.png")  # without a name it is shown

"""
How does a long scan survive, and grow?
=======================================

``store`` keeps what is finished in a file: after Ctrl-C the same call goes on, and eight more
replicates cost only themselves.
"""

from dataclasses import replace

import matplotlib.pyplot as plt

from beltrepro import Grid, scan

chains = Grid(n_blocks=5, belt_velocity=[10, 50, 100, 150], noise=1, replicates=8)
settings = {"transient": 500, "store": "r.h5", "on_error": "nan", "workers": None}
results = scan(chains, duration=3000, **settings)
more = scan(replace(chains, replicates=range(16)), duration=3000, **settings)
r = more.table().groupby("belt_velocity")["disorder_parameter"].agg(["count", "mean", "sem"])
print(r)
r["mean"].plot(yerr=r["sem"], ylabel="r")
plt.show()

# %%
# A file that was made with another duration, method or seed is refused; one of a scan that
# ``results.save`` wrote goes on as well. ``sweep``, ``catalogue``, ``time_to_continuous_slip``,
# ``classify`` and ``lyapunov_spectrum`` have it too, and ``beltrepro scan`` has ``--store r.h5``
# and ``--on-error nan``.
#
# At u = 150 blocks run into each other, which would end the scan; with ``on_error="nan"`` their
# rows are NaN, ``more["error"]`` says why, and a warning counts them. ``one.joined(other)`` makes
# one table of two, each run once, and ``scan(chains, duration=1000,
# initial_state=results.final_states)`` goes on where ``results`` end.

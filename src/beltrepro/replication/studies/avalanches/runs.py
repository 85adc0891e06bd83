"""Energies of avalanches at u = 1, from 5 to 60 blocks, without noise, as counts in narrow bins.

python -m beltrepro.replication.studies.avalanches.runs
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from beltrepro import ChainParameters, catalogue
from beltrepro.model.energy import balance_tension, spring_extension
from beltrepro.replication.studies import published

SIZES = (5, 10, 20, 40, 60)
RUNS = 8
DURATION, TRANSIENT = 40_000.0, 4_000.0
BINS_PER_DECADE = 20


def energies(n_blocks: int) -> Iterator[dict]:
    """A row for each run and bin of the energy that an avalanche dissipates."""
    chain = ChainParameters(n_blocks, 1.0)
    # undeformed springs would be stretched by the belt for ten thousand time units
    lengths = chain.rest_length + spring_extension(balance_tension(chain), chain)
    for run in range(1, RUNS + 1):
        avalanches = catalogue(
            chain,
            method="event",
            replicate=run,
            initial_positions=np.cumsum(lengths),
            initial_spread=1.0,
            duration=DURATION,
            transient=TRANSIENT,
        )["avalanches"]
        avalanches = avalanches[avalanches["dissipated"] > 0]
        place = np.floor(np.log10(avalanches["dissipated"]) * BINS_PER_DECADE).astype(int)
        for bin_ in np.unique(place):
            blocks = avalanches["blocks"][place == bin_]
            yield {
                "run": run,
                "energy": 10 ** ((bin_ + 0.5) / BINS_PER_DECADE),
                "one_block": int(np.sum(blocks == 1)),
                "several_blocks": int(np.sum((blocks > 1) & (blocks < n_blocks))),
                "all_blocks": int(np.sum(blocks == n_blocks)),
            }


if __name__ == "__main__":
    published.extend(
        Path(__file__).with_name("energies.csv"), ({"n_blocks": n} for n in SIZES), energies
    )

"""The runs behind the published tables of this study; minutes to an hour, so not in a preset.

    python -m beltrepro.replication.studies.disturbance.runs orbits_lost

A point that the file has already is not made again, so a run that was stopped goes on. The files
beside this module are what `measure` reads.
"""

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from beltrepro import ChainParameters, ChainState, Results, close_orbit, time_to_orbit
from beltrepro.base.errors import InputError
from beltrepro.chaos import orbit_loss
from beltrepro.chaos.periodic_orbits import PeriodicOrbit
from beltrepro.replication.studies import published
from beltrepro.stats.motion import PERIODIC

SPREAD = 10.0  # of the starts, model length
WITHIN = 10_000.0  # model time: an orbit is lost if half of the runs leave it before
LOST = {  # N: u
    5: (2, 3, 4, 5, 6, 7, 8, 10, 11, 13, 14, 15, 16, 17.5, 20, 25, 30),
    4: (3, 10, 16, 30),
    6: (32, 38, 42),
}
STARTS = {4: 4, 5: 8, 6: 4}
LIFETIMES = dict.fromkeys(range(4, 13), (10, 20, 30, 40))
LIFETIMES[5] = (7, 10, 15, 16, 20, 25, 30, 40)
RUNS = {(5, u): (128, 80_000.0) for u in (7, 15, 16, 20, 25, 30)}  # to tell the law of lifetimes
RUNS |= {(6, u): (32, 100_000.0) for u in (30, 40)} | {(7, u): (16, 300_000.0) for u in (30, 40)}
RUNS |= {(8, 30): (16, 300_000.0), (6, 10): (8, 1_500_000.0)}
FEW = 8, 50_000.0  # runs of all others, and model time
MEASURED = ("lifetime", "settled", "period_events", "disorder_parameter")
MEASURED += ("irregular_exponent", "irregular_error", "irregular_time")
SCHEME = 100_000.0  # and by the paper's scheme, with its time step of 0.001
SETTLING = {5: 40_000.0, 4: 20_000.0, 6: 20_000.0}  # model time until starts are given up


# --- disturbances that lose orbits ----------------------------------------------------------------


def orbits_lost(chain: ChainParameters) -> Iterator[dict]:
    """A row for each orbit that starts of a chain end on."""
    by_scheme = _settled(chain, SCHEME, method="verlet")["period_events"]
    for orbit, starts in _orbits(chain):
        track = orbit_loss.Track.of(orbit)
        row = {
            "starts": STARTS[chain.n_blocks],
            "ended": starts,
            "slips": orbit.period_events,
            "period_time": orbit.period_time,
            "multiplier": abs(orbit.largest_multiplier),
            "disorder_parameter": orbit.disorder_parameter,
            "scatter": track.scatter(duration=WITHIN),
        }
        row["noise_as_kick"] = orbit_loss.noise_as_kick(track)
        for name in orbit_loss.DISTURBANCES:
            runs = 4 if name == orbit_loss.STEP else 8
            size = orbit_loss.loss(track, name, duration=WITHIN, replicates=runs)
            row |= {name: size.size, f"{name}_low": size.low, f"{name}_high": size.high}
            row |= {f"{name}_runs": size.runs}
        kick = row["kick_low"] or orbit_loss.SMALLEST[orbit_loss.KICK]
        row["scheme"] = int(np.sum(by_scheme == orbit.period_events))
        periods = int(np.clip(1000 / orbit.period_time, 3, 20))
        yield row | {"margin": orbit_loss.margin(track, begin=kick, periods=periods, slips=32)}


def _orbits(chain: ChainParameters) -> Iterator[tuple[PeriodicOrbit, int]]:
    """The orbits that starts of a chain end on, and how many do."""
    runs = _settled(chain, SETTLING[chain.n_blocks])
    periodic = runs["state"].astype(str) == PERIODIC
    for slips in np.unique(runs["period_events"][periodic]):
        same = np.flatnonzero(periodic & (runs["period_events"] == slips))
        displaced, moving = np.split(runs["return_state"][same[0]], 2)
        state = ChainState.in_motion(
            chain, chain.rest_positions + displaced, chain.belt_velocity + moving
        )
        try:
            yield close_orbit(state, float(runs["period_time"][same[0]])), same.size
        except InputError as error:  # the state had not come near enough
            print(error)


def _settled(chain: ChainParameters, duration: float, method: str = "event") -> Results:
    """What the starts of a chain end on."""
    starts = range(1, STARTS[chain.n_blocks] + 1)
    return time_to_orbit(
        chain, method=method, replicate=starts, initial_spread=SPREAD, duration=duration
    )


# --- lifetimes ------------------------------------------------------------------------------------


def irregular_lifetimes(chain: ChainParameters) -> Iterator[dict]:
    """A row for each run, until its motion settles or it is given up."""
    number, duration = RUNS.get((chain.n_blocks, chain.belt_velocity), FEW)
    # spread wider, some of so many longer chains would begin with blocks in the wrong order
    spread = SPREAD if number <= FEW[0] or chain.n_blocks == 5 else 1.0
    runs = time_to_orbit(
        chain, replicate=range(1, number + 1), initial_spread=spread, duration=duration
    )
    for run in range(number):
        yield {
            "initial_spread": spread,
            "replicate": run + 1,
            "duration": duration,
            **{name: runs[name][run] for name in MEASURED},
        }


TABLES: dict[str, tuple[Callable, dict]] = {
    "orbits_lost": (orbits_lost, LOST),
    "irregular_lifetimes": (irregular_lifetimes, LIFETIMES),
}


def make(name: str, folder: Path, points: dict | None = None) -> pd.DataFrame:
    """Make a table point by point; points : u of each N, those of the published table if None."""
    rows_of, all_points = TABLES[name]
    grid = [
        {"n_blocks": n_blocks, "belt_velocity": velocity}
        for n_blocks, velocities in (points or all_points).items()
        for velocity in velocities
    ]

    def rows_at(n_blocks: int, belt_velocity: float) -> Iterator[dict]:
        return rows_of(ChainParameters(n_blocks, float(belt_velocity)))

    return published.extend(folder / f"{name}.csv", grid, rows_at)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", choices=TABLES)
    parser.add_argument("--folder", type=Path, default=Path(__file__).parent)
    options = parser.parse_args()
    make(options.table, options.folder)

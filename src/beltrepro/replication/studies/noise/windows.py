"""Periodic windows, with and without noise, by how the velocities at the section spread."""

import numpy as np

from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.stats import sections
from beltrepro.stats.errors import NotEnoughDataError, require
from beltrepro.stats.estimates import Estimate, bootstrap, share

RANGE = (3.0, 15.0)
LEAST_RUNS = 6


def share_in_windows(row: Cut, usual: Cut) -> Estimate:
    """Share of the runs at 3 <= u <= 15 that fill less than half of the bins of v_N that is usual.

    row : the runs; usual : those whose median run says what is usual, and whose range is binned.
    """
    velocities = usual.velocities[usual.between(*RANGE)]
    require(bool(np.isfinite(velocities).any()), "no crossings of the section")
    span = float(np.nanmin(velocities)), float(np.nanmax(velocities))
    least = 0.5 * np.median(_filled(velocities, span))
    own = _filled(row.velocities[row.between(*RANGE)], span)
    return share(int(np.count_nonzero(own < least)), own.size)


def spread_ratio(row: Cut) -> Estimate:
    """Bins of v_N that the median run fills above u = 25, relative to 3 <= u <= 15."""
    span = float(np.nanmin(row.velocities)), float(np.nanmax(row.velocities))
    high = _filled(row.velocities[row.belt_velocity > 25], span)
    low = _filled(row.velocities[row.between(*RANGE)], span)
    return bootstrap(lambda high, low: np.median(high) / np.median(low), [high, low])


def _filled(velocities: np.ndarray, span: tuple[float, float]) -> np.ndarray:
    """Share of the bins that each run fills; runs that rarely reach the section are left out."""
    found = []
    for own in velocities:
        try:
            found.append(sections.occupied_share(own, range=span))
        except NotEnoughDataError:
            continue
    require(
        len(found) >= LEAST_RUNS, f"{len(found)} runs cross the section, {LEAST_RUNS} are needed"
    )
    return np.array(found)

"""What explains the fall of r: where orbits of small r begin, and when sweeps find them."""

import numpy as np

from beltrepro.base.errors import require
from beltrepro.replication.studies.fall import measure
from beltrepro.replication.studies.fall.measure import SMALL, is_small
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats.estimates import Estimate, absent, bootstrap, difference, share_of, sure

FIRST = 15.0  # u from which on runs below the begin count: there the paper sees r begin to fall
ACCURACY = 1e-3  # of u at the end of a branch (orbit_branch)
MET_RANGES = ((14, 17), (17.5, 19.5), (19.5, 21.5))  # of u: below, at and above the fall
CHAOS_LASTS = 10.7495, 10.7505  # range of u in which chaos lasts
_ROUNDING = 1e-6  # of a grid of u
SWEEPS = ("sweeps_fast", "sweeps", "sweeps_slow")  # the longer, the longer each u is held
_FEW = 0.1  # share of runs that an orbit must take to be one that irregular motion finds


@claim("orbits-of-small-r")
def orbits_of_small_r(evidence):
    """Begin of the first orbits of small r that starts reach, and what starts do around it."""
    arrays = evidence.dataset("basins").arrays
    velocity, small = arrays["belt_velocity"], _small(arrays)
    begin = _first_begin(arrays)
    above = velocity[velocity > begin].min()
    below = small[(velocity >= FIRST) & (velocity < begin)]
    require(below.size, f"no start at u = {FIRST:g} or more and below {begin:.4g}")
    return Measurement(
        {
            "first begin": Estimate(begin, begin - ACCURACY, begin + ACCURACY),
            "small r, below it": share_of(below.ravel()),
            "small r, above it": share_of(small[velocity == above].ravel()),
        }
    )


@claim("orbits-met")
def orbits_met(evidence):
    """Shares at small r below and above the fall, and on what orbits runs end."""
    arrays = evidence.dataset("fall_orbits").arrays
    velocity, where, small = arrays["belt_velocity"], measure.ends(arrays), _small(arrays)
    short = where["33"] | where[f"other up to {measure.LONG}"]
    shares, further = {}, {}
    for low, high in MET_RANGES:
        here, words = (velocity >= low) & (velocity < high), f"{low:g} to {high:g}"
        require(here.any(), f"no run at u = {words}")
        for name, runs in (("small r", small), ("short orbits of large r", short)):
            shares[f"{name}, {words}"] = measure.share_over(velocity[here], runs[here])
        for end, runs in where.items():
            further[f"{end}, {words}"] = measure.share_over(velocity[here], runs[here])
    return Measurement(shares, further)


@claim("chaos-ends")
def chaos_ends(evidence):
    """Shares of runs that settle, on a fine grid of u, and near a velocity at which chaos lasts."""
    shares, further = {}, {}
    for name, low, high in (
        ("chaos_ends", 8.5, 17.1),
        ("chaos_ends_near", 10.74, 10.745),
        ("chaos_ends_near", *CHAOS_LASTS),
    ):
        arrays, words = evidence.dataset(name).arrays, f"{low:g} to {high:g}"
        velocity = arrays["belt_velocity"]
        here = (velocity >= low - _ROUNDING) & (velocity <= high + _ROUNDING)
        require(here.any(), f"no run at u = {words}")
        settled = arrays["settled"][here].astype(bool)
        shares[f"settled, {words}"] = measure.share_over(velocity[here], settled)
        further[f"median lifetime, {words}"] = bootstrap(np.median, [arrays["lifetime"][here]])
        slips = arrays["period_events"][here][settled]
        further[f"median slips, {words}"] = further[f"most slips, {words}"] = absent()
        if slips.size:
            further[f"median slips, {words}"] = bootstrap(np.median, [slips])
            further[f"most slips, {words}"] = sure(slips.max())
    return Measurement(shares, further)


@claim("fall-by-hold")
def fall_by_hold(evidence):
    """First u at small r of upward sweeps, by the time for which each u is held."""
    begin = _first_begin(evidence.dataset("basins").arrays)
    falls = [_falls(evidence.dataset(name).arrays) for name in SWEEPS]
    half = [bootstrap(np.median, [fall]) for fall in falls]
    return Measurement(
        {
            "shortest": half[0],
            "longest": half[-1],
            "shorter less longer": difference(half[0], half[-1]),
            "below the first begin": share_of(np.concatenate(falls) < begin),
        }
    )


@claim("fall-at-birth")
def fall_at_birth(evidence):
    """u at which runs begin to end at small r less the birth of an orbit, over friction ratios."""
    data = {name: evidence.dataset(name) for name in evidence.claim.needs}
    births, onsets = measure.birth_lines(data), measure.fall_onsets(data)
    names = ["friction_ratio", "birth"]
    line = births[~births["linear"] & (births["slips"] == measure.FIRST)]
    require(len(line) > 1, f"orbit of {measure.FIRST} slips at {len(line)} friction ratios, not 2")
    onsets = onsets[onsets["onset"].notna()]
    inside = onsets[onsets["friction_ratio"].between(*line["friction_ratio"].iloc[[0, -1]])]
    require(len(inside) > 1, f"onsets at {len(inside)} friction ratios, not 2")
    birth = np.interp(inside["friction_ratio"], *line[names].to_numpy().T)
    away = inside["onset"].to_numpy() - birth
    return Measurement(
        {
            "friction ratios within 1": share_of(np.abs(away) <= 1),
            "onset less birth": bootstrap(np.median, [away]),
        },
        {f"birth at {ratio:g}": sure(u) for ratio, u in line[names].itertuples(index=False)},
    )


def _small(arrays) -> np.ndarray:
    return is_small(arrays["disorder_parameter"], arrays["state"].astype(str))


def _first_begin(arrays) -> float:
    """u at which the first of the branches begins that take the runs where half of them fall."""
    velocity, small = arrays["belt_velocity"], _small(arrays)
    most = [u for u in np.unique(velocity) if small[velocity == u].mean() >= 1 / 2]
    require(most, "at no u do half of the starts end at small r")
    there = velocity == most[0]
    reached, counts = np.unique(arrays["attractor"][there][small[there]], return_counts=True)
    taking = reached[counts >= _FEW * small[there].size]
    orbits = arrays["branches"]
    begins = orbits["belt_velocity"][np.isin(orbits["attractor"], taking)]
    require(begins.size, f"no orbit of small r was followed from u = {most[0]:g}")
    return float(begins.min())


def _falls(arrays) -> np.ndarray:
    """First u at small r of each upward sweep without noise; the last u if it never is."""
    quiet = arrays["noise"] == 0
    velocity, run = arrays["belt_velocity"][quiet], arrays["replicate"][quiet]
    small = arrays["disorder_parameter"][quiet, 0] < SMALL
    require(velocity.size, "no sweep without noise")
    last = velocity.max()
    return np.array([velocity[small & (run == one)].min(initial=last) for one in np.unique(run)])

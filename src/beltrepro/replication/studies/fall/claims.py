"""What explains the fall of r: where orbits of small r begin, and when sweeps find them."""

import numpy as np
import pandas as pd

from beltrepro.base.errors import require
from beltrepro.replication.studies.fall import measure
from beltrepro.replication.studies.fall.measure import SMALL
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.replication.verdicts.motions import N_BLOCKS, PERMANENT
from beltrepro.stats.estimates import absent, bootstrap, difference, share_of, sure

MET_RANGES = ((14, 17), (17, 17.5), measure.ABOVE, (19.5, 21.5), (21.5, 24))  # of u
BIRTH_RATIOS = 0.4, 0.45, 0.5  # friction ratios whose births the text tells
NEAR = 10.74, 10.76  # range of u in which chaos lasts at some velocities
_ROUNDING = 1e-6  # of a grid of u
SIZES = 4, 5, 6, 7, 10  # numbers of blocks whose exponents are compared
SWEEPS = ("sweeps_fast", "sweeps", "sweeps_slow")  # the longer, the longer each u is held


@claim("orbits-met")
def orbits_met(evidence):
    """Shares at small r below and above the fall, and on what orbits runs end."""
    arrays = evidence.dataset("fall_orbits").arrays
    velocity, where = arrays["belt_velocity"], measure.ends(arrays)
    small = measure.small_ends(arrays)
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


@claim("disturbance-clears")
def disturbance_clears(evidence):
    """Share at small r just above the fall: exact, with a hundredth of noise, and by the scheme."""
    fine, runs, scheme = evidence.claim.needs
    arrays = evidence.dataset(fine).arrays
    u = arrays["belt_velocity"]
    above = (u >= measure.ABOVE[0]) & (u < measure.ABOVE[1])
    require(above.any(), "no exact run just above the fall")
    exact = measure.share_over(u[above], measure.small_ends(arrays)[above])
    shares = measure.disturbed_shares({name: evidence.dataset(name) for name in (runs, scheme)})
    for key in (places := ((runs, 0.01), (scheme, 0.0))):
        require(key in shares, f"no run of {key[0]} just above the fall with noise {key[1]:g}")
    noisy, stepped = (shares[key] for key in places)
    same = shares.get((runs, 0.0), absent())  # exact, at the velocities of these two
    return Measurement(
        {
            "small r, exact": exact,
            "small r, sigma = 0.01 minus exact": difference(noisy, exact),
            "small r, scheme minus exact": difference(stepped, exact),
            "small r, scheme minus sigma = 0.01": difference(stepped, noisy),
        },
        {"small r, sigma = 0.01": noisy, "small r, scheme": stepped, "small r, sigma = 0": same}
        | {"small r, sigma = 0.01 minus sigma = 0": difference(noisy, same)},
    )


@claim("chaos-ends")
def chaos_ends(evidence):
    """Shares of runs that settle, on a fine grid of u, and near a velocity at which chaos lasts."""
    shares, further = {}, {}
    for name, low, high in (("chaos_ends", 8.5, 17.1), ("chaos_ends_near", *NEAR)):
        arrays, words = evidence.dataset(name).arrays, f"{low:g} to {high:g}"
        velocity = arrays["belt_velocity"]
        here = (velocity >= low - _ROUNDING) & (velocity <= high + _ROUNDING)
        require(here.any(), f"no run at u = {words}")
        settled = arrays["settled"][here].astype(bool)
        shares[f"settled, {words}"] = measure.share_over(velocity[here], settled)
        lasting = [not settled[velocity[here] == u].all() for u in np.unique(velocity[here])]
        places = f"velocities at which a run lasts, {words}"
        (shares if name.endswith("near") else further)[places] = share_of(np.array(lasting))
        further[f"median lifetime, {words}"] = bootstrap(np.median, [arrays["lifetime"][here]])
        slips = arrays["period_events"][here][settled]
        further[f"median slips, {words}"] = further[f"most slips, {words}"] = absent()
        if slips.size:
            further[f"median slips, {words}"] = bootstrap(np.median, [slips])
            further[f"most slips, {words}"] = sure(slips.max())
    arrays = evidence.dataset("survival_long").arrays
    lasting = (arrays["lifetime"] >= PERMANENT) | ~arrays["settled"].astype(bool)
    for words, low, high in (("u below 2", 0, 2), ("u from 2 to 8.5", 2, 8.5)):
        velocity = arrays["belt_velocity"]
        here = (arrays["n_blocks"] == N_BLOCKS) & (velocity >= low) & (velocity < high)
        number = share_of(lasting[here]) if here.any() else absent()
        further[f"irregular for 1e6, {words}"] = number
    return Measurement(shares, further)


@claim("contraction")
def contraction(evidence):
    """Largest nontrivial exponents by number of blocks, of all runs and of those irregular.

    Beside them the mean lifetime of irregular motion at one velocity.
    """
    arrays = evidence.dataset("motion_map").arrays
    irregular, growth = measure.ends_irregular(arrays), arrays["nontrivial_exponent"]
    numbers, further, followed = {}, {}, evidence.dataset("survival").arrays
    for size in SIZES:
        here = arrays["n_blocks"] == size
        for name, runs in (("exponent", here), ("irregular", here & irregular)):
            number = bootstrap(np.median, [growth[runs]]) if runs.any() else absent()
            numbers[f"{name}, N = {size}"] = number
        most = sure(arrays["erased"][here].max()) if here.any() else absent()
        numbers[f"most erased, N = {size}"] = most
        further[f"lifetime, N = {size}"] = measure.mean_lifetime(followed, size)
    return Measurement(numbers, further)


@claim("fall-by-hold")
def fall_by_hold(evidence):
    """First u at small r of upward sweeps, by the time for which each u is held, and the birth."""
    lines = measure.birth_lines({"small_orbits": evidence.dataset("small_orbits")})
    births = measure.births_at_paper(lines, measure.FIRST)
    require(births.size, f"orbit of {measure.FIRST} slips not followed at the paper's constants")
    falls = [_falls(evidence.dataset(name).arrays) for name in SWEEPS]
    half = [bootstrap(np.median, [fall]) for fall in falls]
    return Measurement(
        {
            "shorter less longer": difference(half[0], half[-1]),
            "longest less birth": difference(half[-1], sure(births[0])),
            "below the birth": share_of(np.concatenate(falls) < births[0]),
        },
        {"shortest": half[0], "longest": half[-1], "birth": sure(births[0])},
    )


@claim("fall-at-birth")
def fall_at_birth(evidence):
    """u at which runs begin to end at small r less the birth of an orbit, over friction ratios."""
    data = {name: evidence.dataset(name) for name in evidence.claim.needs}
    births, onsets = measure.birth_lines(data), measure.fall_onsets(data)
    line, later = (
        births[~births["linear"] & (births["slips"] == slips)]
        .groupby("friction_ratio")["birth"]
        .min()
        for slips in (measure.FIRST, measure.SECOND)
    )
    require(len(line) > 1, f"orbit of {measure.FIRST} slips at {len(line)} friction ratios, not 2")
    onsets = onsets.set_index("friction_ratio")["onset"].dropna()
    first, second = _less_birth(onsets, line), _less_birth(onsets, later)
    require(len(first) > 1, f"onsets at {len(first)} friction ratios, not 2")
    linear = births[births["linear"] & (births["slips"] == measure.FIRST)]
    at_paper = np.isclose(linear["friction_ratio"], measure.PAPER_RATIO)
    born = measure.births_at_paper(births, measure.SECOND)
    further = {f"birth at {ratio:g}": absent() for ratio in BIRTH_RATIOS}
    further |= {f"birth at {ratio:g}": sure(u) for ratio, u in line.items()} | {
        "birth of 11": next(map(sure, born), absent()),
        "linear birth": sure(linear["scaled"].median()),
        "linear birth at 0.45": sure(linear["birth"][at_paper].median()),
    }
    both = first.index.intersection(second.index)  # ratios at which both births are known
    for slips, away in ((measure.FIRST, first), (measure.SECOND, second)):
        near = share_of(np.abs(away[both]) <= 1) if len(both) else absent()
        further[f"friction ratios within 1 of {slips}"] = near
    return Measurement(
        {
            "friction ratios within 1": share_of(np.abs(first.to_numpy()) <= 1),
            "onset less birth": bootstrap(np.median, [first.to_numpy()]),
        },
        further,
    )


def _less_birth(onsets: pd.Series, birth: pd.Series) -> pd.Series:
    """Onsets less the birth of an orbit, by friction ratio, where both are known."""
    birth = birth.reindex(birth.index.union(onsets.index))
    return (onsets - birth.interpolate("index", limit_area="inside")).dropna()


def _falls(arrays) -> np.ndarray:
    """First u at small r of each upward sweep without noise; the last u if it never is."""
    quiet = arrays["noise"] == 0
    velocity, run = arrays["belt_velocity"][quiet], arrays["replicate"][quiet]
    small = arrays["disorder_parameter"][quiet, 0] < SMALL
    require(velocity.size, "no sweep without noise")
    last = velocity.max()
    return np.array([velocity[small & (run == one)].min(initial=last) for one in np.unique(run)])

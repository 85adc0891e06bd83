"""What explains the fall of r: where orbits of small r begin, and when sweeps find them."""

import numpy as np

from beltrepro.base.errors import require
from beltrepro.replication.studies.fall import measure
from beltrepro.replication.studies.fall.measure import SMALL
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.replication.verdicts.motions import N_BLOCKS, PERMANENT
from beltrepro.stats.estimates import absent, bootstrap, difference, share_of, sure

MET_RANGES = ((14, 17), measure.ABOVE, (19.5, 21.5), (21.5, 24))  # of u: below the fall, and above
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
    return Measurement(
        {
            "small r, exact": exact,
            "sigma = 0.01 less exact": difference(noisy, exact),
            "scheme less exact": difference(stepped, exact),
            "scheme less sigma = 0.01": difference(stepped, noisy),
        },
        {"small r, sigma = 0.01": noisy, "small r, scheme": stepped},
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
    slow = (arrays["n_blocks"] == N_BLOCKS) & (arrays["belt_velocity"] < 2)
    lasting = (arrays["lifetime"] >= PERMANENT) | ~arrays["settled"].astype(bool)
    number = share_of(lasting[slow]) if slow.any() else absent()
    return Measurement(shares, further | {"irregular for 1e6, u below 2": number})


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
    names = ["friction_ratio", "birth"]
    births = births[births["slips"] == measure.FIRST]
    line, linear = births[~births["linear"]], births["scaled"][births["linear"]]
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
        {f"birth at {ratio:g}": absent() for ratio in BIRTH_RATIOS}
        | {f"birth at {ratio:g}": sure(u) for ratio, u in line[names].itertuples(index=False)}
        | {"linear birth": sure(linear.median())},
    )


def _falls(arrays) -> np.ndarray:
    """First u at small r of each upward sweep without noise; the last u if it never is."""
    quiet = arrays["noise"] == 0
    velocity, run = arrays["belt_velocity"][quiet], arrays["replicate"][quiet]
    small = arrays["disorder_parameter"][quiet, 0] < SMALL
    require(velocity.size, "no sweep without noise")
    last = velocity.max()
    return np.array([velocity[small & (run == one)].min(initial=last) for one in np.unique(run)])

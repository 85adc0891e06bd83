"""Claims on transients of five blocks without noise: how long they last, and what they end in."""

from functools import partial

import numpy as np

from beltrepro.replication.studies.chaos.runs_of_motion import LONG, N_BLOCKS, by_spread
from beltrepro.replication.studies.transition import transients
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates, survival
from beltrepro.stats.errors import NotEnoughDataError, require
from beltrepro.stats.estimates import Estimate

MINIMUM_VELOCITIES = 5


# --- how long they last ---------------------------------------------------------------------------


@claim("u7-transient-chaos")
def u7_transient_chaos(evidence):
    """How long runs at u = 7 are irregular before they become periodic, and their exponent then."""

    def measure(runs):
        return Measurement(
            {
                "ends periodic": runs.periodic,
                "irregular for 1000": runs.irregular_for(1000),
                "exponent": runs.exponent,
            },
            note=runs.words,
        )

    return by_spread(evidence, measure)


@claim("transient-lifetime")
def transient_lifetime(evidence):
    """Mean lifetimes against u: until the motion settles, or the last block slips for good."""
    settles = {
        f"until the motion settles, starts spread by {spread:g}": partial(
            _until_it_settles, evidence, spread
        )
        for spread in evidence.claim.parameters["initial_spread"]
    }
    slips = {"until the last block slips for good, the paper's scheme": _until_it_slips}
    return settles | {name: partial(measure, evidence) for name, measure in slips.items()}


def _until_it_settles(evidence, spread):
    return _against_velocity(
        evidence, transients.until_settled(evidence.dataset("survival"), spread)
    )


def _until_it_slips(evidence):
    return _against_velocity(evidence, transients.until_last_stick(evidence.dataset("lifetimes")))


def _against_velocity(evidence, runs):
    """tau near the transition, far from it, and everywhere."""
    parameters = evidence.claim.parameters
    velocity = runs.belt_velocity
    places = np.unique(velocity[transients.between(velocity, *parameters["belt_velocity"])])
    require(
        places.size >= MINIMUM_VELOCITIES,
        f"lifetimes at {places.size} belt velocities, {MINIMUM_VELOCITIES} are needed",
    )
    at_once = 1 - (1 - survival.CONFIDENCE) / places.size  # of the interval of the longest of all
    each = [runs.mean(place, place) for place in places]
    wide = [runs.mean(place, place, confidence=at_once) for place in places]
    unknown = sum(np.isinf(found.mean) for found in each)
    require(not unknown, f"{unknown} lifetimes need longer runs")
    near, far = (runs.mean(*parameters[name]) for name in ("near", "far"))
    longest = max(range(places.size), key=lambda index: each[index].mean)
    return Measurement(
        {
            "near over far": estimates.ratio(_estimate(near), _estimate(far)),
            "slope of ln tau": estimates.slope(places, [_estimate(own, np.log) for own in each]),
            "longest": Estimate(
                each[longest].mean,
                max(own.lower for own in wide),
                max(own.upper for own in wide),
                min(own.runs for own in wide),
            ),
        },
        {"tau near": _estimate(near), "tau far": _estimate(far)},
        note=f"the longest is at u = {places[longest]:g}",
    )


def _estimate(found: survival.MeanLifetime, scale=float) -> Estimate:
    low, value, high = (float(scale(each)) for each in (found.lower, found.mean, found.upper))
    return Estimate(value, low, high, found.runs)


# --- what they end in -----------------------------------------------------------------------------


@claim("continuous-slip")
def continuous_slip(evidence):
    """Share of runs in which the last block slips on at the end, for 18 <= u <= 50."""
    return {
        "the paper's scheme": partial(_slips_on, evidence, "n5_replicates_check", "n5_rows"),
        "exact dynamics": partial(_slips_on, evidence, "n5_replicates", "n5_rows_check"),
    }


def _slips_on(evidence, low_scan, high_scan):
    ranges = evidence.claim.parameters["belt_velocity"]
    cuts = (
        evidence.replicates(N_BLOCKS, 0.0, scan=low_scan),
        evidence.row(N_BLOCKS, 0.0, scan=high_scan),
    )
    found, large = {}, []
    for (name, limits), cut in zip(ranges.items(), cuts, strict=True):
        own = cut.between(*limits)
        require(own.any(), f"no runs for u = {name}")
        on = ~_sticks_late(cut)[own]
        unknown = 0 if cut.duration >= LONG else int((~on).sum())
        found[f"slips on, u = {name}"] = estimates.share(int(on.sum()), on.size, unknown)
        large.append((cut.disorder[own] >= transients.LARGE_AMPLITUDE)[on])
    amplitude = np.concatenate(large)
    require(amplitude.size, "no run slips on")
    also = {"large amplitude, of these": estimates.share(int(amplitude.sum()), amplitude.size)}
    return Measurement(found, also | _high_lifetime(evidence))


def _sticks_late(cut):
    """Which runs stick in the second half of the time after the transient."""
    last = np.nan_to_num(cut.points["last_stick_time"], nan=-np.inf)
    return last >= (cut.transient + cut.duration) / 2


def _high_lifetime(evidence):
    """Mean time until the motion settles at the highest belt velocities, if there are such runs."""
    low, high = evidence.claim.parameters["high_velocity"]
    if not evidence.has("survival"):
        return {}
    try:
        found = transients.until_settled(evidence.dataset("survival")).mean(low, high)
    except NotEnoughDataError:
        return {}
    return {f"lifetime, u = {low:g} to {high:g}": _estimate(found)}

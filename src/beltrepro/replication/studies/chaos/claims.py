"""Claims on the motion of five blocks without noise: chaotic or periodic, and for how long.

What is called chaotic is measured by exponents and recurrence (docs/chaos.md). The exact dynamics
tells which motion lasts; the paper's scheme, which disturbs it, what the authors saw.
"""

from functools import partial

import numpy as np
import scipy

from beltrepro.base.errors import require
from beltrepro.replication.verdicts import motions
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import EXACT, SCHEME
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.replication.verdicts.motions import LONG, N_BLOCKS, SETTLING, Settling, between
from beltrepro.stats import dimension, estimates, states
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.motion import CHAOTIC, PERIODIC

POINTS_OF_GROUP = 700  # section points, of which a dimension needs 500; groups differ in size
FEWEST_GROUPS = 3
PERMANENT = 1e6  # which the paper discards before it looks
SAME_STARTS = {SCHEME: "survival_scheme", EXACT: "survival_long"}


@claim("poincare")
def poincare(evidence):
    """Correlation dimension of the section points, and whether irregular motion lasts."""
    return {
        SCHEME: partial(_section, evidence, "slips_u1", True),
        EXACT: partial(_attractor, evidence),
    }


def _attractor(evidence):
    """Of a chaotic attractor, the motion on it does not end."""
    section = _section(evidence, "slips_u1_event", False)
    velocity = evidence.claim.parameters["belt_velocity"]
    runs = Settling.of(evidence, *SETTLING[EXACT], belt_velocity=velocity)
    staying = {"irregular for 1e6": runs.irregular_for(PERMANENT)}
    also = {"irregular for 1e5": runs.irregular_for(LONG), "exponent": runs.exponent}
    return Measurement(section.judged | staying, also, note=runs.words)


def _section(evidence, name, only_shown):
    catalogue = evidence.dataset(name)
    points = catalogue.arrays["section"]
    if only_shown:
        moving = points["velocities"][:, -1] < catalogue.attributes["belt_velocity"] - 1e-6
        points = points[moving]
    positions, velocities = points["positions"], points["velocities"]
    coordinates = np.hstack([np.delete(positions, 1, axis=1), velocities])
    groups = evidence.claim.parameters["groups"]
    return Measurement({"dimension": _dimension(coordinates, points["point"], groups)})


def _dimension(coordinates: np.ndarray, run: np.ndarray, n_groups: int) -> Estimate:
    """Dimension with the scatter of groups of runs and the error of the fit in its interval."""
    runs, place = np.unique(run, return_inverse=True)
    n_groups = min(n_groups, runs.size, run.size // POINTS_OF_GROUP)
    require(n_groups >= FEWEST_GROUPS, f"{run.size} section points are too few")
    whole = dimension.correlation_dimension(coordinates)
    parts = [
        dimension.correlation_dimension(coordinates[place % n_groups == group]).dimension
        for group in range(n_groups)
    ]
    scatter = estimates.mean(parts)
    reach = np.hypot(scatter.high - scatter.value, scipy.stats.norm.ppf(0.975) * whole.error)
    return Estimate(whole.dimension, whole.dimension - reach, whole.dimension + reach, runs.size)


@claim("u15-aperiodic")
def u15_aperiodic(evidence):
    """Whether runs at u = 15 stay irregular."""

    def measure(runs, method):
        also = {"half of the runs settle by": runs.half_life, "end periodic": runs.ends_periodic}
        if method == EXACT:  # no deviation is followed beside the scheme
            also["exponent"] = runs.exponent
        return Measurement({"irregular for 1e5": runs.irregular_for(LONG)}, also, note=runs.words)

    return motions.by_method(evidence, measure)


@claim("permanent-chaos")
def permanent_chaos(evidence):
    """Share of runs that stay irregular for u <= 15 outside the windows, and of velocities."""
    velocities, note = _outside_windows(evidence)
    return {
        method: partial(_stays_irregular, evidence, name, velocities, note)
        for method, name in SAME_STARTS.items()
    }


def _stays_irregular(evidence, name, velocities, note):
    runs = Settling.of(evidence, name)
    at = runs.arrays["belt_velocity"]
    missing = velocities[~np.isin(velocities, at)]
    require(not missing.size, f"{name} has no runs at u = {', '.join(map('{:g}'.format, missing))}")
    at_each = [runs.where(at == u).irregular_for(PERMANENT) for u in velocities]
    stays = np.array([share.value > 0 for share in at_each])
    unknown = np.array([share.still_open > 0 for share in at_each])
    runs = runs.where(np.isin(at, velocities))
    return Measurement(
        {
            "irregular for 1e6": runs.irregular_for(PERMANENT),
            "velocities with such runs": estimates.share_of(stays, unknown & ~stays),
        },
        {"longest": estimates.sure(runs.arrays["lifetime"].max())},
        note=f"{note}; {runs.words}",
    )


def _outside_windows(evidence):
    """Velocities at which most runs of the scheme do not end on an orbit of few returns."""
    runs = Settling.of(evidence, SAME_STARTS[SCHEME]).arrays
    low, high = evidence.claim.parameters["belt_velocity"]
    velocities = np.unique(runs["belt_velocity"])
    velocities = velocities[between(velocities, low, high)]
    returns = runs["period_returns"]
    few = (returns >= 1) & (returns <= evidence.claim.parameters["window_returns"])
    window = np.array([few[runs["belt_velocity"] == u].mean() > 1 / 2 for u in velocities])
    require(not window.all(), "for u <= 15 most runs end in a window at each velocity")
    words = ", ".join(map("{:g}".format, velocities[window])) or "none"
    return velocities[~window], f"windows at u = {words}"


@claim("no-permanent-chaos")
def no_permanent_chaos(evidence):
    """Runs in 18 <= u <= 50 that are chaotic: their share, and whether there is one at all."""
    return {
        SCHEME: partial(_chaotic_by_look, evidence),
        EXACT: partial(_chaotic_motions, evidence),
    }


def _chaotic_by_look(evidence):
    """Long orbits look chaotic too; short runs may be transients."""
    row = evidence.row(N_BLOCKS, 0.0, scan="n5_rows")
    looking, long = row.states == states.CHAOTIC, row.duration >= LONG
    shares = {}
    for name, ends in evidence.claim.parameters["belt_velocity"].items():
        chaotic = looking[row.between(*ends)]
        shares[f"chaotic, u = {name}"] = estimates.share_of(chaotic & long, chaotic & (not long))
    return Measurement(shares)


def _chaotic_motions(evidence):
    """Above, irregular motion lasts so long that only the longest runs tell whether it ends."""
    below, above = evidence.claim.parameters["belt_velocity"].items()
    runs = motions.motions(evidence, N_BLOCKS, *below[1], besides="survival")
    longest = Settling.of(evidence, "survival_long")
    longest = longest.where(between(longest.arrays["belt_velocity"], *above[1]))
    require(longest.arrays["settled"].size, f"survival_long has no runs at u = {above[0]}")
    return Measurement(
        {
            f"chaotic, u = {below[0]}": motions.share(runs, CHAOTIC),
            f"irregular for 1e6, u = {above[0]}": longest.irregular_for(PERMANENT),
        },
        {"unsettled at the end": estimates.share_of(~longest.arrays["settled"])},
        note=f"u = {below[0]}: {motions.in_words(runs)}; u = {above[0]}: {longest.words}",
    )


@claim("bifurcation-sigma0")
def bifurcation_sigma0(evidence):
    """Chaotic bands and periodic windows for u <= 15."""
    return {
        SCHEME: partial(_bands_by_look, evidence),
        EXACT: partial(_bands_of_motions, evidence),
    }


def _bands_by_look(evidence):
    row = evidence.replicates(N_BLOCKS, 0.0, scan="n5_replicates_check")
    labels = row.states[row.between(*evidence.claim.parameters["belt_velocity"])]
    require(labels.size, "no runs for u <= 15")
    unknown = np.isin(labels, (states.TRANSIENT, states.UNDECIDED))
    looks = {"chaotic": states.CHAOTIC, "periodic": states.PERIODIC}
    return Measurement(
        {name: estimates.share_of(labels == look, unknown) for name, look in looks.items()},
        note=f"{unknown.sum()} of {labels.size} runs could not be named",
    )


def _bands_of_motions(evidence):
    ends = evidence.claim.parameters["belt_velocity"]
    runs = motions.motions(evidence, N_BLOCKS, *ends, besides="survival_long")
    shares = {name: motions.share(runs, name) for name in (CHAOTIC, PERIODIC)}
    return Measurement(shares, note=motions.in_words(runs))

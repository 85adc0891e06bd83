"""Claims on the motion of five blocks without noise: chaotic or periodic, and for how long.

What is called chaotic is measured by exponents and recurrence (docs/chaos.md). The exact dynamics
tells which motion lasts; the paper's scheme, which disturbs it, what the authors saw.
"""

import numpy as np

from beltrepro.base.errors import require
from beltrepro.replication.studies.chaos import measure
from beltrepro.replication.verdicts import motions
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import EXACT, SCHEME
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.replication.verdicts.motions import LONG, N_BLOCKS, SETTLING, Settling, between
from beltrepro.stats import estimates, states
from beltrepro.stats.motion import CHAOTIC, PERIODIC

PERMANENT = 1e6  # which the paper discards before it looks
SAME_STARTS = {SCHEME: "survival_scheme", EXACT: "survival_long"}


@claim("poincare", SCHEME)
def section_of_scheme(evidence):
    """Correlation dimension of the section points that the paper shows."""
    catalogue = evidence.dataset("slips_u1")
    points = catalogue.arrays["section"]
    moving = points["velocities"][:, -1] < catalogue.attributes["belt_velocity"] - 1e-6
    groups = evidence.claim.parameters["groups"]
    return Measurement({"dimension": measure.section_dimension(points[moving], groups)})


@claim("poincare", EXACT)
def attractor(evidence):
    """Dimension of all section points; of a chaotic attractor, the motion on it does not end."""
    points = evidence.dataset("slips_u1_event").arrays["section"]
    whole = measure.section_dimension(points, evidence.claim.parameters["groups"])
    runs = motions.settling(evidence, SETTLING[EXACT])
    judged = {"dimension": whole, "irregular for 1e6": runs.irregular_for(PERMANENT)}
    also = {"irregular for 1e5": runs.irregular_for(LONG), "exponent": runs.exponent}
    return Measurement(judged, also, note=runs.words)


@claim("u15-aperiodic", SETTLING)
def u15_aperiodic(evidence, names):
    runs = motions.settling(evidence, names)
    also = {"half of the runs settle by": runs.half_life, "end periodic": runs.ends_periodic}
    if names != SETTLING[SCHEME]:  # no deviation is followed beside the scheme
        also["exponent"] = runs.exponent
    return Measurement({"irregular for 1e5": runs.irregular_for(LONG)}, also, note=runs.words)


@claim("permanent-chaos", SAME_STARTS)
def permanent_chaos(evidence, name):
    """Share of runs that stay irregular for u <= 15 outside the windows, and of velocities."""
    velocities, note = _outside_windows(evidence)
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


@claim("no-permanent-chaos", SCHEME)
def chaotic_by_look(evidence):
    """Runs in 18 <= u <= 50 that look chaotic: long orbits do too; short runs may be transients."""
    row = evidence.row(N_BLOCKS, 0.0, scan="n5_rows")
    looking, long = row.states == states.CHAOTIC, row.duration >= LONG
    shares = {}
    for name, ends in evidence.claim.parameters["belt_velocity"].items():
        chaotic = looking[row.between(*ends)]
        shares[f"chaotic, u = {name}"] = estimates.share_of(chaotic & long, chaotic & (not long))
    return Measurement(shares)


@claim("no-permanent-chaos", EXACT)
def chaotic_motions(evidence):
    """Runs that are chaotic, and above u = 41, where this lasts, those irregular for a million."""
    below, above = evidence.claim.parameters["belt_velocity"].items()
    runs = motions.runs(evidence, N_BLOCKS, *below[1], besides="survival")
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


@claim("bifurcation-sigma0", SCHEME)
def bands_by_look(evidence):
    """Chaotic bands and periodic windows for u <= 15, by the look of the section."""
    row = evidence.replicates(N_BLOCKS, 0.0, scan="n5_replicates_check")
    labels = row.states[row.between(*evidence.claim.parameters["belt_velocity"])]
    require(labels.size, "no runs for u <= 15")
    unknown = np.isin(labels, (states.TRANSIENT, states.UNDECIDED))
    looks = {"chaotic": states.CHAOTIC, "periodic": states.PERIODIC}
    return Measurement(
        {name: estimates.share_of(labels == look, unknown) for name, look in looks.items()},
        note=f"{unknown.sum()} of {labels.size} runs could not be named",
    )


@claim("bifurcation-sigma0", EXACT)
def bands_of_motions(evidence):
    ends = evidence.claim.parameters["belt_velocity"]
    runs = motions.runs(evidence, N_BLOCKS, *ends, besides="survival_long")
    shares = {name: motions.share(runs, name) for name in (CHAOTIC, PERIODIC)}
    return Measurement(shares, note=motions.in_words(runs))

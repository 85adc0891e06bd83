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
from beltrepro.replication.verdicts.motions import LONG, N_BLOCKS, PERMANENT, SETTLING, Settling
from beltrepro.stats import estimates, states
from beltrepro.stats.motion import CHAOTIC, PERIODIC

SAME_STARTS = {SCHEME: ("survival_scheme",), EXACT: ("survival_long",)}
CATALOGUES = {SCHEME: "slips_u1", EXACT: "slips_u1_event"}
# `survival_many` where a preset has no long runs there
NEAR_15 = SAME_STARTS | {EXACT: (*SAME_STARTS[EXACT], "survival_many")}


@claim("poincare", {SCHEME: SCHEME, EXACT: EXACT})
def section_of_attractor(evidence, reading):
    """Dimension of the section points that the paper shows, of runs that have not yet settled."""
    catalogue = evidence.dataset(CATALOGUES[reading])
    runs, also = _followed(evidence, SETTLING[reading])
    points = catalogue.arrays["section"]
    points = points[measure.before_settling(points)]
    moving = points["velocities"][:, -1] < catalogue.attributes["belt_velocity"] - 1e-6
    judged = {
        "dimension": measure.section_dimension(points[moving], evidence.claim.parameters["groups"])
    }
    lasting = also if reading == SCHEME else judged  # the paper looked at what it shows, no longer
    lasting["irregular for 1e6"] = runs.irregular_for(PERMANENT)
    return Measurement(
        judged,
        also,
        note=f"{moving.sum()} section points; {runs.words}",
    )


@claim("u15-aperiodic", NEAR_15)
def u15_aperiodic(evidence, names):
    runs, also = _followed(evidence, names)
    also |= {"end periodic": runs.ends_periodic}
    return Measurement({"irregular for 1e5": runs.irregular_for(LONG)}, also, note=runs.words)


def _followed(evidence, names):
    """Runs at the belt velocities of the claim, and what is reported of them."""
    runs = motions.settling(evidence, names)
    also = {"half of the runs settle by": runs.half_life}
    if names != SETTLING[SCHEME]:  # no deviation is followed beside the scheme
        also |= {"exponent": runs.exponent}
        also |= {"nontrivial exponent": motions.nontrivial_exponent(evidence)}
    return runs, also


@claim("permanent-chaos", SAME_STARTS)
def permanent_chaos(evidence, names):
    """Share of runs that stay irregular for u <= 15 outside the windows, and of velocities.

    A window is what the bifurcation diagram shows as one: other runs, from the declared start.
    """
    low, high = evidence.claim.parameters["belt_velocity"]
    windows, note = motions.looks(evidence, N_BLOCKS, low, high)[1:]
    runs = Settling.of(evidence, *names, belt_velocity=(low, high))
    at = runs.arrays["belt_velocity"]
    runs = runs.where(~np.isclose(at[:, None], windows, atol=1e-6).any(axis=1))
    at = runs.arrays["belt_velocity"]
    require(at.size, "for u <= 15 all runs are in windows")
    at_each = [runs.where(at == u).irregular_for(PERMANENT) for u in np.unique(at)]
    stays = np.array([share.value > 0 for share in at_each])
    unknown = np.array([share.still_open > 0 for share in at_each])
    return Measurement(
        {
            "irregular for 1e6": runs.irregular_for(PERMANENT),
            "velocities with such runs": estimates.share_of(stays, unknown & ~stays),
        },
        {"half of the runs settle by": runs.half_life},
        note=f"windows at {windows.size} velocities of the diagram, {note}; {runs.words}",
    )


@claim("no-permanent-chaos", SCHEME)
def chaotic_by_look(evidence):
    """Runs in 18 <= u <= 50 that look chaotic: long orbits do too; short runs may be transients."""
    row = evidence.row("n5_rows", N_BLOCKS, 0.0)
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
    longest = Settling.of(evidence, "survival_long", belt_velocity=above[1])
    return Measurement(
        {
            f"chaotic, u = {below[0]}": motions.share(runs, CHAOTIC),
            f"irregular for 1e6, u = {above[0]}": longest.irregular_for(PERMANENT),
            "a run irregular to its end": estimates.sure(
                np.any(~longest.arrays["settled"] & (longest.arrays["lifetime"] >= PERMANENT))
            ),
        },
        note=f"u = {below[0]}: {motions.in_words(runs)}; u = {above[0]}: {longest.words}",
    )


@claim("bifurcation-sigma0", SCHEME)
def bands_by_look(evidence):
    """Chaotic bands and periodic windows for u <= 15, by the look of the diagram."""
    ends = evidence.claim.parameters["belt_velocity"]
    shares, _, note = motions.looks(evidence, N_BLOCKS, *ends)
    return Measurement(shares, note=note)


@claim("bifurcation-sigma0", EXACT)
def bands_of_motions(evidence):
    ends = evidence.claim.parameters["belt_velocity"]
    runs = motions.runs(evidence, N_BLOCKS, *ends, besides="survival_long")
    shares = {name: motions.share(runs, name) for name in (CHAOTIC, PERIODIC)}
    return Measurement(shares, note=motions.in_words(runs))

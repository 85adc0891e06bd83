"""Claims on the motion of five blocks without noise: chaotic or periodic, and for how long.

What is called chaotic is measured by exponents and recurrence (docs/chaos.md). The motion is that
of the exact dynamics; the paper's scheme, which disturbs it, is a variant.
"""

from functools import partial

import numpy as np
import scipy

from beltrepro.base.errors import require
from beltrepro.replication.studies.chaos.runs_of_motion import (
    LONG,
    N_BLOCKS,
    between,
    by_spread,
    motions,
    runs_from,
    settled_motions,
)
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import dimension, estimates, states
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.motion import CHAOTIC, PERIODIC

PAPERS_SCHEME = "n5_replicates_check"
POINTS_OF_GROUP = 700  # section points, of which a dimension needs 500; groups differ in size
FEWEST_GROUPS = 3


@claim("poincare")
def poincare(evidence):
    """Correlation dimension of the section points, and whether the motion is chaotic."""
    catalogue, parameters = evidence.dataset("slips_u1"), evidence.claim.parameters
    points, belt_velocity = catalogue.arrays["section"], catalogue.attributes["belt_velocity"]
    runs = runs_from(evidence, belt_velocity, parameters["initial_spread"])
    positions, velocities = points["positions"], points["velocities"]
    state = np.hstack([np.delete(positions, 1, axis=1), velocities])
    shown = velocities[:, -1] < belt_velocity - 1e-6
    projection = np.column_stack([positions[:, -1], velocities[:, -1]])

    def reading(coordinates, chosen):
        estimate = _dimension(coordinates[chosen], points["point"][chosen], parameters["groups"])
        return Measurement({"dimension": estimate, "exponent": runs.exponent}, note=runs.words)

    return {
        "all nine coordinates": partial(reading, state, np.full(points.size, True)),
        "points shown (v_rN < 0)": partial(reading, state, shown),
        "their projection on (x_N, v_rN)": partial(reading, projection, shown),
    }


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
    """Whether runs at u = 15 stay irregular, and their exponent."""

    def measure(runs):
        judged = {"irregular for 1e5": runs.irregular_for(LONG), "exponent": runs.exponent}
        return Measurement(judged, note=runs.words)

    return by_spread(evidence, measure)


@claim("permanent-chaos")
def permanent_chaos(evidence):
    """Share of runs for u <= 15 that stay chaotic, of those that do not end in a window."""
    spread, step = (evidence.claim.parameters[name] for name in ("initial_spread", "time_step"))
    stays = partial(_stays_irregular, evidence)
    return {
        "chaotic to the end": partial(_stays_chaotic, evidence),
        "irregular for 1e5": partial(stays, "survival", initial_spread=spread),
        "irregular for 1e5 by the paper's scheme": partial(stays, "steps", time_step=step),
    }


def _stays_chaotic(evidence):
    runs = motions(evidence, N_BLOCKS, *evidence.claim.parameters["belt_velocity"])
    outside = ~_in_window(evidence, runs.names == PERIODIC, runs.returns)
    others = runs.where(outside)
    return _permanent(others.share(CHAOTIC) if outside.any() else None, outside, others.words)


def _stays_irregular(evidence, name, **where):
    arrays, attributes = evidence.runs(name, n_blocks=N_BLOCKS, **where)
    chosen = between(arrays["belt_velocity"], *evidence.claim.parameters["belt_velocity"])
    settled = arrays["settled"][chosen].astype(bool)
    outside = ~_in_window(evidence, settled, arrays["period_returns"][chosen])
    lasting = (arrays["lifetime"][chosen] >= LONG)[outside]
    still_open = ~lasting & ~settled[outside]
    counts = int(lasting.sum()), lasting.size, int(still_open.sum())
    return _permanent(
        estimates.share(*counts) if lasting.size else None,
        outside,
        f"{settled[outside].sum()} settled within {attributes['duration']:g}, {counts[2]} open",
    )


def _in_window(evidence, periodic, returns):
    few = evidence.claim.parameters["window_returns"]
    return periodic & (returns >= 1) & (returns <= few)


def _permanent(share, outside, words):
    require(outside.size, "no runs for u <= 15")
    note = f"{(~outside).sum()} of {outside.size} runs end in a window; of the others {words}"
    require(share is not None, note)
    return Measurement({"permanent outside the windows": share}, note=note)


@claim("no-permanent-chaos")
def no_permanent_chaos(evidence):
    """Share of runs in 18 <= u <= 50 that are chaotic."""
    return {
        "starts spread by 1 and by 10": partial(_chaotic_shares, evidence, _all_motions),
        "starts spread by 1, after a transient": partial(
            _chaotic_shares, evidence, lambda *place: motions(place[0], N_BLOCKS, *place[1:])
        ),
    }


def _chaotic_shares(evidence, runs_of):
    ranges = evidence.claim.parameters["belt_velocity"]
    runs = {name: runs_of(evidence, low, high) for name, (low, high) in ranges.items()}
    return Measurement(
        {f"chaotic, u = {name}": in_range.share(CHAOTIC) for name, in_range in runs.items()},
        note="; ".join(f"u = {name}: {in_range.words}" for name, in_range in runs.items()),
    )


def _all_motions(evidence, low, high):
    """Runs of `motion_map` and others, whose starts are spread wider: none is counted twice."""
    spread = evidence.claim.parameters["initial_spread"]
    others = settled_motions(evidence, low, high, spread)
    return motions(evidence, N_BLOCKS, low, high).and_also(others)


@claim("bifurcation-sigma0")
def bifurcation_sigma0(evidence):
    """Chaotic bands and periodic windows for u <= 15."""
    return {
        "motions by exponent and recurrence": partial(_bands_of_motions, evidence),
        "look of the section, the paper's scheme": partial(_bands_by_look, evidence),
    }


def _bands_of_motions(evidence):
    runs = motions(evidence, N_BLOCKS, *evidence.claim.parameters["belt_velocity"])
    return Measurement(
        {"chaotic": runs.share(CHAOTIC), "periodic": runs.share(PERIODIC)}, note=runs.words
    )


def _bands_by_look(evidence):
    row = evidence.replicates(N_BLOCKS, 0.0, scan=PAPERS_SCHEME)
    labels = row.states[row.between(*evidence.claim.parameters["belt_velocity"])]
    require(labels.size, f"{PAPERS_SCHEME} has no runs for u <= 15")
    unknown = int(np.isin(labels, (states.TRANSIENT, states.UNDECIDED)).sum())
    return Measurement(
        {
            name: estimates.share(int((labels == label).sum()), labels.size, unknown)
            for name, label in (("chaotic", states.CHAOTIC), ("periodic", states.PERIODIC))
        },
        note=f"{unknown} of {labels.size} runs could not be named",
    )

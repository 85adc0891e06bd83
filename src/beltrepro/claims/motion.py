"""Claims that rest on what is called chaotic, measured by exponents and recurrence (docs/chaos.md).

The motion without noise is that of the exact dynamics. Runs that were still irregular at the end
without an exponent above zero are open: they may count either way, and where that decides, a claim
is not measured.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from beltrepro.analysis import dimension, lifetimes, states
from beltrepro.analysis.errors import NotEnoughDataError, require
from beltrepro.analysis.fits import rank_correlation
from beltrepro.analysis.motion import CHAOTIC, MOTIONS, PERIODIC, TRANSIENT
from beltrepro.claims.criteria import Measurement
from beltrepro.claims.registry import claim

N_BLOCKS = 5
CHAOTIC_SIZES = (5, 6, 7, 10)
REGULAR_SHARE = 0.05
MINIMUM_SECTION_POINTS = 5000
MINIMUM_RUNS = 8
ERRORS = 3.0  # standard errors by which an exponent must be above zero
LONG = 1e5  # motion that is irregular for less may still be a transient


@dataclass(frozen=True)
class Share:
    """How many runs have a property, and how many may still turn out to have it."""

    known: int
    open: int
    total: int

    @property
    def low(self) -> float:
        """The share if no open run has it."""
        return self.known / self.total

    @property
    def high(self) -> float:
        """The share if all open runs have it."""
        return (self.known + self.open) / self.total

    def reaches(self, limit: float, what: str) -> bool:
        """Whether the share is at least `limit`; NotEnoughDataError if the open runs decide."""
        require(
            self.low >= limit or self.high < limit,
            f"{what}: {self.known} of {self.total} runs, {self.open} more are open, and a share of "
            f"{limit:g} decides: longer runs are needed",
        )
        return self.low >= limit


def chaotic_share(labels: np.ndarray) -> Share:
    """Share of the runs that are chaotic."""
    require(labels.size >= MINIMUM_RUNS, f"{labels.size} runs, {MINIMUM_RUNS} are needed")
    counts = [int(np.sum(labels == name)) for name in (CHAOTIC, TRANSIENT)]
    return Share(*counts, labels.size)


def motions(evidence, n_blocks, low=0.0, high=np.inf):
    """States of the runs of so many blocks with low <= u <= high."""
    arrays = evidence.dataset("motion_map").arrays
    velocity = arrays["belt_velocity"]
    own = (arrays["n_blocks"] == n_blocks) & (velocity >= low - 1e-9) & (velocity <= high + 1e-9)
    require(own.any(), f"motion_map has no run with N = {n_blocks} and {low:g} <= u <= {high:g}")
    return np.asarray(arrays["state"], dtype=str)[own]


@dataclass(frozen=True)
class Survival:
    """Runs from one point: how long each was irregular, whether it settled, and its exponent."""

    lifetime: np.ndarray
    settled: np.ndarray
    exponent: float
    error: float
    duration: float

    @property
    def exponent_above_zero(self) -> bool:
        """Whether the exponent of the irregular motion is above zero by three standard errors."""
        return self.exponent > ERRORS * self.error

    @property
    def share(self) -> Share:
        """Share of the runs that are irregular for ever: none for certain."""
        left = int(np.sum(~self.settled))
        ever = left if self.duration >= LONG else 0
        return Share(ever, left - ever, self.settled.size)

    @property
    def words(self) -> str:
        """What happened to the runs."""
        return (
            f"{int(self.settled.sum())} of {self.settled.size} runs settled within "
            f"{self.duration:g}"
        )


def survival(evidence, belt_velocity):
    """The runs of five blocks at a belt velocity that were followed until they settled."""
    dataset = evidence.dataset("survival")
    arrays = dataset.arrays
    own = (arrays["n_blocks"] == N_BLOCKS) & (
        np.abs(arrays["belt_velocity"] - belt_velocity) <= 0.25
    )
    require(own.sum() >= MINIMUM_RUNS, f"{own.sum()} runs at u = {belt_velocity:g}, 8 are needed")
    exponents = arrays["irregular_exponent"][own]
    exponents = exponents[np.isfinite(exponents)]
    many = exponents.size >= 3
    return Survival(
        arrays["lifetime"][own],
        arrays["settled"][own].astype(bool),
        float(exponents.mean()) if many else np.nan,
        float(exponents.std(ddof=1) / np.sqrt(exponents.size)) if many else np.nan,
        float(dataset.attributes["duration"]),
    )


# --- five blocks without noise --------------------------------------------------------------------


@claim("poincare")
def poincare(evidence):
    """Correlation dimension of the section points, and whether the motion is chaotic."""
    catalogue = evidence.dataset("slips_u1")
    points = catalogue.arrays["section"]
    require(
        points.size >= MINIMUM_SECTION_POINTS,
        f"{points.size} section points, {MINIMUM_SECTION_POINTS} are needed",
    )
    runs = survival(evidence, float(catalogue.attributes["belt_velocity"]))
    positions, velocities = points["positions"], points["velocities"]
    state = np.hstack([np.delete(positions, 1, axis=1), velocities])
    shown = velocities[:, -1] < catalogue.attributes["belt_velocity"] - 1e-6
    projection = np.column_stack([positions[shown, -1], velocities[shown, -1]])

    def reading(coordinates):
        found = dimension.correlation_dimension(coordinates)
        return Measurement(
            {"dimension": found.dimension},
            {"dimension": found.error},
            found.n_points,
            checks={"exponent of the irregular motion above zero": runs.exponent_above_zero},
            note=f"dimension for distances {found.low:.2g} to {found.high:.2g}; exponent "
            f"{runs.exponent:.2g} +- {runs.error:.1g}; {runs.words}",
        )

    return {
        "all nine coordinates": partial(reading, state),
        "points shown (v_rN < 0)": partial(reading, state[shown]),
        "their projection on (x_N, v_rN)": partial(reading, projection),
    }


@claim("u15-aperiodic")
def u15_aperiodic(evidence):
    """Whether runs at u = 15 stay irregular, and their exponent."""
    runs = survival(evidence, 15.0)
    return Measurement(
        {"share irregular to the end": runs.share.high, "exponent": runs.exponent},
        {"exponent": runs.error},
        runs.settled.size,
        checks={
            "at least half stay irregular": runs.share.reaches(0.5, "irregular for 1e5 or more"),
            "exponent above zero": runs.exponent_above_zero,
        },
        note=f"{runs.words}, half of them by {np.median(runs.lifetime):.3g}",
    )


@claim("no-permanent-chaos")
def no_permanent_chaos(evidence):
    """Share of runs in 18 <= u <= 50 that are chaotic to the end."""
    labels = motions(evidence, N_BLOCKS, *evidence.claim.parameters["belt_velocity"])
    share = chaotic_share(labels)
    share.reaches(REGULAR_SHARE, "chaotic")
    error = np.sqrt(share.low * (1 - share.low) / share.total)
    return Measurement(share.low, error, share.total, note=_counted(labels))


@claim("bifurcation-sigma0")
def bifurcation_sigma0(evidence):
    """Chaotic bands and periodic windows for u <= 15."""
    labels = motions(evidence, N_BLOCKS, *evidence.claim.parameters["belt_velocity"])
    share = chaotic_share(labels)
    periodic = float(np.mean(labels == PERIODIC))
    return Measurement(
        {"chaotic share": share.low, "periodic share": periodic},
        sample_size=labels.size,
        checks={
            "chaotic bands": share.reaches(0.5, "chaotic"),
            "periodic windows": periodic > 0,
        },
        note=_counted(labels),
    )


@claim("transient-lifetime")
def transient_lifetime(evidence):
    """Mean lifetimes against u: until the motion is regular, or the last block slips for good."""
    return {
        "until the motion settles, exact dynamics": partial(_lifetimes, evidence, "survival"),
        "until the last block slips for good, the paper's scheme": partial(
            _lifetimes, evidence, "lifetimes"
        ),
    }


def _lifetimes(evidence, name):
    runs = evidence.dataset(name)
    arrays = runs.arrays
    low, high = evidence.claim.parameters["belt_velocity"]
    own = (arrays["n_blocks"] == N_BLOCKS) & (arrays["belt_velocity"] >= low)
    own &= arrays["belt_velocity"] <= high
    ended = "settled" if "settled" in arrays else "escaped"
    chosen = {
        "belt_velocity": arrays["belt_velocity"][own],
        "lifetime": arrays["lifetime"][own],
        "escaped": arrays[ended][own],
    }
    table = lifetimes.by_belt_velocity(chosen, float(runs.attributes["duration"]))
    velocity, tau, error = table["belt_velocity"], table["tau"], table["tau_error"]
    known = np.isfinite(tau)
    require(known.sum() >= 5, f"lifetimes at {known.sum()} belt velocities, 5 are needed")
    near, far = known & (velocity <= 21), known & (velocity >= 30)
    require(near.any() and far.any(), "no lifetimes on one side of the range 18 <= u <= 35")
    rank = rank_correlation(velocity[known], tau[known])
    longest = int(np.nanargmax(tau))
    names = ("tau, u = 18 to 21", "tau, u = 30 to 35")
    return Measurement(
        {name: float(tau[part].mean()) for name, part in zip(names, (near, far), strict=True)}
        | {"rank correlation": rank},
        {name: _mean_error(error[part]) for name, part in zip(names, (near, far), strict=True)},
        int(table["members"].sum()),
        checks={
            "grows towards the transition": bool(tau[near].mean() >= 3 * tau[far].mean()),
            "falls with u": rank < -0.5,
            "tau below 1e4": bool(known.all() and (tau < 1e4).all()),
        },
        note=f"longest {tau[longest]:.3g} at u = {velocity[longest]:g}",
    )


@claim("u7-transient-chaos")
def u7_transient_chaos(evidence):
    """How long runs at u = 7 are irregular before they become periodic, and their exponent then."""
    runs = survival(evidence, 7.0)
    require(runs.settled.any() or runs.duration >= LONG, f"{runs.words}: longer runs are needed")
    return Measurement(
        {"median lifetime": float(np.median(runs.lifetime)), "exponent": runs.exponent},
        {"exponent": runs.error},
        runs.settled.size,
        checks={
            "ends periodic": bool(runs.settled.mean() >= 0.5),
            "irregular before": bool(np.median(runs.lifetime) >= 1000),
            "exponent of the irregular motion above zero": runs.exponent_above_zero,
        },
        note=runs.words,
    )


# --- noise ----------------------------------------------------------------------------------------


def exponents_under_noise(evidence, belt_velocity):
    """Noise levels, mean largest exponents over the runs, and their standard errors."""
    arrays = evidence.dataset("noisy_motion").arrays
    own = arrays["belt_velocity"] == belt_velocity
    noise = np.unique(arrays["noise"][own])
    values = [arrays["largest_exponent"][own & (arrays["noise"] == level)] for level in noise]
    few = min((each.size for each in values), default=0)
    require(few >= MINIMUM_RUNS, f"{few} runs at a noise level, {MINIMUM_RUNS} are needed")
    error = [each.std(ddof=1) / np.sqrt(each.size) for each in values]
    return noise, np.array([each.mean() for each in values]), np.array(error)


# --- other numbers of blocks ----------------------------------------------------------------------


@claim("small-n-regular")
def small_n_regular(evidence):
    """Chaotic runs and transitions of two, three and four blocks."""
    values, checks, size = {}, {}, 0
    for n_blocks in evidence.claim.parameters["n_blocks"]:
        labels = motions(evidence, n_blocks)
        share = chaotic_share(labels)
        fall = evidence.row(n_blocks, 0.0).transition
        values[f"N = {n_blocks}, chaotic share"] = share.low
        checks[f"N = {n_blocks} is regular"] = not share.reaches(REGULAR_SHARE, f"N = {n_blocks}")
        checks[f"N = {n_blocks} has no transition"] = not (fall.found and fall.error < 2)
        size += labels.size
    return Measurement(values, sample_size=size, checks=checks)


@claim("chaos-from-n5")
def chaos_from_n5(evidence):
    """Chaos and periodic motion below the transition, and its width, for five and more blocks."""
    shares, periodic, widths, size = {}, {}, {}, 0
    for n_blocks in CHAOTIC_SIZES:
        fall = evidence.row(n_blocks, 0.0).transition
        labels = motions(evidence, n_blocks, high=fall.lower if fall.found else 15.0)
        shares[n_blocks] = chaotic_share(labels)
        periodic[n_blocks] = float(np.mean(labels == PERIODIC))
        if fall.found:
            widths[n_blocks] = fall.width
        size += labels.size
    require(len(widths) >= 3, f"a transition is found for {len(widths)} numbers of blocks, not 3")
    return Measurement(
        {f"N = {n}, chaotic share": share.low for n, share in shares.items()}
        | {f"N = {n}, periodic share": share for n, share in periodic.items()}
        | {f"N = {n}, width": width for n, width in widths.items()},
        sample_size=size,
        checks={
            f"chaos dominates, N = {n}": share.reaches(0.5, f"N = {n}, chaotic")
            for n, share in shares.items()
        }
        | {
            "fewer windows with N": rank_correlation(periodic.keys(), periodic.values()) < -0.5,
            "wider transition with N": rank_correlation(widths.keys(), widths.values()) > 0.5,
        },
    )


@claim("complexity-at-n5")
def complexity_at_n5(evidence):
    """Entropy of the states over u, against the number of blocks."""
    return {
        "sigma = 0, motions by exponent and recurrence": partial(_entropy_of_motions, evidence),
        "sigma = 1, states by the look of the section": partial(_entropy_of_states, evidence, 1.0),
    }


def _entropy_of_motions(evidence):
    entropy, size = {}, 0
    for n_blocks in (2, 3, 4, *CHAOTIC_SIZES):
        labels = motions(evidence, n_blocks, 1, 50)
        share = np.array([np.mean(labels == name) for name in MOTIONS])
        share = share[share > 0]
        entropy[n_blocks] = float(-np.sum(share * np.log2(share)))
        size += labels.size
    return _richest(entropy, size)


def _entropy_of_states(evidence, noise):
    entropy, size = {}, 0
    for n_blocks in (2, 3, 4, *CHAOTIC_SIZES):
        row = evidence.row(n_blocks, noise)
        inside = row.between(1, 50)
        entropy[n_blocks] = states.diversity(row.states[inside])
        size += int(inside.sum())
    if not np.isfinite(list(entropy.values())).all():
        raise NotEnoughDataError("states could not be named for every N")
    return _richest(entropy, size)


def _richest(entropy, size):
    richest = max(entropy, key=entropy.get)
    return Measurement(
        {f"N = {n}": bits for n, bits in entropy.items()},
        sample_size=size,
        checks={"richest at N = 4, 5 or 6": richest in (4, 5, 6)},
        note=f"entropy in bits; largest at N = {richest}",
    )


def _mean_error(errors):
    return float(np.sqrt(np.nansum(errors**2)) / errors.size)


def _counted(labels):
    names, count = np.unique(labels, return_counts=True)
    return ", ".join(f"{number} {name}" for name, number in zip(names, count, strict=True))

"""Claims that rest on what is called chaotic, measured by exponents and recurrence (docs/chaos.md).

The motion without noise is that of the exact dynamics. Irregular motion may end after any time.
Here it counts as lasting if it is seen for LONG. Runs that are given up before, and those without
an exponent above zero, are open: longer runs may show either. Where they decide, a claim is not
measured.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np
from scipy import stats

from beltrepro.analysis import dimension, lifetimes, sections, states
from beltrepro.analysis.errors import require
from beltrepro.analysis.fits import rank_correlation
from beltrepro.analysis.motion import CHAOTIC, ERRORS, PERIODIC, TRANSIENT
from beltrepro.claims.criteria import Measurement, judge, show
from beltrepro.claims.registry import claim

N_BLOCKS = 5
SMALL_SIZES = (2, 3, 4)
CHAOTIC_SIZES = (5, 6, 7, 10)
REGULAR_SHARE = 0.05
MINIMUM_SECTION_POINTS = 1000
MINIMUM_RUNS = 8
MINIMUM_EXPONENTS = 3
LONG = 1e5
SETTLING = ("survival_long", "survival_many", "survival")  # the first with runs at a point serves


# --- five blocks without noise --------------------------------------------------------------------


@claim("poincare")
def poincare(evidence):
    """Correlation dimension of the section points, and whether the motion is chaotic."""
    catalogue = evidence.dataset("slips_u1")
    points, belt_velocity = catalogue.arrays["section"], catalogue.attributes["belt_velocity"]
    require(
        points.size >= MINIMUM_SECTION_POINTS,
        f"{points.size} section points, {MINIMUM_SECTION_POINTS} are needed",
    )
    runs = _runs_from(evidence, belt_velocity, evidence.claim.parameters["initial_spread"])
    positions, velocities = points["positions"], points["velocities"]
    state = np.hstack([np.delete(positions, 1, axis=1), velocities])
    shown = velocities[:, -1] < belt_velocity - 1e-6
    projection = np.column_stack([positions[shown, -1], velocities[shown, -1]])

    def reading(coordinates):
        found = dimension.correlation_dimension(coordinates)
        exponent, error = runs.exponent
        return Measurement(
            found.dimension,
            found.error,
            found.n_points,
            checks={"exponent above zero": runs.exponent_above_zero},
            note=f"fit for distances {found.low:.2g} to {found.high:.2g}; exponent of the "
            f"irregular motion {show(exponent, 2)}, error {show(error, 1)}; {runs.words}",
        )

    return {
        "all nine coordinates": partial(reading, state),
        "points shown (v_rN < 0)": partial(reading, state[shown]),
        "their projection on (x_N, v_rN)": partial(reading, projection),
    }


@claim("u7-transient-chaos")
def u7_transient_chaos(evidence):
    """How long runs at u = 7 are irregular before they become periodic, and their exponent then."""
    return _by_spread(evidence, _transient_chaos)


def _transient_chaos(runs):
    exponent, error = runs.exponent
    return Measurement(
        {"median lifetime": float(np.median(runs.lifetime)), "exponent": exponent},
        {"exponent": error},
        runs.settled.size,
        checks={
            "ends periodic": decided(_half, runs.periodic),
            "irregular before": decided(_half, runs.irregular_for(1000)),
            "exponent above zero": runs.exponent_above_zero,
        },
        note=runs.words,
    )


@claim("u15-aperiodic")
def u15_aperiodic(evidence):
    """Whether runs at u = 15 stay irregular, and their exponent."""
    return _by_spread(evidence, _lasting_chaos)


def _lasting_chaos(runs):
    irregular, (exponent, error) = runs.irregular_for(LONG), runs.exponent
    return Measurement(
        {
            "share irregular for 1e5": irregular.low,
            "median lifetime": float(np.median(runs.lifetime)),
            "exponent": exponent,
        },
        {"exponent": error},
        runs.settled.size,
        checks={
            "stays irregular": decided(_half, irregular),
            "exponent above zero": runs.exponent_above_zero,
        },
        note=runs.words,
    )


@claim("bifurcation-sigma0")
def bifurcation_sigma0(evidence):
    """Chaotic bands and periodic windows for u <= 15."""
    runs = _motions(evidence, N_BLOCKS, *evidence.claim.parameters["belt_velocity"])
    chaotic, periodic = runs.share(CHAOTIC), runs.share(PERIODIC)
    return Measurement(
        {"chaotic share": chaotic.low, "periodic share": periodic.low},
        sample_size=runs.names.size,
        checks={
            "chaotic bands": decided(_half, chaotic),
            "periodic windows": decided(lambda share: share > 0, periodic),
        },
        note=runs.words,
    )


@claim("no-permanent-chaos")
def no_permanent_chaos(evidence):
    """Share of runs in 18 <= u <= 50 that are chaotic."""
    runs = _motions(evidence, N_BLOCKS, *evidence.claim.parameters["belt_velocity"])
    chaotic = runs.share(CHAOTIC)

    def measured(share):
        error = np.sqrt(share * (1 - share) / chaotic.total)
        return Measurement(share, error, chaotic.total, note=runs.words)

    criterion, paper = evidence.claim.criterion, evidence.claim.paper
    decided(lambda share: judge(criterion, paper, measured(share))[0], chaotic)
    return measured(chaotic.low)


@claim("transient-lifetime")
def transient_lifetime(evidence):
    """Mean lifetimes against u: until the motion settles, or the last block slips for good."""
    settles = {
        f"until the motion settles, starts spread by {spread:g}": partial(
            _mean_lifetimes, evidence, "survival", "settled", initial_spread=spread
        )
        for spread in evidence.claim.parameters["initial_spread"]
    }
    escapes = partial(_mean_lifetimes, evidence, "lifetimes", "escaped")
    return settles | {"until the last block slips for good, the paper's scheme": escapes}


def _mean_lifetimes(evidence, name, ended, **where):
    arrays, attributes = evidence.runs(name, n_blocks=N_BLOCKS, **where)
    own = _between(arrays["belt_velocity"], *evidence.claim.parameters["belt_velocity"])
    runs = {"belt_velocity": arrays["belt_velocity"], "lifetime": arrays["lifetime"]}
    runs["escaped"] = arrays[ended]
    duration = float(attributes["duration"])
    table = lifetimes.by_belt_velocity(sections.select(runs, own), duration)
    velocity, tau, error = table["belt_velocity"], table["tau"], table["tau_error"]
    known = np.isfinite(tau)
    require(known.sum() >= 5, f"lifetimes at {known.sum()} belt velocities, 5 are needed")
    fewest = table["members"].min()
    require(fewest >= MINIMUM_RUNS, f"{fewest} runs at a belt velocity, {MINIMUM_RUNS} are needed")
    # of so many runs fewer than three ended: if they were given up after 1e4, it is longer
    require(known.all() or duration >= 1e4, f"{(~known).sum()} lifetimes need longer runs")
    near, far = known & (velocity <= 21), known & (velocity >= 30)
    require(near.any() and far.any(), "no lifetimes on one side of the range 18 <= u <= 35")
    rank = rank_correlation(velocity[known], tau[known])
    longest = int(np.nanargmax(tau))
    sides = {"tau, u = 18 to 21": near, "tau, u = 30 to 35": far}
    return Measurement(
        {side: float(tau[part].mean()) for side, part in sides.items()}
        | {"rank correlation": rank},
        {side: float(np.hypot.reduce(error[part]) / part.sum()) for side, part in sides.items()},
        int(table["members"].sum()),
        checks={
            "grows towards the transition": bool(tau[near].mean() >= 3 * tau[far].mean()),
            "falls with u": rank < -0.5,
            "tau below 1e4": bool(known.all() and (tau < 1e4).all()),
        },
        note=f"longest {tau[longest]:.3g} at u = {velocity[longest]:g}",
    )


# --- other numbers of blocks ----------------------------------------------------------------------


@claim("small-n-regular")
def small_n_regular(evidence):
    """Chaotic runs and transitions of two, three and four blocks."""
    values, checks, size = {}, {}, 0
    for n_blocks in evidence.claim.parameters["n_blocks"]:
        chaotic = _motions(evidence, n_blocks).share(CHAOTIC)
        fall = evidence.row(n_blocks, 0.0).transition
        values[f"N = {n_blocks}, chaotic share"] = chaotic.low
        checks |= {
            f"N = {n_blocks} is regular": decided(lambda share: share < REGULAR_SHARE, chaotic),
            f"N = {n_blocks} has no transition": not (fall.found and fall.error < 2),
        }
        size += chaotic.total
    return Measurement(values, sample_size=size, checks=checks)


@claim("chaos-from-n5")
def chaos_from_n5(evidence):
    """Chaos and periodic motion below the transition, and its width, for five and more blocks."""
    chaotic, periodic, widths = {}, {}, {}
    for n_blocks in CHAOTIC_SIZES:
        fall = evidence.row(n_blocks, 0.0).transition
        runs = _motions(evidence, n_blocks, high=fall.lower if fall.found else 15.0)
        chaotic[n_blocks], periodic[n_blocks] = runs.share(CHAOTIC), runs.share(PERIODIC)
        if fall.found:
            widths[n_blocks] = fall.width
    require(len(widths) >= 3, f"a transition is found for {len(widths)} numbers of blocks, not 3")

    def falls(*shares):
        return rank_correlation(CHAOTIC_SIZES, shares) < -0.5

    return Measurement(
        {f"N = {n}, chaotic share": share.low for n, share in chaotic.items()}
        | {f"N = {n}, periodic share": share.low for n, share in periodic.items()}
        | {f"N = {n}, width": width for n, width in widths.items()},
        sample_size=sum(share.total for share in chaotic.values()),
        checks={f"chaos dominates, N = {n}": decided(_half, chaotic[n]) for n in CHAOTIC_SIZES}
        | {
            "fewer windows with N": decided(falls, *periodic.values()),
            "wider transition with N": rank_correlation(widths.keys(), widths.values()) > 0.5,
        },
    )


@claim("complexity-at-n5")
def complexity_at_n5(evidence):
    """Entropy of the motions over u, against the number of blocks."""
    return {
        "sigma = 0, motions by exponent and recurrence": partial(_richest, evidence, _of_motions),
        "sigma = 1, states by the look of the section": partial(_richest, evidence, _of_states),
    }


def _richest(evidence, entropy_of):
    found = {n_blocks: entropy_of(evidence, n_blocks) for n_blocks in SMALL_SIZES + CHAOTIC_SIZES}
    entropy = {n_blocks: bits for n_blocks, (bits, _) in found.items()}
    require(np.isfinite(list(entropy.values())).all(), "states could not be named for every N")
    richest = max(entropy, key=entropy.get)
    return Measurement(
        {f"N = {n}": bits for n, bits in entropy.items()},
        sample_size=sum(size for _, size in found.values()),
        checks={"richest at N = 4, 5 or 6": richest in (4, 5, 6)},
        note=f"entropy in bits; largest at N = {richest}",
    )


def _of_motions(evidence, n_blocks):
    """Entropy in bits, and number of runs."""
    names = _motions(evidence, n_blocks, 1, 50).names
    return float(stats.entropy(np.unique(names, return_counts=True)[1], base=2)), names.size


def _of_states(evidence, n_blocks):
    row = evidence.row(n_blocks, 1.0)
    inside = row.between(1, 50)
    return states.diversity(row.states[inside]), int(inside.sum())


# --- shares of runs -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Share:
    """How many of the runs have a property, and how many more may have it in longer runs."""

    known: int
    open: int
    total: int

    @property
    def low(self) -> float:
        """The share if no open run has the property."""
        return self.known / self.total

    @property
    def high(self) -> float:
        """The share if all open runs have it."""
        return (self.known + self.open) / self.total


def decided(check: Callable, *shares: Share):
    """check(*shares), if it comes out alike whether the open runs have the property or not."""
    found = [check(*values) for values in product(*((share.low, share.high) for share in shares))]
    known, unknown, total = (
        ", ".join(str(getattr(share, name)) for share in shares)
        for name in ("known", "open", "total")
    )
    require(
        all(each == found[0] for each in found),
        f"{known} of {total} runs, {unknown} more are open and decide: longer runs are needed",
    )
    return found[0]


def _half(share):
    return share >= 0.5


@dataclass(frozen=True)
class Motions:
    """What runs of `motion_map` were found to do."""

    names: np.ndarray
    duration: float

    def share(self, name: str) -> Share:
        """Share of the runs with a motion of this name."""
        seen_too_short = (TRANSIENT,) if self.duration >= LONG else (TRANSIENT, CHAOTIC)
        is_open = np.isin(self.names, seen_too_short)
        known = (self.names == name) & ~is_open
        return Share(int(known.sum()), int(is_open.sum()), self.names.size)

    @property
    def words(self) -> str:
        """How many runs have each name."""
        counts = zip(*np.unique(self.names, return_counts=True), strict=True)
        return ", ".join(f"{count} {name}" for name, count in counts)


def _motions(evidence, n_blocks, low=0.0, high=np.inf):
    """The runs of so many blocks with low <= u <= high."""
    arrays, attributes = evidence.runs("motion_map", n_blocks=n_blocks)
    names = arrays["state"][_between(arrays["belt_velocity"], low, high)].astype(str)
    place = f"with N = {n_blocks}, {low:g} <= u <= {high:g}"
    require(names.size >= MINIMUM_RUNS, f"{names.size} runs {place}, {MINIMUM_RUNS} are needed")
    return Motions(names, float(attributes["duration"]))


def _between(velocity, low, high):
    return (velocity >= low - 1e-9) & (velocity <= high + 1e-9)


@dataclass(frozen=True)
class Settling:
    """Runs from random starts at one point that were followed until they settled, or given up."""

    lifetime: np.ndarray
    settled: np.ndarray
    state: np.ndarray
    exponents: np.ndarray  # of the irregular motion; NaN where it was too short
    duration: float

    def irregular_for(self, time: float) -> Share:
        """Share of the runs that are irregular for a time or longer."""
        known = self.lifetime >= time
        return Share(int(known.sum()), int(np.sum(~known & ~self.settled)), known.size)

    @property
    def periodic(self) -> Share:
        """Share of the runs that end on a periodic orbit, of those not irregular for LONG."""
        known = self.state == PERIODIC
        is_open = ~self.settled & (self.lifetime < LONG)
        return Share(int(known.sum()), int(is_open.sum()), known.size)

    @property
    def exponent(self) -> tuple[float, float]:
        """Mean largest exponent of the irregular motion over the runs, and its standard error.

        NaN if all settled too soon for an exponent.
        """
        known = self.exponents[np.isfinite(self.exponents)]
        if known.size >= MINIMUM_EXPONENTS:
            return float(known.mean()), float(stats.sem(known))
        require(self.settled.all(), f"{self.words}: longer runs are needed for an exponent")
        return np.nan, np.nan

    @property
    def exponent_above_zero(self) -> bool:
        """Whether there is an exponent, and it is above zero by three standard errors."""
        exponent, error = self.exponent
        return exponent > ERRORS * error

    @property
    def words(self) -> str:
        """How many runs settled."""
        return f"{self.settled.sum()} of {self.settled.size} runs settled within {self.duration:g}"


def _by_spread(evidence, measure):
    """A reading for each spread of the starts."""
    parameters = evidence.claim.parameters
    return {
        f"starts spread by {spread:g}": lambda spread=spread: measure(
            _runs_from(evidence, parameters["belt_velocity"], spread)
        )
        for spread in parameters["initial_spread"]
    }


def _runs_from(evidence, belt_velocity, spread):
    """Runs of five blocks from starts with this spread."""
    arrays, attributes = evidence.runs(
        *SETTLING, n_blocks=N_BLOCKS, belt_velocity=belt_velocity, initial_spread=spread
    )
    size = arrays["settled"].size
    place = f"at u = {belt_velocity:g} from starts spread by {spread:g}"
    require(size >= MINIMUM_RUNS, f"{size} runs {place}, {MINIMUM_RUNS} are needed")
    return Settling(
        arrays["lifetime"],
        arrays["settled"].astype(bool),
        arrays["state"].astype(str),
        arrays["irregular_exponent"],
        float(attributes["duration"]),
    )

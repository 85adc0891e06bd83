"""Claims on other numbers of blocks: transition, motion, effect of noise (Sec. V)."""

from itertools import pairwise

import numpy as np
import pandas as pd

from beltrepro.base.errors import require
from beltrepro.replication.studies.sizes import measure
from beltrepro.replication.verdicts import motions
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import EXACT, SCHEME
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.replication.verdicts.motions import scan_of
from beltrepro.stats import transition
from beltrepro.stats.estimates import bootstrap, difference, mapped, trend
from beltrepro.stats.motion import CHAOTIC, PERIODIC
from beltrepro.stats.places import PART, over_places, part_of

# --- the transition -------------------------------------------------------------------------------


def _fall_of_row(evidence, n_blocks, noise):
    """The fall of r in a row from the declared start, up to where r rises again."""
    row = evidence.row(scan_of(n_blocks, "density"), n_blocks, noise)
    row = row.within(*evidence.claim.parameters["rows"][n_blocks])
    middle = part_of(row.belt_velocity) - PART / 2  # of points that count as runs at one place
    return transition.fall(middle, row.disorder)


def _runs(evidence, n_blocks, noise):
    """The row with independent runs at each point."""
    return evidence.row(scan_of(n_blocks, "replicates"), n_blocks, noise)


def _fall_of_runs(evidence, n_blocks, noise):
    return _runs(evidence, n_blocks, noise).fall


@claim("transition-width", {"one run at each u": _fall_of_row, "independent runs": _fall_of_runs})
def transition_width(evidence, fall_of):
    """Transition regions at sigma = 1 for N = 5, 7 and 10."""
    falls = {n: fall_of(evidence, n, 1.0) for n in map(int, evidence.claim.paper)}
    middles = {f"middle, N = {n}": fall["critical"] for n, fall in falls.items()}
    edges = {
        f"{side}, N = {n}": fall[side] for n, fall in falls.items() for side in ("lower", "upper")
    }
    wider = [_wider(falls, more, less) for less, more in pairwise(falls)]
    return Measurement(middles | dict(wider), edges | _widths(falls))


@claim("sharpest-at-n5", {"sigma = 1": (1.0, _fall_of_row), "sigma = 0": (0.0, _fall_of_runs)})
def sharpest_at_n5(evidence, noise_and_runs):
    """Widths of the transition of six, seven and ten blocks, less that of five."""
    (noise, fall_of), sizes = noise_and_runs, evidence.claim.parameters["n_blocks"]
    falls = {n: fall_of(evidence, n, noise) for n in (motions.N_BLOCKS, *sizes)}
    return Measurement(dict(_wider(falls, n, motions.N_BLOCKS) for n in sizes), _widths(falls))


def _widths(falls):
    return {f"width, N = {n}": fall["width"] for n, fall in falls.items()}


def _wider(falls, more, less):
    """By how much the transition of some blocks is wider than that of others, with its name."""
    return f"width, N = {more} minus N = {less}", difference(
        falls[more]["width"], falls[less]["width"]
    )


@claim("n10-intermittency", {SCHEME: "size_rows", EXACT: "size_replicates"})
def n10_intermittency(evidence, scan):
    """Laminar phases of ten blocks without noise in the transition, and whether they last."""
    runs = evidence.row(scan, 10, 0.0)
    return measure.intermittency(runs.within(*evidence.claim.parameters["belt_velocity"]))


# --- chaos ----------------------------------------------------------------------------------------


def _row_of_scheme(evidence, n_blocks):
    row = evidence.row("size_rows", n_blocks, 0.0)
    return row.belt_velocity, row.disorder


def _row_of_motions(evidence, n_blocks):
    arrays, _ = evidence.runs("motion_map", n_blocks=n_blocks)
    return arrays["belt_velocity"], arrays["disorder_parameter"]


R_OF_U = {
    "r by the paper's scheme": _row_of_scheme,
    "r by the exact dynamics": _row_of_motions,
}


@claim("small-n-regular", R_OF_U)
def small_n_regular(evidence, row_of):
    """Chaotic runs of two, three and four blocks, and how far r falls along u."""
    sizes = evidence.claim.parameters["n_blocks"]
    runs = {n: motions.runs(evidence, n) for n in sizes}
    together = pd.concat(runs.values())
    contrast = {f"contrast, N = {n}": measure.contrast(*row_of(evidence, n)) for n in sizes}
    also = {f"chaotic, N = {n}": motions.share(of_size, CHAOTIC) for n, of_size in runs.items()}
    chaotic = {"chaotic": motions.share(together, CHAOTIC)}
    return Measurement(chaotic | contrast, also, motions.in_words(together))


def _below_transition(evidence):
    """Where the fall of r without noise begins, by number of blocks; a fixed u if there is none."""
    parameters = evidence.claim.parameters
    edges = {n: _fall_of_runs(evidence, n, 0.0)["lower"].value for n in parameters["n_blocks"]}
    return {n: parameters["without_transition"] if np.isnan(u) else u for n, u in edges.items()}


@claim("chaos-from-n5", "by the look of the diagram")
def chaos_by_look(evidence):
    """Chaos and periodic motion below the transition of five and more blocks."""
    ends = _below_transition(evidence)
    made = {n: motions.looks(evidence, n, 0.0, high) for n, high in ends.items()}
    shares = {n: (looks[CHAOTIC], looks[PERIODIC]) for n, (looks, _, _) in made.items()}
    return _chaos(shares, "; ".join(words for _, _, words in made.values()))


@claim("chaos-from-n5", "by exponent and recurrence")
def chaos_by_motion(evidence):
    """The same of runs whose motion is named; of five blocks those of bifurcation-sigma0."""
    longest = {motions.N_BLOCKS: "survival_long"}
    runs = {
        n: motions.runs(evidence, n, high=high, besides=longest.get(n, ""))
        for n, high in _below_transition(evidence).items()
    }
    shares = {
        n: tuple(motions.share(of_size, motion) for motion in (CHAOTIC, PERIODIC))
        for n, of_size in runs.items()
    }
    words = (f"N = {n}: {motions.in_words(of_size)}" for n, of_size in runs.items())
    return _chaos(shares, "; ".join(words))


def _chaos(shares, note=""):
    """Of the shares of chaotic and of periodic runs by number of blocks."""
    chaotic, calm = ({n: pair[side] for n, pair in shares.items()} for side in (0, 1))
    judged = {f"chaotic, N = {n}": share for n, share in chaotic.items()}
    judged["periodic share over N"] = trend(list(calm), list(calm.values()))
    return Measurement(judged, {f"periodic, N = {n}": share for n, share in calm.items()}, note)


@claim("complexity-at-n5", "orbits told apart")
def complexity_at_n5(evidence):
    """Entropy of the motions over u, near N = 5 and elsewhere, orbits told apart."""
    return _richest(evidence, _orbits)


@claim("complexity-at-n5", "orbits, and kinds of motion")
def complexity_of_kinds(evidence):
    """The same, and that of the kinds of motion."""
    kinds = _richest(evidence, lambda runs: runs["motion"])
    judged = complexity_at_n5(evidence).judged | {"kinds of motion": kinds.judged["orbits"]}
    return Measurement(judged, kinds.also)


def _orbits(runs):
    """Motions, with orbits of different numbers of returns to the mean length told apart."""
    returns = runs["returns"].where(runs["motion"] == PERIODIC, 0)
    return runs["motion"] + returns.astype(str)


def _richest(evidence, names_of):
    near, others, ends = (
        evidence.claim.parameters[name] for name in ("near", "others", "belt_velocity")
    )
    names = {n: names_of(motions.runs(evidence, n, *ends)) for n in (*near, *others)}
    codes = {n: np.unique(of_size, return_inverse=True)[1] for n, of_size in names.items()}
    require(any(runs.any() for runs in codes.values()), "all runs of all N are alike")
    return Measurement(
        {"orbits": measure.excess(list(codes.values()), len(near))},
        {f"bits, N = {n}": bootstrap(measure.entropy, [runs]) for n, runs in codes.items()},
    )


# --- noise ----------------------------------------------------------------------------------------


@claim("r-of-sigma-size", "upper edges")
def r_of_sigma_size(evidence):
    """Rise of r with noise at the upper edge of the printed region; of six blocks there is none."""
    scan, places = evidence.dataset("size_columns").arrays, evidence.claim.parameters
    rises = {}
    for n in (*places["printed"], *places["others"]):
        velocities = scan["belt_velocity"][scan["n_blocks"] == n]
        require(velocities.size, f"size_columns has no runs of {n} blocks")
        rises[n] = measure.rise(evidence.column("size_columns", n, velocities.max()))
    others = {f"N = {n}": rises.pop(n) for n in places["others"]}
    return _weaker_with_size(rises, others | _factors(rises))


@claim("r-of-sigma-size", "beyond each fall")
def rise_beyond_each_fall(evidence):
    """By how much strong noise raises ln r about 1.1 times the velocity at which r falls."""
    places, rises = evidence.claim.parameters, {}
    for n in sorted((*places["printed"], *places["others"])):
        runs = _runs(evidence, n, 0.0)
        critical = runs.fall["critical"].value
        require(np.isfinite(critical), f"r of {n} blocks has no fall")
        ends = [share * critical for share in places["beyond"]]
        noisy = evidence.row(scan_of(n, "density"), n, places["noise"]).within(*ends)
        rises[n] = difference(*map(_mean_log_r, (noisy, runs.within(*ends))))
    return _weaker_with_size(rises, _factors(rises))


def _mean_log_r(row):
    return over_places(np.mean, row.belt_velocity, np.log(row.disorder))


def _factors(rises):
    """The factors whose logarithms the rises of r are."""
    return {f"factor, N = {n}": mapped(np.exp, rise) for n, rise in rises.items()}


EFFECTS = {"section velocities": measure.effect_on_section, "r": measure.effect_on_r}


@claim("noise-less-relevant", EFFECTS)
def noise_less_relevant(evidence, effect_of):
    """Effect of noise on the section velocities and on r, for five and more blocks."""
    places = evidence.claim.parameters
    effects = {}
    for n in places["n_blocks"]:
        pair = (_runs(evidence, n, noise) for noise in (0.0, places["noise"]))
        effects[n] = effect_of(*places["belt_velocity"], *pair)
    return _weaker_with_size(effects, {})


def _weaker_with_size(effects, also):
    """Trend over N of an effect of noise."""
    sizes = sorted(effects)
    require(any(effect.value > 0 for effect in effects.values()), "noise has no effect at any N")
    judged = {
        "slope over N": trend(sizes, [effects[n] for n in sizes]),
        "N = 5 minus N = 10": difference(effects[5], effects[10]),
    }
    return Measurement(judged, {f"N = {n}": effects[n] for n in sizes} | also)

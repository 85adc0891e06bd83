"""Claims on other numbers of blocks: transition, motion, effect of noise (Sec. V)."""

from functools import partial
from itertools import pairwise

import numpy as np

from beltrepro.base.errors import require
from beltrepro.replication.studies.chaos.measure import motions_of
from beltrepro.replication.studies.sizes import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import states
from beltrepro.stats.estimates import bootstrap, difference, share_of, trend
from beltrepro.stats.motion import CHAOTIC, PERIODIC

# --- the transition -------------------------------------------------------------------------------


@claim("transition-width")
def transition_width(evidence):
    """Transition regions at sigma = 1 for N = 5, 7 and 10."""
    falls = _falls(evidence, map(int, evidence.claim.paper), 1.0)
    middles = {f"middle, N = {n}": fall["critical"] for n, fall in falls.items()}
    wider = {
        f"width, N = {more} minus N = {less}": difference(
            falls[more]["width"], falls[less]["width"]
        )
        for less, more in pairwise(falls)
    }
    edges = {
        f"{side}, N = {n}": fall[side] for n, fall in falls.items() for side in ("lower", "upper")
    }
    return Measurement(middles | wider, edges | _widths(falls))


@claim("sharpest-at-n5")
def sharpest_at_n5(evidence):
    """Widths of the transition of six, seven and ten blocks, less that of five."""
    return {
        f"sigma = {noise:g}": partial(_wider_than_five, evidence, noise)
        for noise in evidence.claim.parameters["noise"]
    }


def _wider_than_five(evidence, noise):
    sizes = evidence.claim.parameters["n_blocks"]
    falls = _falls(evidence, (5, *sizes), noise)
    wider = {
        f"width, N = {n} minus N = 5": difference(falls[n]["width"], falls[5]["width"])
        for n in sizes
    }
    return Measurement(wider, _widths(falls))


def _falls(evidence, sizes, noise):
    return {n: evidence.replicates(n, noise).fall for n in sizes}


def _widths(falls):
    return {f"width, N = {n}": fall["width"] for n, fall in falls.items()}


@claim("n10-intermittency")
def n10_intermittency(evidence):
    """Laminar phases of ten blocks without noise in the transition, and whether they last."""
    return {
        "the paper's scheme": lambda: measure.intermittency(
            evidence.row(10, 0.0, scan="size_rows").within(
                *evidence.claim.parameters["belt_velocity"]
            )
        ),
        "exact dynamics": lambda: measure.intermittency(
            evidence.replicates(10, 0.0).within(*evidence.claim.parameters["belt_velocity"])
        ),
    }


# --- chaos ----------------------------------------------------------------------------------------


@claim("small-n-regular")
def small_n_regular(evidence):
    """Chaotic runs of two, three and four blocks, and how far r falls along u."""
    return {
        "r by the paper's scheme": partial(_small_chains, evidence, measure.row_of_scheme),
        "r by the exact dynamics": partial(_small_chains, evidence, measure.row_of_motions),
    }


def _small_chains(evidence, row_of):
    sizes = evidence.claim.parameters["n_blocks"]
    runs = {n: motions_of(evidence, n) for n in sizes}
    together, *others = runs.values()
    for more in others:
        together = together.and_also(more)
    contrast = {f"contrast, N = {n}": measure.contrast(*row_of(evidence, n)) for n in sizes}
    also = {f"chaotic, N = {n}": motion.share(CHAOTIC) for n, motion in runs.items()}
    return Measurement({"chaotic": together.share(CHAOTIC)} | contrast, also, together.words)


@claim("chaos-from-n5")
def chaos_from_n5(evidence):
    """Chaos and periodic motion below the transition of five and more blocks."""
    return {
        "by the look of the section": partial(_chaos_by_look, evidence),
        "by exponent and recurrence": partial(_chaos_by_motion, evidence),
    }


def _chaos_by_look(evidence):
    """Single runs by the paper's scheme, as the bifurcation diagrams show them."""
    shares = {}
    for n, high in measure.below_transition(evidence).items():
        row = evidence.row(n, 0.0)
        labels = row.states[row.between(0.0, high)]
        labels = labels[~np.isin(labels, (states.TRANSIENT, states.UNDECIDED))]
        require(labels.size >= 4, f"{labels.size} named runs of {n} blocks, 4 are needed")
        shares[n] = share_of(labels == states.CHAOTIC), share_of(labels == states.PERIODIC)
    return _chaos(shares)


def _chaos_by_motion(evidence):
    runs = {
        n: motions_of(evidence, n, high=u) for n, u in measure.below_transition(evidence).items()
    }
    shares = {n: (motion.share(CHAOTIC), motion.share(PERIODIC)) for n, motion in runs.items()}
    return _chaos(shares, "; ".join(f"N = {n}: {motion.words}" for n, motion in runs.items()))


def _chaos(shares, note=""):
    return Measurement(
        {f"chaotic, N = {n}": chaotic for n, (chaotic, _) in shares.items()}
        | {"periodic share over N": trend(list(shares), [calm for _, calm in shares.values()])},
        {f"periodic, N = {n}": calm for n, (_, calm) in shares.items()},
        note,
    )


@claim("complexity-at-n5")
def complexity_at_n5(evidence):
    """Entropy of the motions over u, near N = 5 and elsewhere."""
    return {
        "orbits told apart": lambda: Measurement(*_richest(evidence, measure.by_orbit)),
        "orbits, and kinds of motion": partial(_richest_in_both, evidence),
    }


def _richest_in_both(evidence):
    kinds, bits = _richest(evidence, measure.by_motion)
    orbits, _ = _richest(evidence, measure.by_orbit)
    return Measurement(orbits | {"kinds of motion": kinds["orbits"]}, bits)


def _richest(evidence, names_of):
    near, others = (evidence.claim.parameters[name] for name in ("near", "others"))
    codes = [np.unique(names_of(evidence, n), return_inverse=True)[1] for n in (*near, *others)]
    require(any(np.unique(runs).size > 1 for runs in codes), "all runs of all N are alike")

    def excess(*groups):
        bits = [measure.entropy(group) for group in groups]
        return max(bits[: len(near)]) - max(bits[len(near) :])

    bits = {
        f"bits, N = {n}": bootstrap(measure.entropy, [runs])
        for n, runs in zip((*near, *others), codes, strict=True)
    }
    return {"orbits": bootstrap(excess, codes)}, bits


# --- noise ----------------------------------------------------------------------------------------


@claim("r-of-sigma-size")
def r_of_sigma_size(evidence):
    """Rise of r with noise at the upper edge of the transition, for several N."""
    scan = evidence.dataset("size_columns").arrays
    rises = {}
    for n in evidence.claim.parameters["n_blocks"]:
        velocities = scan["belt_velocity"][scan["n_blocks"] == n]
        require(velocities.size, f"size_columns has no runs of {n} blocks")
        rises[n] = measure.rise(evidence.column("size_columns", n, velocities.max()))
    return _weaker_with_size(rises)


@claim("noise-less-relevant")
def noise_less_relevant(evidence):
    """Effect of noise on the section velocities and on r, for five and more blocks."""
    return {
        "section velocities": partial(_noise_effects, evidence, measure.effect_on_section),
        "r": partial(_noise_effects, evidence, measure.effect_on_r),
    }


def _noise_effects(evidence, effect_of):
    parameters = evidence.claim.parameters
    rows = {
        n: [evidence.replicates(n, noise) for noise in (0.0, parameters["noise"])]
        for n in parameters["n_blocks"]
    }
    low, high = parameters["belt_velocity"]
    return _weaker_with_size({n: effect_of(low, high, *pair) for n, pair in rows.items()})


def _weaker_with_size(effects):
    """Trend over N of an effect of noise."""
    sizes = sorted(effects)
    require(any(effect.value > 0 for effect in effects.values()), "noise has no effect at any N")
    judged = {
        "slope over N": trend(sizes, [effects[n] for n in sizes]),
        "N = 5 minus N = 10": difference(effects[5], effects[10]),
    }
    return Measurement(judged, {f"N = {n}": effects[n] for n in sizes})

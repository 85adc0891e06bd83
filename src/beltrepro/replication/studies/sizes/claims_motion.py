"""Claims on the motion of other numbers of blocks without noise (Sec. V): chaos and its variety."""

from functools import partial

import numpy as np
import scipy

from beltrepro.replication.studies.chaos.runs_of_motion import motions
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates, states, transitions
from beltrepro.stats.errors import require
from beltrepro.stats.motion import CHAOTIC, PERIODIC

# --- chaos ----------------------------------------------------------------------------------------


@claim("small-n-regular")
def small_n_regular(evidence):
    """Chaotic runs of two, three and four blocks, and how far r falls along u."""
    return {
        "r by the paper's scheme": partial(_small_chains, evidence, _row_of_scheme),
        "r by the exact dynamics": partial(_small_chains, evidence, _row_of_motions),
    }


def _small_chains(evidence, row_of):
    sizes = evidence.claim.parameters["n_blocks"]
    runs = {n_blocks: motions(evidence, n_blocks) for n_blocks in sizes}
    first, *others = runs.values()
    together = first
    for each in others:
        together = together.and_also(each)
    contrast = {
        f"contrast, N = {n_blocks}": estimates.bootstrap(_fall, [np.column_stack(row)])
        for n_blocks, row in ((n_blocks, row_of(evidence, n_blocks)) for n_blocks in sizes)
    }
    also = {f"chaotic, N = {n_blocks}": each.share(CHAOTIC) for n_blocks, each in runs.items()}
    return Measurement({"chaotic": together.share(CHAOTIC)} | contrast, also, together.words)


def _fall(runs: np.ndarray) -> float:
    """High over low plateau of r(u), runs (R, 2) of u and r; 1 if r falls nowhere."""
    return float(np.nan_to_num(transitions.find_fall(*runs.T, rounds=0).contrast, nan=1.0))


def _row_of_scheme(evidence, n_blocks):
    row = evidence.row(n_blocks, 0.0)
    return row.belt_velocity, row.disorder


def _row_of_motions(evidence, n_blocks):
    arrays, _ = evidence.runs("motion_map", n_blocks=n_blocks)
    return arrays["belt_velocity"], arrays["disorder_parameter"]


@claim("chaos-from-n5")
def chaos_from_n5(evidence):
    """Chaos and periodic motion below the transition, and its width, for five and more blocks."""
    parameters = evidence.claim.parameters
    chaotic, periodic, widths, words = {}, {}, {}, []
    for n_blocks in parameters["n_blocks"]:
        fall = evidence.replicates(n_blocks, 0.0).fall
        edge = fall["lower"].value
        high = parameters["without_transition"] if np.isnan(edge) else edge
        runs = motions(evidence, n_blocks, high=high)
        chaotic[n_blocks], periodic[n_blocks] = runs.share(CHAOTIC), runs.share(PERIODIC)
        widths[n_blocks] = fall["width"]
        words.append(f"N = {n_blocks}, u up to {high:.3g}: {runs.words}")
    return Measurement(
        {f"chaotic, N = {n_blocks}": share for n_blocks, share in chaotic.items()}
        | {
            "periodic share over N": estimates.trend(list(periodic), list(periodic.values())),
            "width over N": _trend_of_known(widths),
        },
        {f"periodic, N = {n_blocks}": share for n_blocks, share in periodic.items()}
        | {f"width, N = {n_blocks}": width for n_blocks, width in widths.items()},
        note="; ".join(words),
    )


def _trend_of_known(found):
    """Trend over N of what was found in enough resamples; absent with fewer than three such N."""
    known = {n: each for n, each in found.items() if np.isfinite(each.low + each.high)}
    if len(known) < 3:
        return estimates.absent(estimates.fewest(*found.values()))
    return estimates.trend(list(known), list(known.values()))


# --- variety --------------------------------------------------------------------------------------


@claim("complexity-at-n5")
def complexity_at_n5(evidence):
    """Entropy of the motions over u, near N = 5 and elsewhere."""
    return {
        "sigma = 0, motions by exponent and recurrence": partial(_richest, evidence, _by_motion),
        "sigma = 0, motions and their periods": partial(_richest, evidence, _by_period),
        "sigma = 1, states by the look of the section": partial(_richest, evidence, _by_look),
    }


def _richest(evidence, names_of):
    parameters = evidence.claim.parameters
    near, others = parameters["near"], parameters["others"]
    sizes = [*near, *others]
    codes = [np.unique(names_of(evidence, n), return_inverse=True)[1] for n in sizes]

    require(any(np.unique(own).size > 1 for own in codes), "all runs of all N are alike")

    def excess(*groups):
        bits = [_entropy(group) for group in groups]
        return max(bits[: len(near)]) - max(bits[len(near) :])

    return Measurement(
        {"near N = 5 minus elsewhere": estimates.bootstrap(excess, codes)},
        {
            f"bits, N = {n}": estimates.bootstrap(_entropy, [own])
            for n, own in zip(sizes, codes, strict=True)
        },
        note=f"{min(map(len, codes))} to {max(map(len, codes))} runs for each N",
    )


def _entropy(codes: np.ndarray) -> float:
    """Entropy in bits of the shares of codes (R,)."""
    return float(scipy.special.entr(np.bincount(codes) / codes.size).sum() / np.log(2))


def _by_motion(evidence, n_blocks):
    return motions(evidence, n_blocks, *evidence.claim.parameters["belt_velocity"]).names


def _by_period(evidence, n_blocks):
    """Motions, with orbits of different numbers of returns to the mean length told apart."""
    runs = motions(evidence, n_blocks, *evidence.claim.parameters["belt_velocity"])
    returns = np.where(runs.names == PERIODIC, runs.returns, 0)
    return np.char.add(runs.names, returns.astype(str))


def _by_look(evidence, n_blocks):
    row = evidence.row(n_blocks, 1.0)
    labels = row.states[row.between(*evidence.claim.parameters["belt_velocity"])]
    named = labels[~np.isin(labels, (states.TRANSIENT, states.UNDECIDED))]
    require(named.size, f"states could not be named for N = {n_blocks}")
    return named

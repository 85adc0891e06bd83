"""Claims on the number of blocks (Sec. V) and on the numerical method (Appendix)."""

from functools import partial

import numpy as np
from scipy import stats

from beltrepro.analysis.errors import require
from beltrepro.analysis.fits import rank_correlation
from beltrepro.claims.criteria import Measurement
from beltrepro.claims.registry import claim

CHAOTIC_SIZES = (5, 6, 7, 10)
N10_SERIES = ("n10_u28", "n10_u31", "n10_u34", "n10_u38")
MINIMUM_SERIES = 5000.0
SCANS_BY_BOTH = (
    "n5_map",
    "n5_rows",
    "n5_rows_check",
    "n5_u7",
    "n5_columns",
    "size_rows",
    "size_rows_check",
    "size_columns",
)
MINIMUM_SHARED = 24


@claim("transition-width")
def transition_width(evidence):
    """Transition regions at sigma = 1 for N = 5, 7 and 10."""
    falls = {name: evidence.row(int(name), 1.0).transition for name in evidence.claim.paper}
    widths = [fall.width for fall in falls.values()]
    return Measurement(
        {name: (fall.lower, fall.upper) for name, fall in falls.items()},
        {name: (fall.error, fall.error) for name, fall in falls.items()},
        sum(fall.n_points for fall in falls.values()),
        checks={"broadens with N": bool(np.all(np.diff(widths) > 0))},
        note="not found: the plateaus differ by less than a factor of 2"
        if not all(fall.found for fall in falls.values())
        else "",
    )


@claim("n10-intermittency")
def n10_intermittency(evidence):
    """Laminar phases of ten blocks without noise at four belt velocities."""
    velocity, share, count, mean = [], [], [], []
    for name in N10_SERIES:
        phases, length = evidence.laminar_phases(name, shortest=MINIMUM_SERIES)
        durations = np.diff(phases).ravel()
        velocity.append(float(evidence.dataset(name).attributes["belt_velocity"]))
        share.append(float(durations.sum() / length))
        count.append(durations.size)
        mean.append(float(durations.mean()) if durations.size else 0.0)
    both = [0.05 <= part <= 0.95 and n >= 2 for part, n in zip(share, count, strict=True)]
    rank = rank_correlation(velocity, mean)
    return Measurement(
        {f"u = {u:g}, laminar share": part for u, part in zip(velocity, share, strict=True)}
        | {f"u = {u:g}, mean phase": t for u, t in zip(velocity, mean, strict=True)},
        sample_size=sum(count),
        checks={
            "intermittent without noise": sum(both) >= 2,
            "laminar phases lengthen with u": rank > 0.7,
        },
        note=f"rank correlation {rank:.2g}",
    )


@claim("r-of-sigma-size")
def r_of_sigma_size(evidence):
    """Rise of r with noise at the upper edge of the transition, for several N."""
    scan = evidence.dataset("size_columns").arrays
    rises = {}
    for n_blocks in np.unique(scan["n_blocks"]):
        velocity = scan["belt_velocity"][scan["n_blocks"] == n_blocks].max()
        rises[int(n_blocks)] = evidence.column("size_columns", n_blocks, velocity).noise_transition
    require(len(rises) >= 3, f"{len(rises)} numbers of blocks, 3 are needed")
    # A curve without any rise has plateaus that are alike.
    contrast = {n: float(np.nan_to_num(rise.contrast, nan=1.0)) for n, rise in rises.items()}
    rank = rank_correlation(contrast.keys(), contrast.values())
    return Measurement(
        {f"N = {n}, ratio of plateaus": ratio for n, ratio in contrast.items()},
        sample_size=sum(rise.n_points for rise in rises.values()),
        checks={
            "weaker with N": rank < -0.7,
            "weaker at the largest N than at the smallest": contrast[max(contrast)]
            < contrast[min(contrast)],
        },
        note=f"rank correlation {rank:.2g}",
    )


@claim("noise-less-relevant")
def noise_less_relevant(evidence):
    """Effect of noise on r, for five and more blocks."""
    return {
        "r, sigma = 1": partial(_noise_effect, evidence, 1.0, _log_ratio),
        "r, sigma = 5": partial(_noise_effect, evidence, 5.0, _log_ratio),
        "section velocities, sigma = 1": partial(_noise_effect, evidence, 1.0, _velocity_distance),
    }


@claim("method-independence")
def method_independence(evidence):
    """r at points with noise that were computed with both integrators."""
    points = {"verlet": {}, "event": {}}
    for name in filter(evidence.has, SCANS_BY_BOTH):
        dataset = evidence.dataset(name)
        method = dataset.attributes["method"]
        for key, disorder in _noisy_points(dataset):
            # A scan may name one integrator for all points, or one without and one with noise.
            with_noise = "event" if "event (sigma > 0)" in method or method == "event" else "verlet"
            points[with_noise].setdefault(key, []).append(disorder)
    shared = sorted(points["verlet"].keys() & points["event"].keys())
    require(
        len(shared) >= MINIMUM_SHARED,
        f"{len(shared)} points with noise computed by both integrators, {MINIMUM_SHARED} needed",
    )
    ratio = np.array(
        [np.log(np.mean(points["event"][key]) / np.mean(points["verlet"][key])) for key in shared]
    )
    mean, error = float(ratio.mean()), float(ratio.std(ddof=1) / np.sqrt(ratio.size))
    far = float(np.mean(np.abs(ratio) > np.log(1.2)))
    return Measurement(
        {"mean ln(r_event / r_verlet)": mean, "share beyond 20 %": far},
        {"mean ln(r_event / r_verlet)": error},
        len(shared),
        checks={
            "no shift": abs(mean) <= max(3 * error, 0.03),
            "few points differ": far <= 0.1,
        },
    )


# --- shared ---------------------------------------------------------------------------------------


def _noise_effect(evidence, noise, distance):
    effect, error, size = {}, {}, 0
    for n_blocks in CHAOTIC_SIZES:
        quiet, noisy = evidence.row(n_blocks, 0.0), evidence.row(n_blocks, noise)
        at_quiet, at_noisy = _shared_velocities(quiet, noisy)
        require(len(at_quiet) >= 8, f"{len(at_quiet)} shared belt velocities at N = {n_blocks}")
        each = [distance(quiet, i, noisy, j) for i, j in zip(at_quiet, at_noisy, strict=True)]
        each = np.array(each)[np.isfinite(each)]
        require(each.size >= 8, f"too few points to compare at N = {n_blocks}")
        effect[n_blocks] = float(each.mean())
        error[n_blocks] = float(each.std(ddof=1) / np.sqrt(each.size))
        size += each.size
    rank = rank_correlation(effect.keys(), effect.values())
    return Measurement(
        {f"N = {n}": value for n, value in effect.items()},
        {f"N = {n}": value for n, value in error.items()},
        size,
        checks={
            "falls with N": rank < -0.7,
            "smaller at N = 10 than at N = 5": effect[10] < effect[5],
        },
        note=f"rank correlation {rank:.2g}",
    )


def _shared_velocities(first, second):
    _, at_first, at_second = np.intersect1d(
        np.round(first.belt_velocity, 6), np.round(second.belt_velocity, 6), return_indices=True
    )
    return at_first, at_second


def _log_ratio(quiet, i, noisy, j):
    return abs(np.log(noisy.disorder[j] / quiet.disorder[i]))


def _velocity_distance(quiet, i, noisy, j):
    """Kolmogorov-Smirnov distance of the section velocities, NaN with too few crossings."""
    pair = [cut.velocities[k] for cut, k in ((quiet, i), (noisy, j))]
    first, second = (values[np.isfinite(values)] for values in pair)
    if min(first.size, second.size) < 30:
        return np.nan
    return float(stats.ks_2samp(first, second).statistic)


def _noisy_points(dataset):
    arrays = dataset.arrays
    for index in np.flatnonzero(arrays["noise"] > 0):
        key = (
            int(arrays["n_blocks"][index]),
            round(float(arrays["belt_velocity"][index]), 6),
            round(float(arrays["noise"][index]), 6),
        )
        yield key, float(arrays["disorder_parameter"][index])

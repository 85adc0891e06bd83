"""Claims on other numbers of blocks: transition, motion, effect of noise (Sec. V)."""

from functools import partial
from itertools import pairwise

import numpy as np
import scipy

from beltrepro.base.errors import require
from beltrepro.replication.studies.chaos.runs_of_motion import motions
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import last_block_events
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import branches, estimates, intermittency, states, transitions
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.motion import CHAOTIC, PERIODIC
from beltrepro.stats.transitions import LEAST_RUNS

N10_SERIES = ("n10_u28", "n10_u31", "n10_u34", "n10_u38")
MINIMUM_SERIES = 5000.0
WEAK = {"minimum_contrast": 1.2}  # plateaus that count as different already
LAST_PART = 0.1  # of the time after the transient, in which motion that lasts still sticks


# --- width of the transition ----------------------------------------------------------------------


@claim("transition-width")
def transition_width(evidence):
    """Transition regions at sigma = 1 for N = 5, 7 and 10."""
    options = {
        "median of the runs at each u": {},
        "weak falls too": WEAK,
        "single runs from undeformed springs": None,
    }
    return {name: partial(_edges, evidence, own) for name, own in options.items()}


def _edges(evidence, options):
    falls = _falls(evidence, evidence.claim.paper, evidence.claim.parameters["noise"], options)
    edges = {
        f"{side}, N = {n}": fall[side] for n, fall in falls.items() for side in ("lower", "upper")
    }
    wider = {
        f"width, N = {more} minus N = {less}": estimates.difference(
            falls[more]["width"], falls[less]["width"]
        )
        for less, more in pairwise(falls)
    }
    return Measurement(edges | wider, _widths(falls), _missing(falls))


@claim("sharpest-at-n5")
def sharpest_at_n5(evidence):
    """Widths of the transition of six, seven and ten blocks, less that of five."""
    first, second = evidence.claim.parameters["noise"]
    return {
        f"sigma = {first:g}": partial(_wider_than_five, evidence, first, {}),
        f"sigma = {second:g}": partial(_wider_than_five, evidence, second, {}),
        f"sigma = {first:g}, weak falls too": partial(_wider_than_five, evidence, first, WEAK),
        f"sigma = {first:g}, single runs": partial(_wider_than_five, evidence, first, None),
    }


def _wider_than_five(evidence, noise, options):
    sizes = evidence.claim.parameters["n_blocks"]
    falls = _falls(evidence, (5, *sizes), noise, options)
    return Measurement(
        {
            f"width, N = {n} minus N = 5": estimates.difference(
                falls[n]["width"], falls[5]["width"]
            )
            for n in sizes
        },
        _widths(falls),
        _missing(falls),
    )


def _falls(evidence, sizes, noise, options):
    """The fall of r for each number of blocks, with options of `branches.fall`.

    None for rows of single runs, whose errors are not known.
    """
    if options is None:
        return {n: evidence.row(int(n), noise).fall for n in sizes}
    rows = {n: evidence.replicates(int(n), noise) for n in sizes}
    if not options:
        return {n: row.fall for n, row in rows.items()}
    return {n: branches.fall(row.belt_velocity, row.disorder, **options) for n, row in rows.items()}


def _widths(falls):
    return {f"width, N = {n}": fall["width"] for n, fall in falls.items()}


def _missing(falls):
    return "; ".join(
        f"N = {n}: no fall is found, its plateaus differ by a factor of {fall['contrast'].words}"
        for n, fall in falls.items()
        if np.isnan(fall["width"].value)
    )


# --- intermittency without noise ------------------------------------------------------------------


@claim("n10-intermittency")
def n10_intermittency(evidence):
    """Laminar phases of ten blocks without noise at four belt velocities, and whether they last."""
    long = evidence.claim.parameters["laminar_time"]
    return {
        "independent runs": partial(_intermittent_runs, evidence),
        "four series by the paper's scheme": partial(
            _intermittent_series, evidence, evidence.laminar_time
        ),
        f"the series, laminar from {long:g} on": partial(_intermittent_series, evidence, long),
    }


def _intermittent_runs(evidence):
    row = evidence.replicates(10, 0.0)
    places = evidence.claim.parameters["belt_velocity"]
    chosen = row.evenly(np.isclose(row.belt_velocity[:, np.newaxis], places).any(axis=1))
    groups = [chosen & row.between(place, place) for place in places]
    missing = [f"{u:g}" for u, own in zip(places, groups, strict=True) if not own.any()]
    require(not missing, f"no runs of ten blocks at u = {', '.join(missing)}")
    late = row.duration - LAST_PART * (row.duration - row.transient)
    phases = np.column_stack(
        [row.points[name] for name in ("laminar_fraction", "laminar_count", "last_stick_time")]
    )
    return _intermittency(
        places, [phases[own] for own in groups], row.duration - row.transient, late
    )


def _intermittent_series(evidence, laminar_time):
    found = [_phases_of_series(evidence, name, laminar_time) for name in N10_SERIES]
    velocities, runs, lengths, late = zip(*found, strict=True)
    return _intermittency(velocities, runs, min(lengths), min(late))


def _phases_of_series(evidence, name, laminar_time):
    """u, the run as in `_intermittency`, length after the transient, and when its end begins."""
    phases, length = evidence.laminar_phases(
        name, shortest=MINIMUM_SERIES, laminar_time=laminar_time
    )
    series = evidence.dataset(name)
    _, sticks = last_block_events(series)
    duration, last = float(series.attributes["duration"]), sticks["time"].max(initial=-np.inf)
    run = np.array([[np.diff(phases).sum() / length, len(phases), last]])
    return float(series.attributes["belt_velocity"]), run, length, duration - LAST_PART * length


def _intermittency(velocities, groups, length, late):
    """Of groups of runs (R, 3) at each u: share of time in laminar phases, number, last stick."""
    share, count, last = np.concatenate(groups).T
    mask = intermittency.intermittent_mask({"laminar_fraction": share, "laminar_count": count})
    lasting = np.nan_to_num(last, nan=-np.inf) >= late
    slope = estimates.bootstrap(partial(_slope_of_phases, velocities, length), groups)
    return Measurement(
        {
            "intermittent": estimates.share_of(mask),
            "lasts": estimates.share_of(lasting),
            "laminar phase over u": slope if count.any() else estimates.absent(slope.runs),
        },
        note="; ".join(
            f"u = {u:g}: {own[:, 0].mean():.2g} of the time laminar, "
            f"mean phase {_mean_phase(length, own):.3g}"
            for u, own in zip(velocities, groups, strict=True)
        ),
    )


def _slope_of_phases(velocities, length, *groups):
    phases = [_mean_phase(length, group) for group in groups]
    return float(np.polyfit(velocities, phases, 1)[0])


def _mean_phase(length, runs):
    """Laminar time over number of laminar phases, of all runs; 0 without one."""
    number = runs[:, 1].sum()
    return float(runs[:, 0].sum() * length / number) if number else 0.0


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


MINIMUM_VELOCITIES = 4
MINIMUM_CROSSINGS = 30
RESAMPLES = 100  # of section velocities, which are many


@claim("r-of-sigma-size")
def r_of_sigma_size(evidence):
    """Rise of r with noise at the upper edge of the transition, for several N."""
    return {
        "logarithm of the ratio of the plateaus": partial(_rises, evidence, _contrast),
        "the same over the width of the rise": partial(_rises, evidence, _steepness),
    }


def _rises(evidence, evident):
    scan = evidence.dataset("size_columns").arrays
    found = {}
    for n_blocks in evidence.claim.parameters["n_blocks"]:
        own = scan["belt_velocity"][scan["n_blocks"] == n_blocks]
        require(own.size, f"size_columns has no runs of {n_blocks} blocks")
        column = evidence.column("size_columns", n_blocks, own.max())
        levels = np.unique(column.noise)
        groups = [column.disorder[column.noise == level] for level in levels]
        found[n_blocks] = estimates.bootstrap(partial(_of_rise, evident, levels), groups)
    return _weaker_with_size(found)


def _of_rise(evident, levels, *groups):
    noise = np.repeat(levels, [len(group) for group in groups])
    return evident(transitions.find_rise(noise, np.concatenate(groups)))


def _contrast(rise):
    """ln of high over low plateau; 0 for a curve that does not rise."""
    return float(np.log(np.nan_to_num(rise.contrast, nan=1.0)))


def _steepness(rise):
    return _contrast(rise) / rise.width if rise.found and rise.width > 0 else 0.0


@claim("noise-less-relevant")
def noise_less_relevant(evidence):
    """Effect of noise on r and on the section velocities, for five and more blocks."""
    return {
        "r, the same u for all N": partial(_noise_effects, evidence, _of_r, True),
        "r, all u of each N": partial(_noise_effects, evidence, _of_r, False),
        "section velocities": partial(_noise_effects, evidence, _of_section, True),
    }


def _noise_effects(evidence, effect_of, common):
    parameters = evidence.claim.parameters
    low, high = parameters["belt_velocity"] if common else (0.0, np.inf)
    found = {}
    for n_blocks in parameters["n_blocks"]:
        quiet, noisy = (
            evidence.replicates(n_blocks, noise) for noise in (0.0, parameters["noise"])
        )
        shared = np.intersect1d(quiet.belt_velocity, noisy.belt_velocity)
        places = shared[(shared >= low) & (shared <= high)]
        require(
            places.size >= MINIMUM_VELOCITIES,
            f"{places.size} shared belt velocities at N = {n_blocks}, {MINIMUM_VELOCITIES} needed",
        )
        found[n_blocks] = effect_of(places, quiet, noisy)
    return _weaker_with_size(found)


def _of_r(places, quiet, noisy):
    """Mean square over u of the change of ln r that noise makes.

    The square of a mean over runs exceeds that of its expectation by the variance of the mean,
    which is subtracted. What is left is normal about the truth; its variance follows from those.
    """
    squares, variances = np.array([_squared_change(place, quiet, noisy) for place in places]).T
    weights = _trapezoid(places)
    value = float(weights @ squares)
    reach = float(scipy.stats.norm.ppf(0.975) * np.sqrt(weights**2 @ variances))
    return Estimate(value, value - reach, value + reach, _fewest(places, quiet, noisy))


def _squared_change(place, quiet, noisy):
    """Square of the change of the mean ln r at a place, and the variance of this estimate."""
    logs = [np.log(cut.disorder[cut.between(place, place)]) for cut in (quiet, noisy)]
    fewest = min(map(len, logs))
    require(fewest >= LEAST_RUNS, f"{fewest} runs at u = {place:g}, {LEAST_RUNS} are needed")
    error = sum(own.var(ddof=1) / own.size for own in logs)
    square = (logs[1].mean() - logs[0].mean()) ** 2 - error
    return square, 4 * max(square, 0.0) * error + 2 * error**2


def _of_section(places, quiet, noisy):
    """Mean over u of the largest distance of the distributions of v_N at the section."""
    groups, known = [], []
    for place in places:
        pair = [cut.velocities[cut.between(place, place)] for cut in (quiet, noisy)]
        if min(np.isfinite(own).sum() for own in pair) >= MINIMUM_CROSSINGS:
            known.append(place)
            groups += pair
    require(len(known) >= MINIMUM_VELOCITIES, f"section velocities at {len(known)} velocities")
    weights = _trapezoid(np.array(known))

    def distance(*samples):
        each = [_distance(*pair) for pair in zip(samples[::2], samples[1::2], strict=True)]
        return float(weights @ each)

    return estimates.bootstrap(distance, groups, resamples=RESAMPLES)


def _distance(first, second):
    """Of Kolmogorov and Smirnov; 0 where a resample has no crossing."""
    first, second = (own[np.isfinite(own)] for own in (first, second))
    if not (first.size and second.size):
        return 0.0
    # only the distance counts: the exact p, which goes unread, takes ten times as long
    return float(scipy.stats.ks_2samp(first, second, method="asymp").statistic)


def _trapezoid(places):
    """Weights (P,) of a mean over u by the trapezoidal rule."""
    gaps = np.diff(places)
    return (np.append(gaps, 0) + np.insert(gaps, 0, 0)) / (2 * gaps.sum())


def _fewest(places, *cuts):
    return min(int(cut.between(place, place).sum()) for cut in cuts for place in places)


def _weaker_with_size(found):
    """Trend over N of an effect; not found if no number of blocks shows any."""
    sizes = sorted(found)
    judged = {
        "slope over N": estimates.trend(sizes, [found[n] for n in sizes]),
        "N = 5 minus N = 10": estimates.difference(found[5], found[10]),
    }
    if not any(each.value > 0 for each in found.values()):
        judged = dict.fromkeys(judged, estimates.absent(estimates.fewest(*found.values())))
    return Measurement(judged, {f"N = {n}": found[n] for n in sizes})

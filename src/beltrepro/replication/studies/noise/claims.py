"""Claims on noise: the transition of five blocks, and intermittency (Sec. IV.B)."""

from functools import partial

import numpy as np
import scipy

from beltrepro.base.errors import require
from beltrepro.model.units import LENGTH_M, TIME_S, from_si, to_si
from beltrepro.replication.camera import recording
from beltrepro.replication.studies.experiment.lines import LEAST_PEAKS, SEGMENT_S, lines, spacing
from beltrepro.replication.studies.noise import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import branches, intermittency
from beltrepro.stats.estimates import (
    CONFIDENCE,
    Estimate,
    bootstrap,
    difference,
    exponential,
    mean,
    ratio,
    share,
    share_of,
    slope,
    sure,
)

N_BLOCKS = 5
RUNS = "n5_replicates"
# Where the runs without noise are from; those with noise are always of the first.
QUIET = {
    "one integrator": RUNS,
    "the paper's scheme at sigma = 0": "n5_replicates_check",
    "the paper's scheme at sigma = 0, wider starts": "n5_replicates_wide",
}
FINDERS = {
    "fall by 1.5 or more": {"minimum_contrast": 1.5},
}
SMALLEST_STEP = 1.3  # factor of a fall or rise that is looked for where it may be gradual
WEAKEST = 0.3  # noise at u = 7 at which the motion is still periodic
CHAOTIC = (1.0, 2.2)  # and at which it is chaotic
LEAST_SHARED = 10


def _at(table, **where):
    """Mask of the points with these values."""
    return np.all([np.isclose(table.points[name], value) for name, value in where.items()], axis=0)


def _known(found):
    """Estimates that have an interval."""
    return {
        place: each for place, each in found.items() if np.isfinite([each.low, each.high]).all()
    }


# --- Figs. 13 and 14 ------------------------------------------------------------------------------


@claim("sigma1-transition")
def sigma1_transition(evidence):
    """Transition, windows and scatter of r at sigma = 1 against sigma = 0."""
    return {name: partial(_weak_noise, evidence, scan) for name, scan in QUIET.items()}


def _weak_noise(evidence, scan):
    quiet = evidence.replicates(N_BLOCKS, 0.0, scan=scan)
    noisy = evidence.replicates(N_BLOCKS, 1.0, scan=RUNS)
    return Measurement(
        {
            "u_c(1) - u_c(0)": difference(noisy.fall["critical"], quiet.fall["critical"]),
            "windows at 1": measure.share_in_windows(noisy, noisy),
            "scatter of r, 1 over 0": _scatter_ratio(noisy, quiet),
        },
        {
            "u_c(0)": quiet.fall["critical"],
            "u_c(1)": noisy.fall["critical"],
            "windows at 0": measure.share_in_windows(quiet, noisy),
        },
    )


def _scatter_ratio(first, second):
    """Scatter of r about a straight line in 3 <= u <= 15, of one row over that of another."""
    one, other = _runs_by_velocity(first), _runs_by_velocity(second)

    def statistic(*runs):
        return _scatter(one, runs[: len(one)]) / _scatter(other, runs[len(one) :])

    return bootstrap(statistic, [*one.values(), *other.values()])


def _runs_by_velocity(row):
    """R of the runs at each u in 3 <= u <= 15."""
    inside = row.between(*measure.RANGE)
    places = np.unique(row.belt_velocity[inside])
    require(places.size >= 4, f"{places.size} belt velocities in 3 <= u <= 15, 4 are needed")
    return {float(u): row.disorder[inside & _at(row, belt_velocity=u)] for u in places}


def _scatter(places, runs):
    velocity = np.repeat(list(places), [each.size for each in runs])
    disorder = np.concatenate(runs)
    line = np.polyval(np.polyfit(velocity, disorder, 1), velocity)
    return float(np.sqrt(np.mean((disorder - line) ** 2)) / disorder.mean())


@claim("uc-of-sigma")
def uc_of_sigma(evidence):
    """Critical velocity of every noise level at which r has a transition."""
    return {name: partial(_critical_velocities, evidence, scan) for name, scan in QUIET.items()} | {
        name: partial(_critical_velocities, evidence, RUNS, **finder)
        for name, finder in FINDERS.items()
    }


def _critical_velocities(evidence, quiet, **finder):
    critical = {
        float(level): _critical(evidence, level, RUNS if level else quiet, **finder)
        for level in evidence.values(RUNS, "noise")
    }
    known = _known(critical)
    require(len(known) >= 3, f"r falls at {len(known)} of {len(critical)} noise levels, not 3")
    require({0.0, 2.2} <= critical.keys(), "no runs at sigma = 0 and 2.2")
    return Measurement(
        {
            "u_c(2.2) - u_c(0)": difference(critical[2.2], critical[0.0]),
            "slope of u_c over sigma": slope(list(known), list(known.values())),
        },
        {f"u_c({level:g})": each for level, each in critical.items()},
    )


def _critical(evidence, noise, scan, **finder):
    return _fall(evidence.replicates(N_BLOCKS, float(noise), scan=scan), **finder)["critical"]


def _fall(row, **finder):
    """The fall of r, which a row keeps for the usual finder."""
    if not finder:
        return row.fall
    return branches.fall(row.belt_velocity, row.disorder, **finder)


@claim("windows-vanish")
def windows_vanish(evidence):
    """Share of runs in periodic windows against noise."""
    rows = {name: partial(_windows_of_runs, evidence, scan) for name, scan in QUIET.items()}
    return rows | {"single runs at all u": partial(_windows_of_rows, evidence)}


def _windows_of_runs(evidence, quiet):
    levels = evidence.values(RUNS, "noise")
    rows = {
        float(level): evidence.replicates(N_BLOCKS, float(level), scan=RUNS if level else quiet)
        for level in levels
    }
    return _windows(rows)


def _windows_of_rows(evidence):
    return _windows(
        {
            float(level): evidence.row(N_BLOCKS, float(level), scan="n5_rows")
            for level in evidence.values("n5_rows", "noise")
        }
    )


def _windows(rows):
    judged = (0.0, 1.0, 2.2, 5.0)
    require(set(judged) <= rows.keys(), "no runs at sigma = 0, 1, 2.2 and 5")
    found = {level: measure.share_in_windows(row, rows[1.0]) for level, row in rows.items()}
    return Measurement(
        {f"at sigma = {level:g}": found.pop(level) for level in judged},
        {f"at sigma = {level:g}": each for level, each in found.items()},
    )


@claim("sigma-c-u7")
def sigma_c_u7(evidence):
    """Noise at which r(sigma) at u = 7 has risen half way, and the exponents on both sides."""
    return _readings_of_rises(partial(_noise_induced_chaos, evidence))


def _readings_of_rises(reading):
    return {
        "runs with noise": partial(reading, weakest=0.0),
        "with the paper's scheme at sigma = 0": partial(reading, weakest=-1.0),
    }


def _noise_induced_chaos(evidence, weakest):
    rise = _rise_of(evidence.column("n5_u7", N_BLOCKS, 7.0), weakest)
    exponents = _exponents(evidence, 7.0)
    first, *_ = exponents
    require(first <= WEAKEST, f"no exponents at sigma <= {WEAKEST:g}")
    beyond = [each for level, each in exponents.items() if CHAOTIC[0] <= level <= CHAOTIC[1]]
    require(len(beyond) > 0, "no exponents from sigma = 1 to 2.2")
    return Measurement(
        {
            "sigma_c": rise["critical"],
            "exponent at the weakest noise": exponents[first],
            "lowest exponent from sigma = 1 to 2.2": min(beyond, key=lambda each: each.low),
        },
        {"width of the rise": rise["width"], "rise of r": rise["contrast"]}
        | {f"exponent at {level:g}": each for level, each in exponents.items()},
    )


def _rise_of(column, above):
    return measure.rise(column.noise, column.disorder, above=above)


def _exponents(evidence, belt_velocity):
    """Largest exponents by noise level, the lowest first: means over the runs."""
    arrays, _ = evidence.runs("noisy_motion", n_blocks=N_BLOCKS, belt_velocity=belt_velocity)
    return {
        float(level): mean(arrays["largest_exponent"][arrays["noise"] == level])
        for level in np.unique(arrays["noise"])
    }


# --- Figs. 15 to 18 -------------------------------------------------------------------------------


@claim("r-of-sigma")
def r_of_sigma(evidence):
    """Rise of r with noise at fixed u >= 20."""
    return _readings_of_rises(partial(_rises, evidence))


def _rises(evidence, weakest):
    velocities = evidence.values("n5_columns", "belt_velocity")
    rises = {
        float(u): _rise_of(evidence.column("n5_columns", N_BLOCKS, float(u)), weakest)
        for u in velocities[velocities >= 20 - 1e-9]
    }
    critical, width = (
        _known({u: rise[name] for u, rise in rises.items()}) for name in ("critical", "width")
    )
    require(len(critical) >= 3, f"r rises in {len(critical)} of {len(rises)} columns, not 3")
    return Measurement(
        {
            "least rise": min((each["contrast"] for each in rises.values()), key=lambda e: e.value),
            "slope of sigma_c over u": slope(list(critical), list(critical.values())),
            "slope of the width over u": slope(list(width), list(width.values())),
        },
        {f"sigma_c at u = {u:g}": rise["critical"] for u, rise in rises.items()}
        | {f"width at u = {u:g}": rise["width"] for u, rise in rises.items()},
    )


@claim("uc-sigma22")
def uc_sigma22(evidence):
    """Critical velocity at sigma = 2.2, in model units and m/s."""
    return {"as everywhere": partial(_critical_in_both_units, evidence)} | {
        name: partial(_critical_in_both_units, evidence, **finder)
        for name, finder in FINDERS.items()
    }


def _critical_in_both_units(evidence, **finder):
    found = _fall(evidence.replicates(N_BLOCKS, 2.2, scan=RUNS), **finder)
    in_si = found["critical"].scaled(float(to_si(1.0, "velocity")))
    return Measurement(
        {"u_c": found["critical"]},
        {"u_c_m_s": in_si, "lower edge": found["lower"], "upper edge": found["upper"]},
    )


@claim("natural-distribution")
def natural_distribution(evidence):
    """Windows, width of the transition, and spread of v_N at four noise levels."""
    rows = {noise: evidence.replicates(N_BLOCKS, noise, scan=RUNS) for noise in (1.0, 5.0)}
    width = {
        noise: _fall(row, minimum_contrast=SMALLEST_STEP)["width"] for noise, row in rows.items()
    }
    return Measurement(
        {
            "windows at 1": measure.share_in_windows(rows[1.0], rows[1.0]),
            "width(5) - width(1)": difference(width[5.0], width[1.0]),
            "spread ratio at 0": measure.spread_ratio(evidence.row(N_BLOCKS, 0.0, scan="n5_rows")),
            "spread ratio at 10": measure.spread_ratio(
                evidence.row(N_BLOCKS, 10.0, scan="n5_rows")
            ),
        },
        {f"width({noise:g})": each for noise, each in width.items()},
    )


@claim("r-map")
def r_map(evidence):
    """Agreement of the map with independent runs, and its plateaus."""
    table = evidence.table("n5_map")
    low_u = table.belt_velocity <= 15
    high_u = (table.belt_velocity >= 25) & (table.noise <= 2)
    require(low_u.any() and high_u.any(), "the map lacks points at u <= 15 or at u >= 25")
    chaotic = {
        float(level): share_of(table.disorder[low_u & (table.noise == level)] > 0.1)
        for level in np.unique(table.noise)
    }
    distances = _distances(table, evidence.table(RUNS))
    return Measurement(
        {
            "difference from independent runs": bootstrap(np.median, [distances]),
            "r > 0.1 at u <= 15, least share": min(chaotic.values(), key=lambda each: each.value),
            "r < 0.05 at u >= 25, sigma <= 2": share_of(table.disorder[high_u] < 0.05),
        }
    )


def _distances(table, runs):
    """|ln r(map) - ln mean r(runs)| at the points with noise that both have."""
    distances = []
    for u, noise, disorder in zip(table.belt_velocity, table.noise, table.disorder, strict=True):
        own = _at(runs, belt_velocity=u, noise=noise)
        if noise > 0 and own.any():  # without noise the map is by another integrator
            distances.append(abs(np.log(disorder / runs.disorder[own].mean())))
    require(len(distances) >= LEAST_SHARED, f"{len(distances)} points shared, not {LEAST_SHARED}")
    return np.array(distances)


# --- what sigma means (Sec. III) ------------------------------------------------------------------


@claim("noise-time-step")
def noise_time_step(evidence):
    """R at equal sigma, and at equal sigma sqrt(dt), of long over short time steps."""
    table = evidence.table("noise_steps")
    short, long = 0.00025, 0.004
    return Measurement(
        {
            "equal sigma": ratio(_mean_r(table, 1.0, long), _mean_r(table, 1.0, short)),
            "equal sigma sqrt(dt)": ratio(_mean_r(table, 0.5, long), _mean_r(table, 2.0, short)),
        },
        {
            f"equal sigma = {noise:g}": ratio(
                _mean_r(table, noise, long), _mean_r(table, noise, short)
            )
            for noise in np.unique(table.noise)
        }
        | {
            f"r, sigma = {noise:g}, dt = {step:g}": _mean_r(table, noise, step)
            for noise, step in sorted(set(zip(table.noise, table.points["time_step"], strict=True)))
        },
    )


def _mean_r(table, noise, time_step):
    """Geometric mean of r over the runs, which has no interval below zero."""
    own = _at(table, noise=noise, time_step=time_step)
    require(own.any(), f"no runs with sigma = {noise:g}, dt = {time_step:g}")
    return exponential(mean(np.log(table.disorder[own])))


SERIES = "u17"
CRITICAL_SERIES = "u19"  # at the critical velocity that the paper prints for the same noise
PLACE = 17.5, 2.2  # u and sigma of Fig. 16
LIKELY = (15.0, 20.0)  # velocities at which a deterministic run could be intermittent
MINUTE = 784.0  # of the experiment, in model units
STRETCH_S = 2 * SEGMENT_S
FRAME_S = 1 / 24
SHARES = {
    "laminar share 5 % to 95 %": (0.05, 0.95),
    "laminar share 1 % to 99 %": (0.01, 0.99),
    "laminar share 10 % to 90 %": (0.10, 0.90),
}
GROUPS = ((0.0, 2.0), (2.0, 4.0), (4.0, 6.0), (6.0, 8.0))  # of sigma, without the lower end


# --- Fig. 16 --------------------------------------------------------------------------------------


@claim("intermittency")
def alternation(evidence):
    """Laminar phases at u = 17.5 and sigma = 2.2, and none without noise."""
    others = [name for name in QUIET if QUIET[name] != RUNS]
    return {
        "independent runs": partial(_in_runs, evidence, RUNS),
        **{name: partial(_in_runs, evidence, QUIET[name]) for name in others},
        "one long run": partial(_in_series, evidence, None),
        "one long run, phases longer than 784": partial(_in_series, evidence, MINUTE),
        "one long run, small amplitudes": partial(_in_amplitudes, evidence),
    }


def _in_runs(evidence, quiet):
    row = evidence.replicates(N_BLOCKS, PLACE[1], scan=RUNS)
    here = row.between(PLACE[0], PLACE[0])
    require(here.any(), f"no runs at u = {PLACE[0]:g}")
    count = row.points["laminar_count"][here]
    return Measurement(
        {
            "laminar share": mean(row.points["laminar_fraction"][here]),
            "alternating": share_of(count >= 2),
            "intermittent without noise": _without_noise(evidence, quiet),
        },
        note=_where_most(row),
    )


def _where_most(row):
    """At which u of a row most runs are intermittent, in words."""
    velocities, place = np.unique(row.belt_velocity, return_inverse=True)
    having = np.bincount(place, _lastingly_intermittent(row)) / np.bincount(place)
    most = int(having.argmax())
    if not having[most]:
        return f"no run at sigma = {PLACE[1]:g} is intermittent at any u"
    return f"most runs are intermittent at u = {velocities[most]:g}: {having[most]:.0%} of them"


def _in_series(evidence, laminar_time):
    phases, length = evidence.laminar_phases(SERIES, laminar_time=laminar_time)
    return _of_phases(evidence, phases, length, laminar_time or 0.0)


def _in_amplitudes(evidence):
    """Laminar phases as stretches of small amplitude, judged as films are."""
    run = evidence.dataset(SERIES)
    time_s = TIME_S * run.arrays["time"]
    every = max(1, round(FRAME_S / (time_s[1] - time_s[0])))
    position = LENGTH_M * run.arrays["positions"][:, -1]
    found = recording.regimes(time_s[::every], position[::every])
    return _of_phases(evidence, found.lasting_s / TIME_S, (time_s[-1] - time_s[0]) / TIME_S, 0.0)


def _of_phases(evidence, phases, length, longest):
    return Measurement(
        {
            "laminar share": measure.share_of_time(phases),
            "alternating": sure(len(phases) >= 2),
            "intermittent without noise": _without_noise(evidence, RUNS, longest=longest),
        },
        note=f"{len(phases)} laminar phases in {length:.4g}",
    )


def _without_noise(evidence, scan, *, longest=0.0):
    """Share of runs without noise that are intermittent and reach a laminar phase so long."""
    row = evidence.replicates(N_BLOCKS, 0.0, scan=scan)
    near = row.between(*LIKELY)
    require(near.any(), f"no runs at {LIKELY[0]:g} <= u <= {LIKELY[1]:g} without noise")
    having = _lastingly_intermittent(row) & (row.points["laminar_longest"] >= longest)
    return share_of(having[near])


def _lastingly_intermittent(row):
    """Which runs are intermittent and do not leave chaos for good while they are measured."""
    last_half = row.transient + 0.5 * (row.duration - row.transient)
    return intermittency.intermittent_mask(row.points) & (
        row.points["last_stick_time"] >= last_half
    )


@claim("laminar-spectra")
def laminar_spectra(evidence):
    """Spectra of laminar and of chaotic stretches at sigma = 2.2."""
    return {
        "u = 17.5 and 19": partial(_spectra_of_phases, evidence, SERIES, CRITICAL_SERIES),
        "u = 17.5 alone": partial(_spectra_of_phases, evidence, SERIES),
        "u = 19.1, as filmed": partial(_spectra_of_phases, evidence, "belt_035"),
    }


def _spectra_of_phases(evidence, *names):
    of_laminar, of_chaotic = [], []
    for name in names:
        run = evidence.dataset(name)
        phases, _ = evidence.laminar_phases(name)
        of_laminar += _spectra(run, phases)
        of_chaotic += _spectra(run, np.column_stack([phases[:-1, 1], phases[1:, 0]]))
    fewest = min(len(of_laminar), len(of_chaotic))
    require(fewest >= 2, f"{fewest} phases of {STRETCH_S:g} s or more, 2 are needed")
    regular = sum(_equally_spaced(each.peaks_hz) for each in of_laminar)
    flat, rough = (mean([each.flatness for each in found]) for found in (of_chaotic, of_laminar))
    return Measurement(
        {
            "peaks at equal distances, laminar": share(regular, len(of_laminar)),
            "flatness, chaotic": flat,
            "flatness, chaotic minus laminar": difference(flat, rough),
        },
        {
            "flatness, laminar": rough,
            "peaks at equal distances, chaotic": share(
                sum(_equally_spaced(each.peaks_hz) for each in of_chaotic), len(of_chaotic)
            ),
        },
    )


def _spectra(run, phases):
    """Lines in the middle of each phase that is long enough."""
    time, position = run.arrays["time"], run.arrays["positions"][:, -1]
    length = from_si(STRETCH_S, "time")
    middle = phases.mean(axis=1)[np.diff(phases, axis=1)[:, 0] >= length]
    interval = time[1] - time[0]
    samples = round(length / interval)
    begin = np.searchsorted(time, middle - length / 2)
    return [lines(position[first : first + samples], interval * TIME_S) for first in begin]


def _equally_spaced(peaks_hz):
    return peaks_hz.size >= LEAST_PEAKS and spacing(peaks_hz).p < 0.01


# --- Fig. 18 --------------------------------------------------------------------------------------


@claim("intermittency-region")
def intermittency_region(evidence):
    """Width in u of the intermittent region against noise."""
    return {name: partial(_region, evidence, *limits) for name, limits in SHARES.items()}


def _region(evidence, low, high):
    table, quiet = evidence.table("n5_map"), evidence.replicates(N_BLOCKS, 0.0, scan=RUNS)
    mask = intermittency.intermittent_mask(table.points, low=low, high=high)
    first, second, third, _ = (_width(table, mask, group) for group in GROUPS)
    weak, strong = (
        _width(table, mask, (one[0], other[1])) for one, other in (GROUPS[:2], GROUPS[2:])
    )
    without = _lastingly_intermittent(quiet)
    return Measurement(
        {
            "intermittent at sigma = 0": share_of(without[quiet.between(0, np.inf)]),
            "width, sigma up to 4": weak,
            "width beyond 4 over width up to 4": ratio(strong, weak),
            "growth across 4 less growth below": difference(
                difference(third, first.scaled(-1)), second.scaled(2)
            ),
        },
        {
            "width, sigma beyond 4": strong,
            "width, sigma up to 2": first,
            "width, sigma 2 to 4": second,
            "width, sigma 4 to 6": third,
        },
    )


def _width(table, mask, group):
    """Number of intermittent points times their spacing in u, mean over the levels of a group.

    Each point is a run of its own, and is intermittent by chance. The levels of the group tell how
    probable that is at each u, and so the variance of the sum. To it comes that of the two edges at
    each level, which lie anywhere between two points.
    """
    own = (table.noise > group[0] + 1e-9) & (table.noise <= group[1] + 1e-9)
    levels = np.unique(table.noise[own]).size
    require(levels >= 2, f"{levels} noise levels in {group[0]:g} < sigma <= {group[1]:g}, not 2")
    velocities, place, runs = np.unique(
        table.belt_velocity[own], return_inverse=True, return_counts=True
    )
    step = float(np.median(np.diff(velocities)))
    having = np.bincount(place, mask[own].astype(float)) / runs
    by_chance = np.sum(having * (1 - having) / np.maximum(runs - 1, 1))
    error = step * np.sqrt(by_chance + 2 / (12 * levels))
    value = step * float(having.sum())
    reach = float(scipy.stats.norm.ppf((1 + CONFIDENCE) / 2)) * float(error)
    return Estimate(value, value - reach, value + reach, int(np.count_nonzero(own)))

"""Claims on how noise changes the transition of five blocks (Sec. IV.B, Figs. 13 to 15, 17, 18)."""

from dataclasses import replace
from functools import partial

import numpy as np

from beltrepro.model import units
from beltrepro.replication.studies.noise import measure
from beltrepro.replication.studies.noise.windows import RANGE, share_in_windows, spread_ratio
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import transitions
from beltrepro.stats.errors import require
from beltrepro.stats.estimates import bootstrap, difference, mean, ratio, share, slope

N_BLOCKS = 5
RUNS = "n5_replicates"
# Where the runs without noise are from; those with noise are always of the first.
QUIET = {
    "one integrator": RUNS,
    "the paper's scheme at sigma = 0": "n5_replicates_check",
    "the paper's scheme at sigma = 0, wider starts": "n5_replicates_wide",
}
FINDERS = {
    "median of r over 3 in u": {"window": 3.0},
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
            "windows at 1": share_in_windows(noisy, noisy),
            "scatter of r, 1 over 0": _scatter_ratio(noisy, quiet),
        },
        {
            "u_c(0)": quiet.fall["critical"],
            "u_c(1)": noisy.fall["critical"],
            "windows at 0": share_in_windows(quiet, noisy),
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
    places = np.unique(row.belt_velocity[row.between(*RANGE)])
    require(places.size >= 4, f"{places.size} belt velocities in 3 <= u <= 15, 4 are needed")
    return {float(u): row.disorder[_at(row, belt_velocity=u)] for u in places}


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
    return transitions.fall(row.belt_velocity, row.disorder, **finder)


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
    found = {level: share_in_windows(row, rows[1.0]) for level, row in rows.items()}
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
    in_si = found["critical"].scaled(float(units.to_si(1.0, "velocity")))
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
            "windows at 1": share_in_windows(rows[1.0], rows[1.0]),
            "width(5) - width(1)": difference(width[5.0], width[1.0]),
            "spread ratio at 0": spread_ratio(evidence.row(N_BLOCKS, 0.0, scan="n5_rows")),
            "spread ratio at 10": spread_ratio(evidence.row(N_BLOCKS, 10.0, scan="n5_rows")),
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
        float(level): _share_of(table.disorder[low_u & (table.noise == level)] > 0.1)
        for level in np.unique(table.noise)
    }
    distances = _distances(table, evidence.table(RUNS))
    return Measurement(
        {
            "difference from independent runs": bootstrap(np.median, [distances]),
            "r > 0.1 at u <= 15, least share": min(chaotic.values(), key=lambda each: each.value),
            "r < 0.05 at u >= 25, sigma <= 2": _share_of(table.disorder[high_u] < 0.05),
        }
    )


def _share_of(having):
    return share(int(np.count_nonzero(having)), having.size)


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
    found = mean(np.log(table.disorder[own]))
    value, low, high = (float(np.exp(each)) for each in (found.value, found.low, found.high))
    return replace(found, value=value, low=low, high=high)

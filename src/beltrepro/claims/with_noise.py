"""Claims on the chain of five blocks with noise (Sec. IV.B)."""

from functools import partial

import numpy as np
from scipy import stats

from beltrepro.analysis import (
    inference,
    intermittency,
    recording,
    sections,
    shares,
    transitions,
    trials,
)
from beltrepro.analysis.errors import NotEnoughDataError, require
from beltrepro.analysis.fits import rank_correlation
from beltrepro.analysis.motion import ERRORS
from beltrepro.claims.criteria import Measurement
from beltrepro.claims.registry import claim
from beltrepro.model import units

N_BLOCKS = 5
WINDOW_RANGE = (3.0, 15.0)
MINIMUM_SERIES = 5000.0
MINIMUM_RUNS = 8
MINIMUM_TRIALS = 80  # of none that agree, 5 % are excluded from 72 on
FILMED_S = 900.0  # of a film, at least
STRONGEST = 2.2  # noise up to which the motion at u = 7 is called noise-induced chaos
SHARES = {
    "laminar share 5 % to 95 %": (0.05, 0.95),
    "laminar share 1 % to 99 %": (0.01, 0.99),
    "laminar share 10 % to 90 %": (0.10, 0.90),
}


# --- Figs. 13 and 14 ------------------------------------------------------------------------------


@claim("sigma1-transition")
def sigma1_transition(evidence):
    """Transition, windows and roughness of r at sigma = 1 against sigma = 0."""
    quiet, noisy = evidence.row(N_BLOCKS, 0.0), evidence.row(N_BLOCKS, 1.0)
    fall, fall_noisy = quiet.transition, noisy.transition
    rough, rough_noisy = (
        transitions.roughness(row.belt_velocity[inside], row.disorder[inside])
        for row, inside in ((row, row.between(*WINDOW_RANGE)) for row in (quiet, noisy))
    )
    windows = _window_share(evidence, 1.0)
    return Measurement(
        {
            "u_c at 0": fall.critical,
            "u_c at 1": fall_noisy.critical,
            "roughness at 0": rough,
            "roughness at 1": rough_noisy,
            "windows at 1": windows,
        },
        {"u_c at 0": fall.error, "u_c at 1": fall_noisy.error},
        fall.n_points + fall_noisy.n_points,
        checks={
            "u_c shifts by less than 2": bool(abs(fall.critical - fall_noisy.critical) < 2),
            "no windows": windows == 0,
            "smoother r": rough_noisy < rough,
        },
    )


@claim("uc-of-sigma")
def uc_of_sigma(evidence):
    """Critical velocity of every noise level at which r has a transition."""
    return {
        "fine rows": partial(_critical_velocities, evidence, "n5_rows"),
        "map": partial(_critical_velocities, evidence, "n5_map"),
    }


@claim("windows-vanish")
def windows_vanish(evidence):
    """Share of points in periodic windows against noise."""
    levels = evidence.values("n5_rows", "noise")
    shares = {float(level): _window_share(evidence, level) for level in levels}
    require(len(shares) >= 4, f"{len(shares)} noise levels, 4 are needed")
    rank = rank_correlation(shares.keys(), shares.values())
    inside = evidence.row(N_BLOCKS, 0.0).between(*WINDOW_RANGE)
    return Measurement(
        {f"windows at {level:g}": share for level, share in shares.items()},
        sample_size=int(inside.sum()) * len(shares),
        checks={
            "windows at sigma = 0": shares[0.0] > 0,
            "none for sigma >= 1": all(s == 0 for level, s in shares.items() if level >= 1),
            "fewer with noise": rank < -0.5,
        },
        note=f"rank correlation {rank:.2g}",
    )


@claim("sigma-c-u7")
def sigma_c_u7(evidence):
    """Noise at which r(sigma) at u = 7 has risen half way, and the exponents beyond it."""
    rise = evidence.column("n5_u7", N_BLOCKS, 7.0).noise_transition
    noise, exponent, error = _exponents(evidence, 7.0)
    beyond = (noise >= rise.critical) & (noise <= STRONGEST)
    place = f"between sigma = {rise.critical:.2g} and {STRONGEST:g}"
    require(beyond.any() or not rise.found, f"no exponent {place}")
    above = exponent[beyond] > ERRORS * error[beyond]
    levels = zip(noise[beyond], exponent[beyond], error[beyond], strict=True)
    return Measurement(
        rise.critical,
        rise.error,
        rise.n_points,
        checks={"exponent above zero beyond it": bool(above.sum() > 0.5 * beyond.sum())},
        note=f"r rises from {rise.r_low:.3g} to {rise.r_high:.3g}, 10 % to 90 % of it between "
        f"{rise.lower:.2g} and {rise.upper:.2g}; largest exponents beyond: "
        + ", ".join(f"{mean:.2g} +- {own:.1g} at {level:g}" for level, mean, own in levels),
    )


# --- Fig. 15 --------------------------------------------------------------------------------------


@claim("r-of-sigma")
def r_of_sigma(evidence):
    """Rise of r with noise at fixed u >= 20."""
    velocities = evidence.values("n5_columns", "belt_velocity")
    rises = {
        float(u): evidence.column("n5_columns", N_BLOCKS, u).noise_transition
        for u in velocities[velocities >= 20 - 1e-9]
    }
    require(len(rises) >= 4, f"{len(rises)} columns with u >= 20, 4 are needed")
    found = {u: rise for u, rise in rises.items() if rise.found}
    require(len(found) >= 3, f"r rises in {len(found)} of {len(rises)} columns: too few to compare")
    critical = [rise.critical for rise in found.values()]
    rank = rank_correlation(found, critical)
    first, *others = (rise.width for rise in found.values())
    return Measurement(
        {f"sigma_c at u = {u:g}": rise.critical for u, rise in rises.items()},
        {f"sigma_c at u = {u:g}": rise.error for u, rise in rises.items()},
        sum(rise.n_points for rise in rises.values()),
        checks={
            "r rises in every column": len(found) == len(rises),
            "sigma_c grows with u": rank > 0.5,
            "sharpest at the lowest u": first < np.median(others),
        },
        note=f"rank correlation {rank:.2g}; width {first:.2g} at u = {min(found):g}, "
        f"median of the others {np.median(others):.2g}",
    )


# --- Figs. 16 to 18 -------------------------------------------------------------------------------


@claim("intermittency")
def intermittent_series(evidence):
    """Laminar phases of the series at sigma = 2.2, and none without noise."""
    phases, length = evidence.laminar_phases("u17", shortest=MINIMUM_SERIES)
    share = float(np.diff(phases).sum() / length)
    quiet = evidence.row(N_BLOCKS, 0.0)
    inside = quiet.between(15, 20)
    require(inside.sum() >= 4, f"{inside.sum()} points in 15 <= u <= 20 without noise, not 4")
    without = intermittency.intermittent_mask(sections.select(quiet.points, inside))
    return Measurement(
        {
            "laminar share": share,
            "laminar phases": len(phases),
            "intermittent points at sigma = 0": int(without.sum()),
        },
        sample_size=len(phases),
        checks={
            "two or more laminar phases": len(phases) >= 2,
            "both phases take their share": 0.05 <= share <= 0.95,
            "not without noise": not without.any(),
        },
        note=f"series of {length:g}; {inside.sum()} points without noise",
    )


@claim("uc-sigma22")
def uc_sigma22(evidence):
    """Critical velocity at sigma = 2.2, in model units and m/s."""
    fall = evidence.row(N_BLOCKS, 2.2).transition
    return Measurement(
        {"u_c": fall.critical, "u_c_m_s": float(units.to_si(fall.critical, "velocity"))},
        {"u_c": fall.error, "u_c_m_s": float(units.to_si(fall.error, "velocity"))},
        fall.n_points,
        note=f"region {fall.lower:.3g} to {fall.upper:.3g}",
    )


@claim("r-experiment")
def r_experiment(evidence):
    """Model r at the belt speeds of the experiment, for every noise level and in films."""
    levels = evidence.values("n5_rows", "noise")
    counted = [1.0, *(float(level) for level in levels if level != 1.0)]
    readings = {f"sigma = {level:g}": partial(_r_at_speeds, evidence, level) for level in counted}
    return readings | {"films, sigma = 1": partial(_r_in_films, evidence)}


@claim("natural-distribution")
def natural_distribution(evidence):
    """Windows, sharpness of the transition, and spread of v_N at four noise levels."""
    noises = evidence.claim.parameters["noise"]
    rows = {noise: evidence.row(N_BLOCKS, float(noise)) for noise in noises}
    spread = {noise: _spread_ratio(rows[noise]) for noise in (0, 10)}
    sharp, wide = rows[1].transition, rows[5].transition
    windows = _window_share(evidence, 1.0)
    return Measurement(
        {
            "windows at 1": windows,
            "width at 1": sharp.width,
            "width at 5": wide.width,
            "spread ratio at 0": spread[0],
            "spread ratio at 10": spread[10],
        },
        sample_size=sum(row.belt_velocity.size for row in rows.values()),
        checks={
            "no windows at 1": windows == 0,
            "transition at 1": sharp.found,
            "smoother at 5": sharp.found and (not wide.found or wide.width > sharp.width),
            "noise fills the plane at 10": spread[10] >= 0.5 > spread[0],
        },
        note="spread ratio: bins filled at u > 25 over bins filled at u < 15",
    )


@claim("r-map")
def r_map(evidence):
    """Agreement of the map with the rows, its plateaus, and whether intermittency is in it."""
    table = evidence.table("n5_map")
    differences = _differences_from_rows(evidence, table)
    require(len(differences) >= 10, f"{len(differences)} points shared with the rows, not 10")
    low_u = table.belt_velocity <= 15
    high_u = (table.belt_velocity >= 25) & (table.noise <= 2)
    require(low_u.any() and high_u.any(), "the map lacks points at u <= 15 or at u >= 25")
    chaotic = min(
        float(np.mean(table.disorder[low_u & (table.noise == level)] > 0.1))
        for level in np.unique(table.noise)
    )
    quiet = float(np.mean(table.disorder[high_u] < 0.05))
    mask = intermittency.intermittent_mask(table.points)
    return Measurement(
        {
            "median difference from rows": float(np.median(differences)),
            "r > 0.1 at u <= 15, least share": chaotic,
            "r < 0.05 at u >= 25, sigma <= 2": quiet,
            "intermittent share": float(mask.mean()),
        },
        sample_size=table.belt_velocity.size,
        checks={
            "agrees with the rows": bool(np.median(differences) <= 0.1),
            "chaotic at low u": chaotic > 0.5,
            "quiet at high u": quiet > 0.5,
            "some points are intermittent": bool(mask.any()),
        },
    )


@claim("intermittency-region")
def intermittency_region(evidence):
    """Width in u of the intermittent region against noise."""
    table = evidence.table("n5_map")
    return {name: partial(_region, table, *limits) for name, limits in SHARES.items()}


@claim("sigma-experiment")
def sigma_experiment(evidence):
    """Noise at which trials of the experiment's length agree with both of its recordings."""
    tolerances = (trials.TOLERANCE, trials.TOLERANCE / 2, 2 * trials.TOLERANCE)
    return {
        f"r within {tolerance:.0%}": partial(_noise_of_experiment, evidence, tolerance)
        for tolerance in tolerances
    }


# --- shared ---------------------------------------------------------------------------------------


def _exponents(evidence, belt_velocity):
    """Noise levels, mean largest exponents over the runs, and their standard errors."""
    arrays, _ = evidence.runs("noisy_motion", n_blocks=N_BLOCKS, belt_velocity=belt_velocity)
    noise = np.unique(arrays["noise"])
    values = [arrays["largest_exponent"][arrays["noise"] == level] for level in noise]
    fewest = min(each.size for each in values)
    require(fewest >= MINIMUM_RUNS, f"{fewest} runs at a noise level, {MINIMUM_RUNS} are needed")
    return noise, np.array([each.mean() for each in values]), np.array([*map(stats.sem, values)])


def _critical_velocities(evidence, scan):
    levels = [float(level) for level in evidence.values(scan, "noise")]
    require(len(levels) >= 3, f"{len(levels)} noise levels in scans/{scan}, 3 are needed")
    falls = {level: evidence.row(N_BLOCKS, level, scan=scan).transition for level in levels}
    found = {level: fall for level, fall in falls.items() if fall.found}
    require(len(found) >= 3, f"r falls at {len(found)} of {len(levels)} noise levels, 3 are needed")
    critical = np.array([fall.critical for fall in found.values()])
    errors = np.array([fall.error for fall in found.values()])
    rank = rank_correlation(found, critical)
    top = int(np.argmax(critical))
    return Measurement(
        {f"u_c at {level:g}": fall.critical for level, fall in falls.items()},
        {f"u_c at {level:g}": fall.error for level, fall in falls.items()},
        sum(fall.n_points for fall in falls.values()),
        checks={
            "increases with sigma": rank > 0.7,
            "by more than its error": bool(
                critical[top] - critical[0] > 2 * np.hypot(errors[top], errors[0])
            ),
        },
        note=f"rank correlation {rank:.2g}",
    )


def _window_share(evidence, noise):
    """Share of points in 3 <= u <= 15 whose velocities fill less than half of the usual bins."""
    reference = evidence.row(N_BLOCKS, 1.0)
    inside = reference.between(*WINDOW_RANGE)
    span = (
        float(np.nanmin(reference.velocities[inside], initial=0.0)),
        float(np.nanmax(reference.velocities[inside], initial=0.0)),
    )
    require(span[1] > span[0], "no crossings of the section at sigma = 1")
    usual = np.median(_filled(reference, inside, span))
    row = evidence.row(N_BLOCKS, float(noise))
    filled = _filled(row, row.between(*WINDOW_RANGE), span)
    return float(np.mean(filled < 0.5 * usual))


def _filled(row, inside, span):
    shares = []
    for velocities in row.velocities[inside]:
        try:
            shares.append(sections.occupied_share(velocities, range=span))
        except NotEnoughDataError:
            continue
    require(len(shares) >= 6, f"{len(shares)} points with enough crossings, 6 are needed")
    return np.array(shares)


def _spread_ratio(row):
    """Bins of v_N that the typical point fills above u = 25, relative to below u = 15."""
    span = float(np.nanmin(row.velocities)), float(np.nanmax(row.velocities))
    high = _filled(row, row.belt_velocity > 25, span)
    low = _filled(row, row.between(*WINDOW_RANGE), span)
    return float(np.median(high) / np.median(low))


def _r_at_speeds(evidence, noise):
    row = evidence.row(N_BLOCKS, noise)
    values, errors, size = {}, {}, 0
    for speed, name in zip((0.22, 0.28), ("r_022", "r_028"), strict=True):
        near = np.abs(row.belt_velocity - units.from_si(speed, "velocity")) <= 1.0
        require(near.any(), f"no point within 1 of u = {speed} m/s")
        values[name] = float(np.median(row.disorder[near]))
        errors[name] = float(np.std(row.disorder[near]) / np.sqrt(near.sum()))
        size += int(near.sum())
    return Measurement(values, errors, size, checks=_of_same_order(evidence, values))


def _r_in_films(evidence):
    """r of x_5 as tracked in films; errors from the scatter over tenths of each film."""
    values, errors, size = {}, {}, 0
    for film, name in zip(("belt_022", "belt_028"), ("r_022", "r_028"), strict=True):
        track = evidence.track(film)
        seconds = track.time_s[-1] - track.time_s[0]
        require(
            seconds >= FILMED_S, f"the film {film} has {seconds:.0f} s, {FILMED_S:g} are needed"
        )
        values[name] = recording.analyse(track.time_s, track.x_m).disorder_parameter
        tenths = [part.std() / part.mean() for part in np.array_split(track.x_m, 10)]
        errors[name] = float(np.std(tenths, ddof=1) / np.sqrt(len(tenths)))
        size += len(track.time_s)
    return Measurement(values, errors, size, checks=_of_same_order(evidence, values))


def _of_same_order(evidence, values):
    measured = evidence.claim.experiment
    same = all(0.1 < values[name] / of_paper < 10 for name, of_paper in measured.items())
    return {"same order as the experiment": same}


def _differences_from_rows(evidence, table):
    """|ln r(map) - ln r(rows)| at the points that both have."""
    rows = evidence.table("n5_rows")

    def by_point(cut):
        keys = zip(
            cut.points["n_blocks"].tolist(),
            np.round(cut.belt_velocity, 6).tolist(),
            np.round(cut.noise, 6).tolist(),
            strict=True,
        )
        return dict(zip(keys, cut.disorder.tolist(), strict=True))

    first, second = by_point(table), by_point(rows)
    return np.array([abs(np.log(first[key] / second[key])) for key in first.keys() & second.keys()])


def _widths(table, low, high):
    mask = intermittency.intermittent_mask(table.points, low=low, high=high)
    levels, u_low, u_high = intermittency.boundary(table.belt_velocity, table.noise, mask)
    spacing = np.median(np.diff(np.unique(table.belt_velocity)))
    return levels, np.nan_to_num(u_high - u_low + spacing)


def _noise_of_experiment(evidence, tolerance):
    printed = evidence.dataset("trials").arrays
    assigned = trials.assigned(printed["noise"])
    agreeing = {}
    for each in trials.EXPERIMENT:
        own = assigned & trials.at_speed(each, printed)
        runs = int(own.sum())
        require(runs >= MINIMUM_TRIALS, f"{runs} trials, {MINIMUM_TRIALS} are needed")
        agreed = own & trials.agrees(each, printed, tolerance)
        agreeing[f"{each.speed_m_s:g} m/s"] = shares.share(int(agreed.sum()), runs)
    simulated = trials.on_grid(evidence.dataset("trials_free").arrays)
    found = inference.posterior(simulated, trials.RECORDED, tolerance)
    trials.require_agreed(found)
    levels, chosen = found.levels["noise"], found.credible("noise")
    inside = trials.assigned(levels)
    posterior = float(found.marginal("noise")[inside].sum())
    return Measurement(
        {
            "sigma, 90 %": (float(levels[chosen].min()), float(levels[chosen].max())),
            "posterior of 1 to 2": posterior,
        },
        sample_size=simulated.shown.size,
        checks={f"agrees at {speed}": each.upper >= 0.05 for speed, each in agreeing.items()}
        | {
            "half of the posterior in 1 to 2": posterior >= 0.5,
            "both ends of the range excluded": not (chosen[0] or chosen[-1]),
        },
        note="printed constants, noise 1 to 2: "
        + ", ".join(
            f"{each.value:.2g} of the trials agree at {speed}, {each.lower:.2g} to {each.upper:.2g}"
            for speed, each in agreeing.items()
        )
        + f"; before the trials 1 to 2 had {inside.mean():.2g}",
    )


def _region(table, low, high):
    levels, widths = _widths(table, low, high)
    weak, strong = (levels > 0) & (levels <= 4), (levels > 4) & (levels <= 8)
    require(
        (levels == 0).any() and weak.sum() >= 3 and strong.sum() >= 3,
        "the map needs sigma = 0 and three noise levels on each side of 4",
    )
    ratio = widths[strong].mean() / widths[weak].mean() if widths[weak].any() else np.nan
    return Measurement(
        {
            "width at 0": float(widths[levels == 0][0]),
            "mean width, 0 to 4": float(widths[weak].mean()),
            "mean width, 4 to 8": float(widths[strong].mean()),
        },
        sample_size=table.belt_velocity.size,
        checks={
            "none without noise": bool(widths[levels == 0][0] == 0),
            "some with weak noise": bool(widths[weak].any()),
            "twice as wide beyond 4": bool(ratio >= 2),
        },
    )

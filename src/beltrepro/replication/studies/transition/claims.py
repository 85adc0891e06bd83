"""Claims on five blocks without noise: single motions, the fall of r, transients (Sec. IV.A)."""

from dataclasses import replace

import numpy as np

from beltrepro.base.errors import require
from beltrepro.replication.studies.transition import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import EXACT, SCHEME
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.replication.verdicts.motions import LONG, N_BLOCKS, SETTLING, between, settling
from beltrepro.stats import estimates, states
from beltrepro.stats.motion import PERIODIC
from beltrepro.stats.places import over_places, share_over

LEAST_RUNS = 4
LEAST_POINTS = 3  # of a row whose ends lie outside: steps of 0.5 leave three in 20 < u < 22


# --- Figs. 11 and 12: single belt velocities ------------------------------------------------------


@claim("u7-periodic", SETTLING)
def u7_periodic(evidence, names):
    runs = settling(evidence, names)
    return Measurement({"end in periodic stick-slip": runs.ends_periodic}, note=runs.words)


@claim("u20-transient", SCHEME)
def u20_transient(evidence):
    """How long runs at u = 20 stick now and then, and whether they stop; r of the printed start."""
    measurement = _transients(evidence, "lifetimes_wide")
    row = evidence.row("n5_rows", N_BLOCKS, 0.0)
    disorder = row.within(20, 20).disorder
    require(disorder.size == 1, f"{disorder.size} points of the row at u = 20, one is needed")
    return replace(measurement, also={"r from the declared start": estimates.sure(disorder.item())})


@claim("u20-transient", EXACT)
def u20_transient_near_rest(evidence):
    """The same of exact runs from starts near rest."""
    return _transients(evidence, "pairs_states_event", initial_spread=1.0, time_step=0.001)


def _transients(evidence, name, **where):
    """Of a run that still sticks at its end, it is open how long its transient was."""
    scan, printed = evidence.dataset(name), evidence.claim.paper
    duration, settle_time = (float(scan.attributes[key]) for key in ("duration", "settle_time"))
    require(duration >= 2 * printed, f"runs of {duration:g} cannot show lifetimes of {printed}")
    runs, _ = evidence.runs(name, n_blocks=N_BLOCKS, belt_velocity=20.0, **where)
    escaped = runs["escaped"].astype(bool)
    require(escaped.size >= LEAST_RUNS, f"{escaped.size} runs at u = 20, {LEAST_RUNS} are needed")
    slipping = states.label_ends(runs) != states.STICK_SLIP
    on_orbit = ~escaped & measure.on_shared_orbits(runs, settle_time)
    note = f"{on_orbit.sum()} of {escaped.size} runs end on stick-slip orbits that several share"
    longer = estimates.absent()
    if escaped.any():
        lifetime = runs["lifetime"][escaped]
        longer = estimates.share_of(lifetime > printed)
        times = np.round(lifetime)
        note += f"; {times.size} escape, half of them before {np.median(times):.0f}"
        note += f", at {np.unique(times).size} different times"
    slips_on = estimates.share_of(slipping, ~escaped & ~on_orbit)
    judged = {"end in continuous slip": slips_on, f"longer than {printed}, of these": longer}
    return Measurement(judged, note=note)


# --- the transition -------------------------------------------------------------------------------

# Scans with independent runs by reading; wider starts are the paper's scheme too.
RUNS = {SCHEME: "n5_replicates_check", EXACT: "n5_replicates", "wider starts": "n5_replicates_wide"}
# Ranges of u below the fall and beyond it, each without its end.
BEFORE, BESIDE, BEYOND = (14.0, 15.05), (17.5, 19.5), (19.5, 21.5)


def _row_from_declared_start(evidence):
    row = evidence.row("n5_density", N_BLOCKS, 0.0)
    return row.belt_velocity, row.disorder


def _exact_runs(evidence):
    runs = evidence.dataset("fall_orbits").arrays
    return runs["belt_velocity"], runs["disorder_parameter"]


R_OF_U = {SCHEME: _row_from_declared_start, EXACT: _exact_runs}


@claim("r-jump", R_OF_U)
def r_jump(evidence, r_of_u):
    """r below the printed region and in two ranges beyond it, of all runs there."""
    numbers, shares = {}, {}
    velocity, disorder = r_of_u(evidence)
    for words, ends in (("", BESIDE), (", 19.5 to 21.5", BEYOND)):
        place, r = _inside(velocity, disorder, *ends)
        numbers[f"r beyond the fall{words}"] = over_places(np.median, place, r)
        shares[f"small r{words}"] = share_over(place, r < states.LARGE_AMPLITUDE)
    before = over_places(np.median, *_inside(velocity, disorder, *BEFORE))
    fall = estimates.ratio(before, numbers["r beyond the fall"])
    return Measurement({"r before the fall": before, **numbers, "ratio": fall, **shares})


def _inside(velocity, values, low, high):
    """The runs with low <= u < high, of which there must be some."""
    inside = (velocity >= low - 1e-6) & (velocity < high - 1e-6)
    require(inside.sum() >= LEAST_RUNS, f"{inside.sum()} runs at {low:g} <= u < {high:g}")
    return velocity[inside], values[inside]


@claim("u-critical", RUNS)
def u_critical(evidence, scan):
    """Midpoint of the transition region without noise; of exact runs from wider starts too."""
    fall = evidence.row(scan, N_BLOCKS, 0.0).fall
    judged = {"critical": fall["critical"]}
    if scan == RUNS[EXACT]:
        wide = evidence.row(RUNS["wider starts"], N_BLOCKS, 0.0).fall
        judged["critical, wider starts"] = wide["critical"]
    return Measurement(judged, {name: fall[name] for name in ("lower", "upper")})


@claim("r-windows", R_OF_U)
def r_windows(evidence, r_of_u):
    """r beyond the transition over that before it; of exact runs r of all periodic ones below."""
    jump = r_jump(evidence, r_of_u).judged
    low = {"beyond the transition": jump["r beyond the fall"]}
    if r_of_u is R_OF_U[EXACT]:
        arrays, _ = evidence.runs("motion_map", n_blocks=N_BLOCKS)
        chosen = between(arrays["belt_velocity"], *evidence.claim.parameters["belt_velocity"])
        chosen &= arrays["state"].astype(str) == PERIODIC
        require(chosen.sum() >= LEAST_RUNS, f"{chosen.sum()} periodic runs")
        r = arrays["disorder_parameter"][chosen]
        low["periodic below"] = estimates.bootstrap(np.median, [r])
    return Measurement(
        {name: estimates.ratio(r, jump["r before the fall"]) for name, r in low.items()}
    )


@claim("outliers", SCHEME)
def outlying_points(evidence):
    """Points of large r beyond the transition in a row like the paper's, and which are irregular.

    The start is declared, so that chance has no part in them.
    """
    row = evidence.row("n5_rows", N_BLOCKS, 0.0)
    row = row.within(*evidence.claim.parameters["points"])
    require(row.disorder.size >= LEAST_POINTS, f"{row.disorder.size} points in the row")
    large = row.disorder >= states.LARGE_AMPLITUDE
    regular = np.isin(row.states, (states.PERIODIC, states.QUASI_PERIODIC, states.CONTINUOUS))
    where = ", ".join(f"{place:g}" for place in row.belt_velocity[large])
    counts = {"outliers": large.sum(), "irregular": (large & ~regular).sum()}
    return Measurement(estimates.all_sure(counts), note=f"outliers at u = {where}" if where else "")


@claim("outliers", EXACT)
def outlying_runs(evidence):
    """Shares of the runs of large r beyond the transition, and of those that settle."""
    velocity, disorder = _exact_runs(evidence)
    settled = evidence.dataset("fall_orbits").arrays["settled"].astype(bool)
    runs = np.column_stack([disorder >= states.LARGE_AMPLITUDE, settled])
    place, runs = _inside(velocity, runs, *evidence.claim.parameters["runs"])
    (large, settled), periodic = runs.T, estimates.absent()
    if large.any():
        periodic = share_over(place[large], settled[large])
    large = share_over(place, large)
    return Measurement({"runs of large r": large, "periodic": periodic})


# --- how long transients last, and what follows ---------------------------------------------------


@claim("u7-transient-chaos", SETTLING)
def u7_transient_chaos(evidence, names):
    """How long runs at u = 7 are irregular before they become periodic, and their exponent then."""
    runs, shown = settling(evidence, names), evidence.claim.parameters["irregular_for"]
    judged = {"ends periodic": runs.ends_periodic}
    judged[f"irregular for {shown}"] = runs.irregular_for(shown)
    also = {"half of the runs settle by": runs.half_life}
    if names != SETTLING[SCHEME]:  # no deviation is followed beside the scheme
        saddle = measure.saddle(runs.arrays, runs.duration, since=shown)
        judged["e-foldings"] = saddle.pop("e-foldings")
        also |= saddle
    return Measurement(judged, also, note=runs.words)


@claim("transient-lifetime", SCHEME)
def time_to_last_stick(evidence):
    """Mean time beyond the transition up to the last stick."""
    runs = measure.until_last_stick(evidence.dataset("lifetimes_wide"))
    measurement = _lifetimes(evidence, runs, runs)
    return replace(measurement, also=measurement.also | {"u of the longest": runs.longest()})


@claim("transient-lifetime", EXACT)
def time_to_settle(evidence):
    """Mean time until exact motion rests on any orbit; near the transition of a fine grid."""
    near, far = (
        measure.until_settled(evidence.dataset(name), evidence.claim.parameters["spreads"][name])
        for name in ("fall_orbits", "survival")
    )
    return _lifetimes(evidence, near, far)


def _lifetimes(evidence, near_runs, runs):
    places = evidence.claim.parameters
    near = near_runs.mean(*places["near"])
    far, everywhere = runs.mean(*places["far"]), runs.mean(*places["belt_velocity"])
    for lifetime in (near, far, everywhere):
        require(np.isfinite(lifetime.value), "longer runs are needed for a lifetime")
    judged = {"near the fall over far": estimates.ratio(near, far), "mean lifetime": everywhere}
    return Measurement(judged, {"lifetime near": near, "lifetime far": far})


@claim("continuous-slip", SCHEME)
def continuous_slip(evidence):
    """Share of the velocities, 18 <= u <= 50, at which the last block slips on."""
    row = evidence.row("n5_density", N_BLOCKS, 0.0)
    row = row.within(*evidence.claim.parameters["belt_velocity"]["18 to 50"])
    slips = row.points["laminar_fraction"] > states.LAMINAR_SHARE[1]
    return Measurement(_named("18 to 50", slips, row.duration))


@claim("continuous-slip", EXACT)
def continuous_slip_of_exact_runs(evidence):
    """The same of runs, in two ranges of u; they slip on if no stick is in the second half."""
    shares = {}
    for name, scan in {"18 to 36": "n5_replicates", "38 to 50": "n5_replicates_beyond"}.items():
        row = evidence.row(scan, N_BLOCKS, 0.0)
        row = row.within(*evidence.claim.parameters["belt_velocity"][name])
        last = np.nan_to_num(row.points["last_stick_time"], nan=-np.inf)
        shares |= _named(name, last < (row.transient + row.duration) / 2, row.duration)
    return Measurement(shares)


def _named(ends, slips, duration):
    share = estimates.share_of(slips, ~slips & (duration < LONG))
    return {f"{name}, u = {ends}": share for name in ("slips on", "most slip on")}

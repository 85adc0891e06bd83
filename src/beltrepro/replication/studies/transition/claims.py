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
    measurement = _transients(evidence, "lifetimes")
    row = evidence.row(N_BLOCKS, 0.0, scan="n5_rows")
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
    runs = _at(scan.arrays, belt_velocity=20.0, **where)
    escaped = runs["escaped"].astype(bool)
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


def _at(arrays, **where):
    chosen = np.all([np.isclose(arrays[name], value) for name, value in where.items()], axis=0)
    words = ", ".join(f"{name} = {value:g}" for name, value in where.items())
    require(chosen.sum() >= 4, f"{chosen.sum()} runs with {words}, 4 are needed")
    return {name: values[chosen] for name, values in arrays.items() if len(values) == len(chosen)}


# --- the transition -------------------------------------------------------------------------------

# Scans with independent runs by reading; wider starts are the paper's scheme too.
RUNS = {SCHEME: "n5_replicates_check", EXACT: "n5_replicates", "wider starts": "n5_replicates_wide"}


@claim("r-jump", RUNS)
def r_jump(evidence, scan):
    """The plateaus of r beside the printed transition region."""
    before, beyond, low = _sides(evidence, scan)
    plateaus = {"r_chaotic": before, "r_periodic": low}
    numbers = {name: estimates.bootstrap(np.median, [r]) for name, r in plateaus.items()}
    small = estimates.share_of(beyond < states.LARGE_AMPLITUDE)
    return Measurement(numbers | {"ratio": estimates.ratio(*numbers.values()), "small r": small})


def _sides(evidence, scan):
    """r of the runs at 12 <= u <= 15 and 18 <= u <= 21, and of those of small r, if there are."""
    row = evidence.replicates(N_BLOCKS, 0.0, scan=scan)
    before, beyond = row.within(12, 15).disorder, row.within(18, 21).disorder
    counts = f"{before.size} runs below the transition, {beyond.size} beyond it"
    require(min(before.size, beyond.size) >= LEAST_RUNS, f"{counts}, {LEAST_RUNS} are needed")
    low = beyond[beyond < states.LARGE_AMPLITUDE]  # others are on attractors of large amplitude
    return before, beyond, low if low.size >= LEAST_RUNS else beyond


@claim("u-critical", RUNS)
def u_critical(evidence, scan):
    """Midpoint of the transition region without noise; of exact runs from wider starts too."""
    fall = evidence.replicates(N_BLOCKS, 0.0, scan=scan).fall
    judged = {"critical": fall["critical"]}
    if scan == RUNS[EXACT]:
        wide = evidence.replicates(N_BLOCKS, 0.0, scan=RUNS["wider starts"]).fall
        judged["critical, wider starts"] = wide["critical"]
    return Measurement(judged, {name: fall[name] for name in ("lower", "upper")})


@claim("r-windows", SCHEME)
def r_windows(evidence):
    """r of periodic motion beyond the transition over that before it."""
    before, _, low = _sides(evidence, RUNS[SCHEME])
    return Measurement({"beyond the transition": _ratio_of_medians(low, before)})


@claim("r-windows", EXACT)
def r_windows_below(evidence):
    """The same, and r of runs that end periodic below the transition, of any period."""
    arrays, _ = evidence.runs("motion_map", n_blocks=N_BLOCKS)
    chosen = between(arrays["belt_velocity"], *evidence.claim.parameters["belt_velocity"])
    chosen &= arrays["state"].astype(str) == PERIODIC
    require(chosen.sum() >= LEAST_RUNS, f"{chosen.sum()} periodic runs, {LEAST_RUNS} are needed")
    before, _, low = _sides(evidence, RUNS[EXACT])
    return Measurement(
        {
            "beyond the transition": _ratio_of_medians(low, before),
            "periodic below": _ratio_of_medians(arrays["disorder_parameter"][chosen], before),
        }
    )


def _ratio_of_medians(*samples):
    return estimates.ratio(*(estimates.bootstrap(np.median, [runs]) for runs in samples))


@claim("outliers", SCHEME)
def outlying_points(evidence):
    """Runs of large r beyond the transition, and whether they are irregular.

    The start is declared, so that chance has no part in them.
    """
    ends = evidence.claim.parameters["points"]
    large, regular, velocity = _of_large_r(evidence, ends, LEAST_POINTS, "n5_rows")
    where = ", ".join(f"{place:g}" for place in velocity[large])
    counts = {"outliers": large.sum(), "irregular": (large & ~regular).sum()}
    return Measurement(estimates.all_sure(counts), note=f"outliers at u = {where}" if where else "")


@claim("outliers", EXACT)
def outlying_runs(evidence):
    """Shares of the runs of large r beyond the transition."""
    ends, scans = evidence.claim.parameters["runs"], ("n5_replicates", "n5_replicates_beyond")
    large, regular, _ = _of_large_r(evidence, ends, LEAST_RUNS, *scans)
    periodic = estimates.share_of(regular[large]) if large.any() else estimates.absent()
    return Measurement({"runs of large r": estimates.share_of(large), "periodic": periodic})


def _of_large_r(evidence, ends, least, *scans):
    """Which runs from u = 20 to 22 have more than half the r of chaos, which are regular, and u."""
    rows = [evidence.row(N_BLOCKS, 0.0, scan=scan) for scan in scans if evidence.has(scan)]
    rows = [row.within(*ends) for row in rows if row.between(*ends).any()]
    place = f"{ends[0]:g} <= u <= {ends[1]:g}"
    require(len(rows), f"no runs at {place} in {' or '.join(scans)}")
    disorder, look, velocity = (
        np.concatenate([getattr(row, name) for row in rows])
        for name in ("disorder", "states", "belt_velocity")
    )
    require(disorder.size >= least, f"{disorder.size} runs at {place}, {least} are needed")
    chaotic, *_ = _sides(evidence, RUNS[SCHEME])
    regular = np.isin(look, (states.PERIODIC, states.QUASI_PERIODIC, states.CONTINUOUS))
    return disorder > np.median(chaotic) / 2, regular, velocity


# --- how long transients last, and what follows ---------------------------------------------------


@claim("u7-transient-chaos", SETTLING)
def u7_transient_chaos(evidence, names):
    """How long runs at u = 7 are irregular before they become periodic, and their exponent then."""
    runs, shown = settling(evidence, names), evidence.claim.parameters["irregular_for"]
    judged = {"ends periodic": runs.ends_periodic}
    judged[f"irregular for {shown}"] = runs.irregular_for(shown)
    also = {"half of the runs settle by": runs.half_life}
    if names != SETTLING[SCHEME]:  # no deviation is followed beside the scheme
        judged["e-foldings"] = runs.e_foldings
        also["exponent"] = runs.exponent
    return Measurement(judged, also, note=runs.words)


@claim("transient-lifetime", SCHEME)
def time_to_last_stick(evidence):
    """Mean time beyond the transition up to the last stick."""
    return _lifetimes(evidence, measure.until_last_stick(evidence.dataset("lifetimes_wide")))


@claim("transient-lifetime", EXACT)
def time_to_settle(evidence):
    spread = evidence.claim.parameters["initial_spread"]
    return _lifetimes(evidence, measure.until_settled(evidence.dataset("survival"), spread))


def _lifetimes(evidence, runs):
    near, far, everywhere = (
        runs.mean(*evidence.claim.parameters[name]) for name in ("near", "far", "belt_velocity")
    )
    for lifetime in (near, far, everywhere):
        require(np.isfinite(lifetime.value), "longer runs are needed for a lifetime")
    judged = {"near over far": estimates.ratio(near, far), "tau": everywhere}
    return Measurement(judged, {"tau near": near, "tau far": far})


@claim("continuous-slip", SCHEME)
def continuous_slip(evidence):
    """Share of runs in which the last block slips on at the end, for 18 <= u <= 50."""
    return _slips_on(evidence, {"18 to 50": "n5_rows"}, start_declared=True)


@claim("continuous-slip", EXACT)
def continuous_slip_of_exact_runs(evidence):
    """The same, in two ranges of u."""
    return _slips_on(evidence, {"18 to 36": "n5_replicates", "38 to 50": "n5_replicates_beyond"})


def _slips_on(evidence, scans, *, start_declared=False):
    shares = {}
    for name, scan in scans.items():
        row = evidence.row(N_BLOCKS, 0.0, scan=scan)
        row = row.within(*evidence.claim.parameters["belt_velocity"][name])
        last = np.nan_to_num(row.points["last_stick_time"], nan=-np.inf)
        sticking = last >= (row.transient + row.duration) / 2
        unknown = sticking & (row.duration < LONG)
        share = estimates.share_of(~sticking, unknown)
        if start_declared and not unknown.any():
            share = estimates.sure(share.value)  # chance has no part in it
        shares |= {f"slips on, u = {name}": share, f"usual end, u = {name}": share}
    return Measurement(shares)

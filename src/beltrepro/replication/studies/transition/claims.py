"""Claims on five blocks without noise: single motions, the fall of r, transients (Sec. IV.A)."""

from dataclasses import replace
from functools import partial

import numpy as np

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.studies.avalanches import measure as avalanches
from beltrepro.replication.studies.chaos.runs_of_motion import LONG, N_BLOCKS, by_spread
from beltrepro.replication.studies.transition import transients
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import last_block_events
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates, sections, states, survival
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.motion import PERIODIC

STRETCHES = 20
PRINTED_LENGTH = 1e6  # of the series behind Fig. 8, if it is as long as those behind Fig. 12


# --- Fig. 8 ---------------------------------------------------------------------------------------


@claim("spectrum-exponent")
def spectrum_exponent(evidence):
    """Exponent and prefactor of the spectrum of x_N in every reading of "power spectrum"."""
    series = evidence.dataset("u1")
    law = partial(_spectral_law, series)
    return {
        "power": law,
        "amplitude, T = 1e6": partial(law, amplitude=True),
        "power, no window function": partial(law, window="boxcar"),
        "amplitude, T = 1e6, no window function": partial(law, window="boxcar", amplitude=True),
        "power, fit for 0.01 to 1": partial(law, band=(0.01, 1.0)),
        "amplitude, T = 1e6, fit for 0.01 to 1": partial(law, band=(0.01, 1.0), amplitude=True),
        "power, fit for 0.001 to 0.1": partial(law, band=(0.001, 0.1)),
        "amplitude, T = 1e6, fit for 0.001 to 0.1": partial(law, band=(0.001, 0.1), amplitude=True),
    }


def _spectral_law(series, *, amplitude=False, **how):
    """Law of the mean spectrum of the stretches of the series, which are drawn anew."""
    law = avalanches.spectral_law(series, **how)
    exponent, prefactor = law.exponent, law.prefactor
    note = f"{law.count} stretches of {law.length:.0f}"
    if amplitude:
        exponent, prefactor = exponent.scaled(0.5), _amplitude(prefactor)
    else:
        root = _amplitude(prefactor).value
        note += f"; the amplitude 2|X|/n over T = 1e6 has {exponent.value / 2:.3g} and {root:.2g}"
    return Measurement({"exponent": exponent, "prefactor": prefactor}, note=note)


def _amplitude(power):
    """2|X|/n of n samples over a time T is the root of 2 S / T."""
    values = (np.sqrt(2 * value / PRINTED_LENGTH) for value in (power.value, power.low, power.high))
    return replace(power, **dict(zip(("value", "low", "high"), map(float, values), strict=True)))


@claim("slip-velocity")
def slip_velocity(evidence):
    """Peaks of the relative velocity of the last block in its slips."""
    series = evidence.dataset("u1")
    belt_velocity, time = series.attributes["belt_velocity"], series.arrays["time"]
    relative = np.abs(series.arrays["velocities"][:, -1] - belt_velocity)
    slips, sticks = last_block_events(series)
    count = min(slips.size, sticks.size)
    begin, end = slips["time"][:count], sticks["time"][:count]
    peaks = [
        relative[first:last].max()
        for first, last in np.searchsorted(time, np.column_stack([begin, end]))
        if last > first
    ]
    per_stretch = len(peaks) // STRETCHES
    require(per_stretch >= 2, f"{len(peaks)} slips of the last block, not {2 * STRETCHES}")
    stretches = np.array(peaks[: per_stretch * STRETCHES]).reshape(STRETCHES, -1) / belt_velocity
    stuck = _largest_while_stuck(time, relative, begin, end)
    return Measurement(
        {
            "median peak |v_r| / u": estimates.bootstrap(np.median, [stretches]),
            "peaks: 95 % over 5 % quantile": estimates.bootstrap(_spread, [stretches]),
        },
        note=f"{len(peaks)} slips in {STRETCHES} stretches; |v_r| up to {stuck:.1g} while stuck",
    )


def _spread(peaks):
    return np.quantile(peaks, 0.95) / np.quantile(peaks, 0.05)


def _largest_while_stuck(time, relative, slip, stick):
    """Over the samples strictly inside, one sample away from the events."""
    margin = 1.5 * float(np.median(np.diff(time)))
    inside = np.searchsorted(time, np.column_stack([stick[:-1] + margin, slip[1:] - margin]))
    return max((relative[first:last].max() for first, last in inside if last > first), default=0.0)


# --- Figs. 11 and 12: single belt velocities ------------------------------------------------------


@claim("u7-periodic")
def u7_periodic(evidence):
    """Where runs at u = 7 end."""
    return {
        "the paper's scheme": partial(_periodic_ends, evidence, "steps", time_step=0.001),
        "exact dynamics": partial(_periodic_ends, evidence, "survival_many"),
        "run from the declared state": partial(_periodic_run, evidence),
    }


def _periodic_ends(evidence, name, **where):
    place = {"n_blocks": 5, "belt_velocity": evidence.claim.parameters["belt_velocity"]}
    runs = _at(evidence.dataset(name).arrays, initial_spread=10.0, **place, **where)
    settled = runs["settled"].astype(bool)
    periodic = settled & (runs["state"].astype(str) == PERIODIC) & (runs["period_events"] > 0)
    found = estimates.share_of(periodic, ~settled)
    return Measurement(
        {"runs that end in periodic stick-slip": found},
        note=f"{(~settled).sum()} of {settled.size} runs do not settle",
    )


def _periodic_run(evidence):
    column = evidence.column("n5_u7", 5, 7.0)
    quiet = np.flatnonzero(column.noise == 0)
    require(quiet.size, "no point without noise in n5_u7")
    first = quiet[0]
    period = sections.find_period(column.velocities[first])
    late = column.transient + 0.9 * (column.duration - column.transient)
    periodic = period > 0 and column.points["last_stick_time"][first] > late
    return Measurement(
        {"runs that end in periodic stick-slip": estimates.sure(bool(periodic))},
        note=f"no matter of chance, since the start is declared; {period} crossings in a period",
    )


@claim("u20-transient")
def u20_transient(evidence):
    """Lifetimes at u = 20: of many runs by both methods, and of the run from the declared state."""
    return {
        "many runs": partial(_transients, evidence),
        "exact dynamics": partial(_exact_transients, evidence),
        "run from the declared state": partial(_single_transient, evidence),
    }


def _transients(evidence):
    """Of a run that still sticks at its end, it is open how long its transient was."""
    runs = evidence.dataset("lifetimes")
    duration = float(runs.attributes["duration"])
    printed = evidence.claim.paper
    require(duration >= 2 * printed, f"runs of {duration:g} cannot show lifetimes of {printed}")
    own = _at(runs.arrays, belt_velocity=20.0)
    escaped = own["escaped"].astype(bool)
    slipping = transients.labels_of(own) != transients.STICK_SLIP
    on_orbit = ~escaped & transients.on_shared_orbits(own, float(runs.attributes["settle_time"]))
    beyond = escaped & (own["lifetime"] > printed)
    note = f"{escaped.sum()} of {escaped.size} runs escape"
    if escaped.any():
        lived = own["lifetime"][escaped]
        note += f", half of them before {np.median(lived):.0f}"
        note += f", at {np.unique(np.round(lived)).size} different times"
    note += f"; {on_orbit.sum()} end on stick-slip orbits that several runs share"
    return _two_shares(beyond, slipping, ~escaped, ~escaped & ~on_orbit, note)


def _exact_transients(evidence):
    """Irregular motion until it settles; small r tells continuous slip from stick-slip."""
    runs = _at(
        evidence.dataset("survival").arrays, n_blocks=5, belt_velocity=20.0, initial_spread=10.0
    )
    settled = runs["settled"].astype(bool)
    slipping = settled & (runs["disorder_parameter"] < transients.LARGE_AMPLITUDE)
    # A run that settles on a stick-slip orbit has a known transient, and one that is not settled
    # has a long one.
    beyond = runs["lifetime"] > evidence.claim.paper
    return _two_shares(beyond, slipping, ~settled & ~beyond, ~settled, "")


def _single_transient(evidence):
    series = evidence.dataset("u20")
    duration = float(series.attributes["duration"])
    _, sticks = last_block_events(series)
    end = float(sticks["time"][-1]) if sticks.size else 0.0
    left = duration - end > max(evidence.laminar_time, 0.1 * duration)
    words = f"last stick at {end:.0f} in a run of {duration:g}"
    left, beyond = np.array([left]), np.array([end > evidence.claim.paper])
    return _two_shares(beyond, left, ~left & ~beyond, ~left, words)


def _two_shares(beyond, slipping, still_open, open_ends, note):
    return Measurement(
        {
            "runs with a transient beyond 4000": estimates.share_of(beyond, still_open),
            "runs that end in continuous slip": estimates.share_of(slipping, open_ends),
        },
        note=note,
    )


# --- shared ---------------------------------------------------------------------------------------


def _at(arrays, **where):
    """Runs with these values."""
    chosen = np.all([np.isclose(arrays[name], value) for name, value in where.items()], axis=0)
    words = ", ".join(f"{name} = {value:g}" for name, value in where.items())
    require(chosen.sum() >= 4, f"{chosen.sum()} runs with {words}, 4 are needed")
    return {name: values[chosen] for name, values in arrays.items() if len(values) == len(chosen)}


PAPERS_SCHEME, EXACT, WIDE = "n5_replicates_check", "n5_replicates", "n5_replicates_wide"
ENDS = ("escaped", "final_disorder", "final_stick_rate", "final_amplitude")


# --- the transition -------------------------------------------------------------------------------


@claim("r-jump")
def r_jump(evidence):
    """Plateaus of r before and after its fall."""
    names = {"r_chaotic": "r_high", "r_periodic": "r_low", "ratio": "contrast"}
    return _readings_of_fall(evidence, names)


@claim("u-critical")
def u_critical(evidence):
    """Midpoint of the transition region without noise."""
    names = {"critical": "critical"}
    return _readings_of_fall(evidence, names, also=("lower", "upper"))


def _readings_of_fall(evidence, names, also=()):
    return {
        "the paper's scheme": partial(_fall, evidence, names, also),
        "exact dynamics": partial(_fall, evidence, names, also, scan=EXACT),
        "wider starts": partial(_fall, evidence, names, also, scan=WIDE),
        "one run at each u": partial(_fall_of_row, evidence, names, also),
    }


def _fall(evidence, names, also, *, scan=PAPERS_SCHEME):
    runs = evidence.replicates(5, 0.0, scan=scan)
    return _named(names, also, runs.fall, _side_by_side(runs, runs.fall))


def _side_by_side(runs, found):
    """Belt velocities at which some runs lie above the middle of the fall and some below."""
    middle = (found["r_high"].value + found["r_low"].value) / 2
    places, place = np.unique(runs.belt_velocity, return_inverse=True)
    share = np.bincount(place, runs.disorder > middle) / np.bincount(place)
    mixed = places[(share > 0) & (share < 1)]
    where = ", ".join(f"{u:g}" for u in mixed)
    return f"runs of high and of low r side by side at u = {where}" if where else ""


def _fall_of_row(evidence, names, also):
    return _named(names, also, evidence.row(5, 0.0, scan="n5_rows").fall)


def _named(names, also, found, note=""):
    return Measurement(
        {name: found[of] for name, of in names.items()}, {name: found[name] for name in also}, note
    )


# --- other motions --------------------------------------------------------------------------------


@claim("outliers")
def outliers(evidence):
    """Runs of large r beyond the transition, and whether they are chaotic."""
    return {
        "the paper's scheme": partial(_outliers, evidence, "n5_rows", PAPERS_SCHEME),
        "one run at each u": partial(_outliers, evidence, "n5_rows"),
        "wider starts": partial(_outliers, evidence, WIDE),
        "exact dynamics": partial(_outliers, evidence, EXACT),
        "many runs": partial(_outliers_of_many, evidence),
    }


def _outliers(evidence, *scans):
    limit = _half_plateau(evidence)
    large, regular, places = [], [], []
    for scan in scans:
        row = evidence.row(5, 0.0, scan=scan)
        inside = _between(evidence, row.belt_velocity)
        large += (row.disorder[inside] > limit).tolist()
        regular += np.isin(
            row.states[inside], (states.PERIODIC, states.QUASI_PERIODIC, states.CONTINUOUS)
        ).tolist()
        places += row.belt_velocity[inside].tolist()
    large, regular = np.array(large, dtype=bool), np.array(regular, dtype=bool)
    where = ", ".join(f"{u:g}" for u in np.unique(np.array(places)[large]))
    return _outlying(large, regular, np.zeros_like(large), f"u = {where}" if where else "")


def _outliers_of_many(evidence):
    """Runs of which only the end is known; on stick-slip orbits are those that several share."""
    runs = evidence.dataset("lifetimes")
    settle_time, limit = float(runs.attributes["settle_time"]), _half_plateau(evidence)
    velocity = runs.arrays["belt_velocity"]
    large, regular = [], []
    for place in np.unique(velocity[_between(evidence, velocity)]):
        own = sections.select({name: runs.arrays[name] for name in ENDS}, velocity == place)
        slipping = transients.labels_of(own) != transients.STICK_SLIP
        large += (own["final_disorder"] > limit).tolist()
        regular += (slipping | transients.on_shared_orbits(own, settle_time)).tolist()
    large, regular = np.array(large, dtype=bool), np.array(regular, dtype=bool)
    return _outlying(large, regular, ~regular, "other runs that still stick may be chaotic")


def _outlying(large, regular, still_open, note):
    require(large.size >= 4, f"{large.size} runs in 20 < u < 22, 4 are needed")
    count = int(large.sum())
    kept = estimates.absent()
    if count:
        kept = estimates.share_of(regular[large], still_open[large])
    return Measurement(
        {"runs of large r": estimates.share_of(large), "of these not chaotic": kept},
        note=f"{count} of {large.size} runs" + (f", {note}" if note else ""),
    )


def _half_plateau(evidence):
    return evidence.replicates(5, 0.0, scan=PAPERS_SCHEME).fall["r_high"].value / 2


def _between(evidence, belt_velocity):
    """Ends left out."""
    low, high = evidence.claim.parameters["belt_velocity"]
    return (belt_velocity > low + 1e-9) & (belt_velocity < high - 1e-9)


@claim("r-windows")
def r_windows(evidence):
    """r of periodic runs over that of chaotic ones, below the transition."""
    periodic = (states.PERIODIC,)
    row = partial(evidence.row, 5, 0.0)
    return {
        "one run at each u": partial(_window_ratio, evidence, row, "n5_rows", periodic),
        "quasi-periodic ones too": partial(
            _window_ratio, evidence, row, "n5_rows", (*periodic, states.QUASI_PERIODIC)
        ),
        "independent runs": partial(_window_ratio, evidence, row, PAPERS_SCHEME, periodic),
    }


def _window_ratio(evidence, row, scan, regular):
    found = row(scan=scan)
    inside = found.between(*evidence.claim.parameters["belt_velocity"])
    calm, chaotic = (
        found.disorder[inside & np.isin(found.states, labels)]
        for labels in (regular, (states.CHAOTIC,))
    )
    counts = f"{calm.size} periodic and {chaotic.size} chaotic runs"
    require(min(calm.size, chaotic.size) >= 3, f"{counts} at u <= 15, 3 of each are needed")
    value = estimates.bootstrap(lambda few, many: np.median(few) / np.median(many), [calm, chaotic])
    return Measurement(
        {"r periodic / r chaotic": value},
        {
            "r periodic": estimates.sure(np.median(calm)),
            "r chaotic": estimates.sure(np.median(chaotic)),
        },
        note=f"{counts}; r of the periodic ones from {calm.min():.2g} to {calm.max():.2g}",
    )


MINIMUM_VELOCITIES = 5


# --- how long they last ---------------------------------------------------------------------------


@claim("u7-transient-chaos")
def u7_transient_chaos(evidence):
    """How long runs at u = 7 are irregular before they become periodic, and their exponent then."""

    def measure(runs):
        return Measurement(
            {
                "ends periodic": runs.periodic,
                "irregular for 1000": runs.irregular_for(1000),
                "exponent": runs.exponent,
            },
            note=runs.words,
        )

    return by_spread(evidence, measure)


@claim("transient-lifetime")
def transient_lifetime(evidence):
    """Mean lifetimes against u: until the motion settles, or the last block slips for good."""
    settles = {
        f"until the motion settles, starts spread by {spread:g}": partial(
            _until_it_settles, evidence, spread
        )
        for spread in evidence.claim.parameters["initial_spread"]
    }
    slips = {"until the last block slips for good, the paper's scheme": _until_it_slips}
    return settles | {name: partial(measure, evidence) for name, measure in slips.items()}


def _until_it_settles(evidence, spread):
    return _against_velocity(
        evidence, transients.until_settled(evidence.dataset("survival"), spread)
    )


def _until_it_slips(evidence):
    return _against_velocity(evidence, transients.until_last_stick(evidence.dataset("lifetimes")))


def _against_velocity(evidence, runs):
    """tau near the transition, far from it, and everywhere."""
    parameters = evidence.claim.parameters
    velocity = runs.belt_velocity
    places = np.unique(velocity[transients.between(velocity, *parameters["belt_velocity"])])
    require(
        places.size >= MINIMUM_VELOCITIES,
        f"lifetimes at {places.size} belt velocities, {MINIMUM_VELOCITIES} are needed",
    )
    at_once = 1 - (1 - survival.CONFIDENCE) / places.size  # of the interval of the longest of all
    each = [runs.mean(place, place) for place in places]
    wide = [runs.mean(place, place, confidence=at_once) for place in places]
    unknown = sum(np.isinf(found.mean) for found in each)
    require(not unknown, f"{unknown} lifetimes need longer runs")
    near, far = (runs.mean(*parameters[name]) for name in ("near", "far"))
    longest = max(range(places.size), key=lambda index: each[index].mean)
    return Measurement(
        {
            "near over far": estimates.ratio(_estimate(near), _estimate(far)),
            "slope of ln tau": estimates.slope(places, [_estimate(own, np.log) for own in each]),
            "longest": Estimate(
                each[longest].mean,
                max(own.lower for own in wide),
                max(own.upper for own in wide),
                min(own.runs for own in wide),
            ),
        },
        {"tau near": _estimate(near), "tau far": _estimate(far)},
        note=f"the longest is at u = {places[longest]:g}",
    )


def _estimate(found: survival.MeanLifetime, scale=float) -> Estimate:
    low, value, high = (float(scale(each)) for each in (found.lower, found.mean, found.upper))
    return Estimate(value, low, high, found.runs)


# --- what they end in -----------------------------------------------------------------------------


@claim("continuous-slip")
def continuous_slip(evidence):
    """Share of runs in which the last block slips on at the end, for 18 <= u <= 50."""
    return {
        "the paper's scheme": partial(_slips_on, evidence, "n5_replicates_check", "n5_rows"),
        "exact dynamics": partial(_slips_on, evidence, "n5_replicates", "n5_rows_check"),
    }


def _slips_on(evidence, low_scan, high_scan):
    ranges = evidence.claim.parameters["belt_velocity"]
    cuts = (
        evidence.replicates(N_BLOCKS, 0.0, scan=low_scan),
        evidence.row(N_BLOCKS, 0.0, scan=high_scan),
    )
    found, large = {}, []
    for (name, limits), cut in zip(ranges.items(), cuts, strict=True):
        own = cut.between(*limits)
        require(own.any(), f"no runs for u = {name}")
        on = ~_sticks_late(cut)[own]
        unknown = 0 if cut.duration >= LONG else int((~on).sum())
        found[f"slips on, u = {name}"] = estimates.share(int(on.sum()), on.size, unknown)
        large.append((cut.disorder[own] >= transients.LARGE_AMPLITUDE)[on])
    amplitude = np.concatenate(large)
    require(amplitude.size, "no run slips on")
    also = {"large amplitude, of these": estimates.share_of(amplitude)}
    return Measurement(found, also | _high_lifetime(evidence))


def _sticks_late(cut):
    """Which runs stick in the second half of the time after the transient."""
    last = np.nan_to_num(cut.points["last_stick_time"], nan=-np.inf)
    return last >= (cut.transient + cut.duration) / 2


def _high_lifetime(evidence):
    """Mean time until the motion settles at the highest belt velocities, if there are such runs."""
    low, high = evidence.claim.parameters["high_velocity"]
    if not evidence.has("survival"):
        return {}
    try:
        found = transients.until_settled(evidence.dataset("survival")).mean(low, high)
    except NotEnoughDataError:
        return {}
    return {f"lifetime, u = {low:g} to {high:g}": _estimate(found)}

"""Claims on single motions of the deterministic chain of five blocks (Sec. IV.A)."""

from dataclasses import replace
from functools import partial

import numpy as np

from beltrepro.replication.studies.avalanches import measure as avalanches
from beltrepro.replication.studies.transition import transients
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import last_block_events
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates, sections
from beltrepro.stats.errors import require
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
    found = estimates.share(int(periodic.sum()), settled.size, int((~settled).sum()))
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
    return _two_shares(beyond, slipping, ~escaped, note, open_ends=~escaped & ~on_orbit)


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
    return _two_shares(beyond, slipping, ~settled & ~beyond, "", open_ends=~settled)


def _single_transient(evidence):
    series = evidence.dataset("u20")
    duration = float(series.attributes["duration"])
    _, sticks = last_block_events(series)
    end = float(sticks["time"][-1]) if sticks.size else 0.0
    left = duration - end > max(evidence.laminar_time, 0.1 * duration)
    words = f"last stick at {end:.0f} in a run of {duration:g}"
    left, beyond = np.array([left]), np.array([end > evidence.claim.paper])
    return _two_shares(beyond, left, ~left & ~beyond, words, open_ends=~left)


def _two_shares(beyond, slipping, still_open, note, *, open_ends=None):
    open_ends = still_open if open_ends is None else open_ends
    count = np.size(slipping)
    return Measurement(
        {
            "runs with a transient beyond 4000": estimates.share(
                int(np.sum(beyond)), count, int(np.sum(still_open))
            ),
            "runs that end in continuous slip": estimates.share(
                int(np.sum(slipping)), count, int(np.sum(open_ends))
            ),
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

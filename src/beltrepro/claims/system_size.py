"""Claims on how the transition depends on the number of blocks (Sec. V, Figs. 19 and 20)."""

from functools import partial
from itertools import pairwise

import numpy as np

from beltrepro.analysis import intermittency
from beltrepro.analysis.errors import require
from beltrepro.analysis.transitions import MINIMUM_CONTRAST, SMOOTHING
from beltrepro.claims import estimates, transitions_of_runs
from beltrepro.claims.criteria import Measurement
from beltrepro.claims.evidence import last_block_events
from beltrepro.claims.registry import claim

N10_SERIES = ("n10_u28", "n10_u31", "n10_u34", "n10_u38")
MINIMUM_SERIES = 5000.0
LAST_PART = 0.1  # of the time after the transient, in which motion that lasts still sticks
SMOOTHINGS = {  # readings of the edges, options of `transitions_of_runs.fall`
    "": {"smoothing": SMOOTHING, "minimum_contrast": MINIMUM_CONTRAST},
    ", smoothed over 1": {"smoothing": 1.0, "minimum_contrast": MINIMUM_CONTRAST},
    ", smoothed over 5": {"smoothing": 5.0, "minimum_contrast": MINIMUM_CONTRAST},
    ", contrast of 1.5": {"smoothing": SMOOTHING, "minimum_contrast": 1.5},
}


# --- width of the transition ----------------------------------------------------------------------


@claim("transition-width")
def transition_width(evidence):
    """Transition regions at sigma = 1 for N = 5, 7 and 10."""
    noise = evidence.claim.parameters["noise"]
    return {
        f"sigma = {noise:g}{name}": partial(_edges, evidence, noise, options)
        for name, options in SMOOTHINGS.items()
    }


def _edges(evidence, noise, options):
    falls = {n: _fall(evidence, int(n), noise, options) for n in evidence.claim.paper}
    edges = {
        f"{side}, N = {n}": fall[side] for n, fall in falls.items() for side in ("lower", "upper")
    }
    sizes = list(falls)
    wider = {
        f"width, N = {more} minus N = {less}": estimates.difference(
            falls[more]["width"], falls[less]["width"]
        )
        for less, more in pairwise(sizes)
    }
    return Measurement(edges | wider, {f"width, N = {n}": falls[n]["width"] for n in sizes})


@claim("sharpest-at-n5")
def sharpest_at_n5(evidence):
    """Widths of the transition of six, seven and ten blocks, less that of five."""
    return {
        f"sigma = {noise:g}{name}": partial(_wider_than_five, evidence, noise, options)
        for noise in evidence.claim.parameters["noise"]
        for name, options in SMOOTHINGS.items()
    }


def _wider_than_five(evidence, noise, options):
    sizes = evidence.claim.parameters["n_blocks"]
    widths = {n: _fall(evidence, n, noise, options)["width"] for n in (5, *sizes)}
    return Measurement(
        {f"width, N = {n} minus N = 5": estimates.difference(widths[n], widths[5]) for n in sizes},
        {f"width, N = {n}": width for n, width in widths.items()},
    )


def _fall(evidence, n_blocks, noise, options):
    row = evidence.replicates(n_blocks, noise)
    return transitions_of_runs.fall(row.belt_velocity, row.disorder, **options)


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
    groups = [row.between(place, place) for place in places]
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
    series = evidence.dataset(name)
    transient, duration = (float(series.attributes[key]) for key in ("transient", "duration"))
    length = duration - transient
    require(length >= MINIMUM_SERIES, f"{name} covers {length:g}, {MINIMUM_SERIES:g} are needed")
    slips, sticks = last_block_events(series)
    phases = intermittency.laminar_phases(
        slips["time"], sticks["time"], laminar_time, start=transient, stop=duration
    )
    last = sticks["time"].max(initial=-np.inf)
    run = np.array([[np.diff(phases).sum() / length, len(phases), last]])
    return float(series.attributes["belt_velocity"]), run, length, duration - LAST_PART * length


def _intermittency(velocities, groups, length, late):
    """Of groups of runs (R, 3) at each u: share of time in laminar phases, number, last stick."""
    share, count, last = np.concatenate(groups).T
    mask = intermittency.intermittent_mask({"laminar_fraction": share, "laminar_count": count})
    lasting = np.nan_to_num(last, nan=-np.inf) >= late
    found = estimates.bootstrap(partial(_slope_of_phases, velocities, length), groups)
    if found.runs == 1:
        found = estimates.single(found.value)
    return Measurement(
        {
            "intermittent": estimates.share(int(mask.sum()), mask.size),
            "lasts": estimates.share(int(lasting.sum()), lasting.size),
            "laminar phase over u": found,
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

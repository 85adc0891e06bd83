"""Claims on how the transition depends on the number of blocks (Sec. V, Figs. 19 and 20)."""

from functools import partial
from itertools import pairwise

import numpy as np

from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import last_block_events
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates, intermittency, transitions
from beltrepro.stats.errors import require

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
        "median over 3 in u": {"window": 3.0},
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
    """The fall of r for each number of blocks, with options of `transitions.fall`.

    None for rows of single runs, whose errors are not known.
    """
    if options is None:
        return {n: evidence.row(int(n), noise).fall for n in sizes}
    rows = {n: evidence.replicates(int(n), noise) for n in sizes}
    if not options:
        return {n: row.fall for n, row in rows.items()}
    return {
        n: transitions.fall(row.belt_velocity, row.disorder, **options) for n, row in rows.items()
    }


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
    slope = estimates.bootstrap(partial(_slope_of_phases, velocities, length), groups)
    return Measurement(
        {
            "intermittent": estimates.share(int(mask.sum()), mask.size),
            "lasts": estimates.share(int(lasting.sum()), lasting.size),
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

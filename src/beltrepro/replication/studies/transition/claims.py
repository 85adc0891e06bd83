"""Claims on the fall of r with the belt velocity, without noise (Sec. IV.A, Fig. 12)."""

from functools import partial

import numpy as np

from beltrepro.replication.studies.transition import transients
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates, sections, states, transitions
from beltrepro.stats.errors import require

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
    readings = _readings_of_fall(evidence, names, also=("lower", "upper"))
    for window in (1.0, 3.0, 5.0):
        readings[f"running median over {window:g}"] = partial(
            _fall, evidence, names, ("lower", "upper"), window=window
        )
    return readings


def _readings_of_fall(evidence, names, also=()):
    return {
        "the paper's scheme": partial(_fall, evidence, names, also),
        "exact dynamics": partial(_fall, evidence, names, also, scan=EXACT),
        "wider starts": partial(_fall, evidence, names, also, scan=WIDE),
        "one run at each u": partial(_fall_of_row, evidence, names, also),
    }


def _fall(evidence, names, also, *, scan=PAPERS_SCHEME, **options):
    runs = evidence.replicates(5, 0.0, scan=scan)
    found = transitions.fall(runs.belt_velocity, runs.disorder, **options) if options else runs.fall
    return _named(names, also, found, _side_by_side(runs, found))


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
    kept = (
        estimates.share(int((large & regular).sum()), count, int((large & still_open).sum()))
        if count
        else estimates.absent()
    )
    return Measurement(
        {"runs of large r": estimates.share(count, large.size), "of these not chaotic": kept},
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

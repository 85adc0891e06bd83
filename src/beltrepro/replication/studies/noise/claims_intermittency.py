"""Claims on noise-induced intermittency (Sec. IV.B, Figs. 16 and 18)."""

from functools import partial

import numpy as np
import scipy

from beltrepro.model.units import LENGTH_M, TIME_S, from_si
from beltrepro.replication.camera import recording
from beltrepro.replication.studies.experiment.lines import LEAST_PEAKS, SEGMENT_S, lines, spacing
from beltrepro.replication.studies.noise.claims import N_BLOCKS, QUIET, RUNS
from beltrepro.replication.studies.noise.cycles import share_of_time
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import intermittency
from beltrepro.stats.errors import require
from beltrepro.stats.estimates import CONFIDENCE, Estimate, difference, mean, ratio, share, sure

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
            "alternating": share(int(np.count_nonzero(count >= 2)), count.size),
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
            "laminar share": share_of_time(phases),
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
    return share(int(np.count_nonzero(having[near])), int(np.count_nonzero(near)))


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
            "intermittent at sigma = 0": share(int(np.count_nonzero(without)), without.size),
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

"""Laminar and chaotic phases: in which runs, with which spectra, and where in the map."""

import numpy as np
import scipy

from beltrepro.base.errors import require
from beltrepro.model.units import TIME_S, from_si
from beltrepro.replication.studies.experiment.lines import LEAST_PEAKS, SEGMENT_S, lines, spacing
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.stats.estimates import CONFIDENCE, Estimate, difference, mean, ratio, share, share_of
from beltrepro.stats.intermittency import intermittent_mask

LIKELY = (15.0, 20.0)  # velocities at which a deterministic run could be intermittent
STRETCH_S = 2 * SEGMENT_S
GROUPS = ((0.0, 2.0), (2.0, 4.0), (4.0, 6.0), (6.0, 8.0))  # of sigma, without the lower end


def lasting(row):
    """Which runs are intermittent and do not leave chaos for good while they are measured."""
    last_half = row.transient + 0.5 * (row.duration - row.transient)
    return intermittent_mask(row.points) & (row.points["last_stick_time"] >= last_half)


def share_without_noise(evidence, scan):
    """Share of the runs of five blocks without noise near the transition that are intermittent."""
    row = evidence.replicates(5, 0.0, scan=scan)
    near = row.between(*LIKELY)
    require(near.any(), f"no runs at {LIKELY[0]:g} <= u <= {LIKELY[1]:g} without noise")
    return share_of(lasting(row)[near])


# --- spectra --------------------------------------------------------------------------------------


def spectra(evidence, *names):
    """Spectra of the laminar and of the chaotic stretches of some series."""
    laminar, chaotic = [], []
    for name in names:
        run = evidence.dataset(name)
        phases = evidence.laminar_phases(name)
        laminar += _spectra(run, phases)
        chaotic += _spectra(run, np.column_stack([phases[:-1, 1], phases[1:, 0]]))
    fewest = min(len(laminar), len(chaotic))
    require(fewest >= 2, f"{fewest} phases of {STRETCH_S:g} s or more, 2 are needed")
    flat, rough = (mean([s.flatness for s in stretches]) for stretches in (chaotic, laminar))
    return Measurement(
        {
            "peaks at equal distances, laminar": _share_with_lines(laminar),
            "flatness, chaotic": flat,
            "flatness, chaotic minus laminar": difference(flat, rough),
        },
        {
            "flatness, laminar": rough,
            "peaks at equal distances, chaotic": _share_with_lines(chaotic),
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


def _share_with_lines(stretches):
    """Share of the stretches whose spectral peaks are multiples of one frequency."""
    regular = [s.peaks_hz.size >= LEAST_PEAKS and spacing(s.peaks_hz).p < 0.01 for s in stretches]
    return share(sum(regular), len(regular))


# --- the region in the plane of u and sigma -------------------------------------------------------


def region(evidence, low, high):
    """Where the map is intermittent, for laminar phases of some share of the time."""
    table, quiet = evidence.table("n5_map"), evidence.replicates(5, 0.0)
    mask = intermittent_mask(table.points, low=low, high=high)
    first, second, third, _ = (_width(table, mask, group) for group in GROUPS)
    weak, strong = (
        _width(table, mask, (one[0], other[1])) for one, other in (GROUPS[:2], GROUPS[2:])
    )
    below, across = difference(second, first), difference(third, second)
    silent = (table.noise == 0) & (table.belt_velocity >= 44)
    return Measurement(
        {
            "intermittent at sigma = 0": share_of(lasting(quiet)[quiet.between(0.0, np.inf)]),
            "width beyond 4 over width up to 4": ratio(strong, weak),
            "growth across 4 less twice that below": difference(across, below.scaled(2)),
        },
        {
            "width, sigma up to 2": first,
            "width, sigma 2 to 4": second,
            "width, sigma 4 to 6": third,
            **({"at sigma = 0, u >= 44": share_of(mask[silent])} if silent.any() else {}),
        },
    )


def _width(table, mask, group):
    """Number of intermittent points times their spacing in u, mean over the levels of a group.

    Each point is a run of its own, and is intermittent by chance. The levels of the group tell how
    probable that is at each u, and so the variance of the sum. To it comes that of the two edges at
    each level, which lie anywhere between two points.
    """
    chosen = (table.noise > group[0] + 1e-9) & (table.noise <= group[1] + 1e-9)
    levels = np.unique(table.noise[chosen]).size
    require(levels >= 2, f"{levels} noise levels in {group[0]:g} < sigma <= {group[1]:g}, not 2")
    velocities, place, runs = np.unique(
        table.belt_velocity[chosen], return_inverse=True, return_counts=True
    )
    step = float(np.median(np.diff(velocities)))
    shares = np.bincount(place, mask[chosen].astype(float)) / runs
    by_chance = np.sum(shares * (1 - shares) / np.maximum(runs - 1, 1))
    error = step * np.sqrt(by_chance + 2 / (12 * levels))
    value = step * float(shares.sum())
    reach = float(scipy.stats.norm.ppf((1 + CONFIDENCE) / 2)) * float(error)
    return Estimate(value, value - reach, value + reach, int(np.count_nonzero(chosen)))

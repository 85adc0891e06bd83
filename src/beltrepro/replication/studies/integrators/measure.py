"""Two integrators side by side: which quantities are compared at which points, and the outcome.

Arrays of both sides, `tested` and `reference`, have one row for each run. Statistics within a run
are correlated, so a run enters as one number for each quantity. All runs of a side have random
numbers of their own: the samples are independent.
"""

from collections.abc import Iterable, Iterator

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.avalanches import measure as avalanches
from beltrepro.replication.studies.integrators import divergence, samples
from beltrepro.replication.studies.integrators.divergence import PLACE
from beltrepro.replication.studies.transition import transients

TABLES = {
    "agreement": Table(
        title="Every quantity that two methods are compared by, at every point, with the outcome.",
        uses=(
            "pairs_r_verlet",
            "pairs_r_event",
            "pairs_slips_verlet",
            "pairs_slips_event",
            "pairs_states_verlet",
            "pairs_states_event",
        ),
        columns={
            "part": "which pair of datasets",
            "quantity": "what is compared",
            "n_tested": "runs by the tested method",
            "n_reference": "runs by the reference",
            "mean_tested": "mean over the runs",
            "mean_reference": "mean over the runs",
            "error_tested": "standard error of the mean",
            "error_reference": "standard error of the mean",
            "z": "difference of the means over its standard error",
            "mean_p": "p-value of Welch's test of the means",
            "p": "p-value of the test named",
            "distance": "Wasserstein distance over root mean square, or difference of shares",
            "test": "test of the distributions",
            "tested": "method",
            "reference": "method",
            "corrected_p": "p after the correction for many tests (Holm), within a family",
            "verdict": "outcome",
        },
        on_top=True,
    ),
    "families": Table(
        title="Each quantity that two methods are compared by, with tests over all points.",
        uses=(
            "pairs_r_verlet",
            "pairs_r_event",
            "pairs_slips_verlet",
            "pairs_slips_event",
            "pairs_states_verlet",
            "pairs_states_event",
        ),
        columns={
            "part": "which pair of datasets",
            "quantity": "what is compared",
            "points": "number of points",
            "runs": "smallest number of runs by the reference at a point",
            "test": "test of the distributions",
            "smallest_p": "smallest corrected p of the points",
            "largest_distance": "largest distance of the distributions at a point",
            "chi2": "sum of the squared normal scores of the tests of the means",
            "degrees": "number of these tests",
            "chi2_p": "p-value of chi2",
            "uniform_p": "p-value of the test that the p-values of the means are uniform",
            "shift": "mean relative difference of the means",
            "shift_error": "standard error of shift",
        },
    ),
    "partings": Table(
        title="When trajectories by two methods, or with two steps, from the same states part.",
        uses=("pairs_paths_verlet", "pairs_paths_event"),
        columns={
            "members": "pairs of trajectories; all numbers are medians over them",
            "parting_time": "first time (model time) at which a block is 1 apart; inf if never",
            "shared_events": "events that both trajectories have",
            "reference_events": "events of the reference",
            "first_shift": "largest shift in time (model time) of the first 10 shared events",
            "shift": "largest shift in time (model time) of all shared events",
        },
    ),
    "convergence": Table(
        title="Errors of trajectories against time step and tolerance, with the order in the step.",
        uses=("pairs_paths_verlet", "pairs_paths_event", "pairs_paths_tolerances"),
        columns={
            "varied": "time_step or tolerance",
            "tolerance": "truncation error allowed in a step (model force)",
            "step": "mean step (model time)",
            "after_events": "number of events after which the error is taken",
            "members": "pairs of trajectories",
            "error": "largest distance of a block (model length), root mean square over pairs",
            "order": "order of convergence in the step, over all rows of a point",
            "order_error": "its standard error",
        },
    ),
}

DISORDER = "disorder parameter r"
STILL_STICKING = "share that still sticks at the end"
FINAL_DISORDER = "disorder parameter r at the end"
LIFETIME = "lifetime of the chaotic transient"

_POINT = (*PLACE, "noise")
_FAMILY = ("part", "quantity", "time_step", "initial_spread")
"""What tells the families apart: a family is what one quantity gives at all points."""

Arrays = dict[str, np.ndarray]


# --- agreement.csv and families.csv ---------------------------------------------------------------


def agreement(data) -> pd.DataFrame:
    """A row for each quantity and point, with verdicts."""
    return pd.DataFrame(judge(_compared(data)))


def families(data) -> pd.DataFrame:
    """A row for each family: what one quantity gives at all points."""
    return pd.DataFrame(summarise(judge(_compared(data))))


def judge(rows: Iterable[dict]) -> list[dict]:
    """The rows with corrected_p and verdict; the p of a family are corrected together."""
    return [
        row | {"corrected_p": float(p), "verdict": samples.verdict(p, row["distance"])}
        for family in _families(rows).values()
        for row, p in zip(family, samples.holm([row["p"] for row in family]), strict=True)
    ]


def summarise(judged: list[dict]) -> list[dict]:
    """One row for each family."""
    rows = []
    for key, family in _families(judged).items():
        measured = [row for row in family if np.isfinite(row["corrected_p"])]
        rows.append(
            dict(zip(_FAMILY, key, strict=True))
            | {"points": len(family), "runs": min(row["n_reference"] for row in family)}
            | {name: sum(row["verdict"] == name for row in family) for name in samples.VERDICTS}
            | {
                "test": family[0]["test"],
                "smallest_p": min((row["corrected_p"] for row in measured), default=np.nan),
                "largest_distance": max((row["distance"] for row in measured), default=np.nan),
            }
            | samples.overall(family)
            | {side: family[0][side] for side in ("tested", "reference")}
        )
    return rows


def _families(rows: Iterable[dict]) -> dict[tuple, list[dict]]:
    groups: dict[tuple, list[dict]] = {}
    for row in rows:
        groups.setdefault(tuple(row.get(name) for name in _FAMILY), []).append(row)
    return groups


def _compared(data) -> Iterator[dict]:
    """The comparisons of each part, before any correction for their number."""
    for part, name, compare in (
        ("disorder", "pairs_r", _disorder),
        ("slips", "pairs_slips", _slips),
        ("attractors", "pairs_states", lambda one, two: compare_attractors(one.arrays, two.arrays)),
    ):
        sides = [data[f"{name}_{method}"] for method in ("verlet", "event")]
        methods = {
            role: side.attributes["method"]
            for role, side in zip(("tested", "reference"), sides, strict=True)
        }
        for row in compare(*sides):
            yield {"part": part} | row | methods


def _disorder(*sides) -> list[dict]:
    measured = [
        disorder_statistics(
            side.arrays, measured_time=side.attributes["duration"] - side.attributes["transient"]
        )
        for side in sides
    ]
    return compare_points(*(side.arrays for side in sides), *measured)


def _slips(*sides) -> list[dict]:
    arrays = [side.arrays for side in sides]
    return compare_points(*arrays, *map(slip_statistics, arrays))


def disorder_statistics(points: Arrays, *, measured_time: float) -> Arrays:
    """Per run (R,): r, mean length, rates of slips and crossings, v_N at the section."""
    rows = np.arange(points["n_blocks"].size)
    mean, spread = _moments([row[np.isfinite(row)] for row in points["section_velocity"]])
    return {
        DISORDER: points["disorder_parameter"],
        "mean length": points["mean_length"],
        "slips of the last block per time": points["slip_count"][rows, points["n_blocks"] - 1]
        / measured_time,
        "crossings of the section per time": points["section_count"] / measured_time,
        "v_N at the section, mean": mean,
        "v_N at the section, standard deviation": spread,
    }


def slip_statistics(catalogue: Arrays) -> Arrays:
    """Per run (R,): number, sizes and losses of the slips of the last block, and section points.

    Sizes are those in the laboratory frame (Fig. 9).
    """
    sizes, losses, velocities = [], [], []
    for run, n_blocks in enumerate(catalogue["n_blocks"]):
        slips = catalogue["slips"][catalogue["slips"]["point"] == run]
        sizes.append(
            avalanches.last_block_slip_sizes(slips, n_blocks, catalogue["belt_velocity"][run])
        )
        losses.append(avalanches.last_block_slips(slips, n_blocks)["dissipated"])
        section = catalogue["section"][catalogue["section"]["point"] == run]
        velocities.append(section["velocities"][:, n_blocks - 1])
    mean_velocity, velocity_spread = _moments(velocities)
    return {
        "slips of the last block": np.array([size.size for size in sizes], dtype=float),
        "slip size, mean": _moments(sizes)[0],
        "slip size, median": _quantiles(sizes, 0.5),
        "slip size, 90 % quantile": _quantiles(sizes, 0.9),
        "energy dissipated in a slip, mean": _moments(losses)[0],
        "section points": np.array([velocity.size for velocity in velocities], dtype=float),
        "v_N at section points, mean": mean_velocity,
        "v_N at section points, standard deviation": velocity_spread,
    }


def _moments(runs):
    filled = [values if values.size else np.array([np.nan]) for values in runs]
    return (
        np.array([values.mean() for values in filled], dtype=float),
        np.array([values.std() for values in filled], dtype=float),
    )


def _quantiles(runs, share):
    return np.array([np.quantile(values, share) if values.size else np.nan for values in runs])


def compare_points(
    tested: Arrays, reference: Arrays, statistics_tested: Arrays, statistics_reference: Arrays
) -> list[dict]:
    """Every quantity at every point (N, u, sigma)."""
    rows = []
    for point in _points(tested, reference, _POINT):
        at_tested, at_reference = _at(tested, point), _at(reference, point)
        for quantity, values in statistics_tested.items():
            comparison = samples.compare_samples(
                values[at_tested], statistics_reference[quantity][at_reference]
            )
            rows.append({"quantity": quantity} | point | comparison)
    return rows


def compare_attractors(tested: Arrays, reference: Arrays) -> list[dict]:
    """Where runs without noise end, for each u, initial spread and time step of the tested side.

    The reference is the one with its smallest step.
    """
    rows = []
    labels = [transients.labels_of(side) for side in (tested, reference)]
    finest = reference["time_step"] == reference["time_step"].min()
    for point in _points(tested, reference, (*_POINT, "initial_spread")):
        at_reference = _at(reference, point) & finest
        for time_step in np.unique(tested["time_step"]):
            chosen = _at(tested, point) & (tested["time_step"] == time_step), at_reference
            comparisons = {
                STILL_STICKING: samples.compare_shares(
                    *(side[rows] for side, rows in zip(labels, chosen, strict=True)),
                    labels=transients.ATTRACTORS,
                    counted=transients.STICK_SLIP,
                ),
                FINAL_DISORDER: samples.compare_samples(
                    *_columns("final_disorder", tested, reference, chosen)
                ),
                LIFETIME: samples.compare_lifetimes(
                    *_columns("lifetime", tested, reference, chosen),
                    *_columns("escaped", tested, reference, chosen),
                ),
            }
            place = point | {"time_step": float(time_step)}
            rows += [
                {"quantity": quantity} | place | comparison
                for quantity, comparison in comparisons.items()
            ]
    return rows


def _columns(name, tested, reference, chosen):
    return [side[name][rows] for side, rows in zip((tested, reference), chosen, strict=True)]


def _points(tested, reference, names):
    """Points that both sides have, in order, as dicts of plain numbers."""
    sides = [
        {tuple(values) for values in zip(*(side[name].tolist() for name in names), strict=True)}
        for side in (tested, reference)
    ]
    return [dict(zip(names, point, strict=True)) for point in sorted(sides[0] & sides[1])]


def _at(arrays, point):
    return np.all([arrays[name] == value for name, value in point.items()], axis=0)


# --- partings.csv and convergence.csv -------------------------------------------------------------


def partings(data) -> pd.DataFrame:
    """A row for each method, point and time step."""
    return pd.DataFrame(_trajectories(data)[0])


def convergence(data) -> pd.DataFrame:
    """A row for each method, point, number of events, and time step or tolerance."""
    tolerances = data["pairs_paths_tolerances"]
    method = {"method": tolerances.attributes["method"]}
    by_tolerance = divergence.compare_tolerances(divergence.with_steps(tolerances.arrays))
    return pd.DataFrame(_trajectories(data)[1] + [method | row for row in by_tolerance])


def _trajectories(data) -> tuple[list[dict], list[dict]]:
    """Partings, and errors by time step, of both methods against the reference."""
    names = TABLES["partings"].uses
    sides = [divergence.with_steps(data[name].arrays) for name in names]
    parted, errors = [], []
    for name, side in zip(names, sides, strict=True):
        method = {"method": data[name].attributes["method"]}
        for rows, compared in zip(
            (parted, errors), divergence.compare_trajectories(side, sides[1]), strict=True
        ):
            rows += [method | row for row in compared]
    return parted, errors

"""Two integrators side by side: which quantities are compared at which points, and the outcome.

Each function takes arrays of the same kind by both integrators, `tested` and `reference`, with one
row for each run: n_blocks, belt_velocity, noise (R,) and, for attractors, time_step and
initial_spread. Statistics within a run are correlated, so a run enters as one number for each
quantity. All runs of a side have random numbers of their own: the samples are independent.
"""

from dataclasses import asdict

import numpy as np

from beltrepro.replication.studies.avalanches import measure as avalanches
from beltrepro.replication.studies.integrators import divergence
from beltrepro.replication.studies.integrators.samples import (
    VERDICTS,
    Comparison,
    compare_lifetimes,
    compare_samples,
    compare_shares,
    holm,
    overall,
    verdict,
)
from beltrepro.replication.studies.transition import lifetimes

DISORDER = "disorder parameter r"
STILL_STICKING = "share that still sticks at the end"
FINAL_DISORDER = "disorder parameter r at the end"
LIFETIME = "lifetime of the chaotic transient"

PLACE = ("n_blocks", "belt_velocity")
_POINT = (*PLACE, "noise")

Arrays = dict[str, np.ndarray]


# --- one number for each run ----------------------------------------------------------------------


def disorder_statistics(points: Arrays, *, measured_time: float) -> dict[str, np.ndarray]:
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


def slip_statistics(catalogue: Arrays) -> dict[str, np.ndarray]:
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


def _moments(samples):
    known = [sample if sample.size else np.array([np.nan]) for sample in samples]
    return (
        np.array([sample.mean() for sample in known], dtype=float),
        np.array([sample.std() for sample in known], dtype=float),
    )


def _quantiles(samples, share):
    return np.array([np.quantile(sample, share) if sample.size else np.nan for sample in samples])


# --- comparisons ----------------------------------------------------------------------------------


def compare_points(
    tested: Arrays, reference: Arrays, statistics_tested: Arrays, statistics_reference: Arrays
) -> list[dict]:
    """Every quantity at every point (N, u, sigma)."""
    rows = []
    for point in _points(tested, reference, _POINT):
        ours, theirs = _at(tested, point), _at(reference, point)
        for quantity, values in statistics_tested.items():
            comparison = compare_samples(values[ours], statistics_reference[quantity][theirs])
            rows.append({"quantity": quantity} | point | asdict(comparison))
    return rows


def compare_attractors(tested: Arrays, reference: Arrays, *, reference_step: float) -> list[dict]:
    """Where runs without noise end, for each u, initial spread and time step of the tested side.

    The quantities are the share of runs in which the last block still sticks at the end (tested
    over all labels of `lifetimes.label_attractors`), r over the end of the run, and the lifetime of
    the chaotic transient.
    """
    rows = []
    base = np.isclose(reference["time_step"], reference_step)
    for point in _points(tested, reference, (*_POINT, "initial_spread")):
        theirs = _at(reference, point) & base
        for time_step in np.unique(tested["time_step"]):
            ours = _at(tested, point) & (tested["time_step"] == time_step)
            for quantity, comparison in _attractors(tested, ours, reference, theirs).items():
                row = {"quantity": quantity} | point | {"time_step": float(time_step)}
                rows.append(row | asdict(comparison))
    return rows


def _attractors(
    tested: Arrays, ours: np.ndarray, reference: Arrays, theirs: np.ndarray
) -> dict[str, Comparison]:
    return {
        STILL_STICKING: compare_shares(
            lifetimes.labels_of(tested)[ours],
            lifetimes.labels_of(reference)[theirs],
            labels=lifetimes.ATTRACTORS,
            counted=lifetimes.STICK_SLIP,
        ),
        FINAL_DISORDER: compare_samples(
            tested["final_disorder"][ours], reference["final_disorder"][theirs]
        ),
        LIFETIME: compare_lifetimes(
            tested["lifetime"][ours],
            reference["lifetime"][theirs],
            escaped_tested=tested["escaped"][ours],
            escaped_reference=reference["escaped"][theirs],
        ),
    }


def _points(tested, reference, names):
    """Points that both sides have, in order, as dicts of plain numbers."""
    sides = [
        {tuple(values) for values in zip(*(side[name].tolist() for name in names), strict=True)}
        for side in (tested, reference)
    ]
    return [dict(zip(names, point, strict=True)) for point in sorted(sides[0] & sides[1])]


def _at(arrays, point):
    return np.all([arrays[name] == value for name, value in point.items()], axis=0)


# --- families -------------------------------------------------------------------------------------

FAMILY = ("part", "quantity", "time_step", "initial_spread")


def judge(rows: list[dict]) -> list[dict]:
    """The rows with corrected_p and verdict; the p of a family are corrected together.

    A family is what one quantity gives at all points: rows with equal values of FAMILY.
    """
    judged = []
    for family in _families(rows).values():
        corrected = holm([row["p"] for row in family])
        judged += [
            row | {"corrected_p": float(p), "verdict": verdict(p, row["distance"])}
            for row, p in zip(family, corrected, strict=True)
        ]
    return judged


def summarise(judged: list[dict]) -> list[dict]:
    """One row for each family."""
    table = []
    for key, family in _families(judged).items():
        names = Comparison.__dataclass_fields__
        comparisons = [Comparison(**{name: row[name] for name in names}) for row in family]
        together = overall(comparisons)
        counts = {name: sum(row["verdict"] == name for row in family) for name in VERDICTS}
        measured = [row for row in family if np.isfinite(row["corrected_p"])]
        table.append(
            dict(zip(FAMILY, key, strict=True))
            | {"points": len(family), "runs": min(row["n_reference"] for row in family)}
            | counts
            | {"test": family[0]["test"]}
            | {
                "smallest_p": min((row["corrected_p"] for row in measured), default=np.nan),
                "largest_distance": max((row["distance"] for row in measured), default=np.nan),
            }
            | asdict(together)
        )
    return table


def _families(rows):
    found: dict[tuple, list[dict]] = {}
    for row in rows:
        found.setdefault(tuple(row.get(name) for name in FAMILY), []).append(row)
    return found


# --- trajectories ---------------------------------------------------------------------------------


def compare_trajectories(
    runs: Arrays, reference: Arrays, *, reference_step: float
) -> tuple[list[dict], list[dict]]:
    """Partings and errors of runs against the reference runs with reference_step."""
    base = divergence.equal(reference["time_step"], reference_step)
    partings, errors = [], []
    for time_step in np.unique(runs["time_step"]):
        if runs is reference and divergence.equal(time_step, reference_step):
            continue
        rows = divergence.equal(runs["time_step"], time_step)
        for at_point, members in _by_point(runs, rows, reference, base):
            point = {name: at_point[name] for name in (*PLACE, "time_step")}
            partings.append(point | divergence.summarise(members))
            errors += _errors({"varied": "time_step"} | at_point, members)
    return partings, _with_orders(errors, rounding=divergence.ROUNDING)


def compare_tolerances(runs: Arrays) -> list[dict]:
    """Errors of runs with several tolerances against those with the tightest."""
    allowed = runs["allowed_error"]
    known = np.unique(allowed[np.isfinite(allowed)])
    errors = []
    for tolerance in known[:0:-1]:
        rows, tightest = (divergence.equal(allowed, value) for value in (tolerance, known[0]))
        for at_point, members in _by_point(runs, rows, runs, tightest):
            errors += _errors({"varied": "tolerance"} | at_point, members)
    return _with_orders(errors, rounding=divergence.ROUNDING_OF_LONG_STEPS)


def _by_point(runs, rows, reference, reference_rows):
    """Pairs of each point, with the point, time_step, tolerance and mean step of the runs."""
    found = divergence.pairs(runs, reference, rows=rows, reference_rows=reference_rows)
    for point, members in sorted(found.items()):
        here = dict(zip(PLACE, point, strict=True))
        here_rows = rows & _at(runs, here)
        first = np.flatnonzero(here_rows)[0]
        settings = {
            "time_step": float(runs["time_step"][first]),
            "tolerance": float(runs["allowed_error"][first]),
        }
        yield here | settings | {"step": float(runs["step"][here_rows].mean())}, members


def _errors(at_step, members):
    return [
        at_step | {"after_events": n_events, "members": count, "error": error}
        for n_events, (count, error) in divergence.errors(members).items()
    ]


def _with_orders(errors, *, rounding):
    names = (*PLACE, "after_events")
    groups: dict[tuple, list[dict]] = {}
    for row in errors:
        groups.setdefault(tuple(row[name] for name in names), []).append(row)
    rows = []
    for _, group in sorted(groups.items()):
        steps, sizes = ([row[name] for row in group] for name in ("step", "error"))
        order, order_error = divergence.convergence_order(steps, sizes, rounding=rounding)
        rows += [row | {"order": order, "order_error": order_error} for row in group]
    return rows

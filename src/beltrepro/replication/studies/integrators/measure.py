"""Two integrators side by side: which quantities are compared at which points, and the outcome.

Arrays of both sides, `tested` and `reference`, have one row for each run. Statistics within a run
are correlated, so a run enters as one number for each quantity. All runs of a side have random
numbers of their own: the samples are independent.
"""

from collections.abc import Callable, Iterable, Iterator

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.integrators import samples
from beltrepro.stats import states

TABLES = {
    "agreement": Table(
        uses=(
            "pairs_r_verlet",
            "pairs_r_event",
            "pairs_slips_verlet",
            "pairs_slips_event",
            "pairs_states_verlet",
            "pairs_states_event",
        ),
        on_top=True,
    ),
    "families": Table(
        uses=(
            "pairs_r_verlet",
            "pairs_r_event",
            "pairs_slips_verlet",
            "pairs_slips_event",
            "pairs_states_verlet",
            "pairs_states_event",
        )
    ),
}

DISORDER = "disorder parameter r"
STILL_STICKING = "share that still sticks at the end"
FINAL_DISORDER = "disorder parameter r at the end"
LIFETIME = "lifetime of the chaotic transient"

_POINT = ["n_blocks", "belt_velocity", "noise"]
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
        ("attractors", "pairs_states", _attractors),
    ):
        sides = [data[f"{name}_{method}"] for method in ("verlet", "event")]
        tested, reference = (side.attributes["method"] for side in sides)
        for row in compare(*sides):
            yield {"part": part} | row | {"tested": tested, "reference": reference}


def _disorder(*sides) -> Iterator[dict]:
    lengths = [side.attributes["duration"] - side.attributes["transient"] for side in sides]
    arrays = [side.arrays for side in sides]
    return compare_points(*map(disorder_statistics, arrays, lengths))


def _slips(*sides) -> Iterator[dict]:
    return compare_points(*(slip_statistics(side.arrays) for side in sides))


def _attractors(*sides) -> Iterator[dict]:
    return compare_attractors(*(side.arrays for side in sides))


def disorder_statistics(points: Arrays, measured_time: float) -> pd.DataFrame:
    """Per run: r, mean length, rates of slips and crossings, v_N at the section."""
    sections = [values[np.isfinite(values)] for values in points["section_velocity"]]
    last = np.arange(len(sections)), points["n_blocks"] - 1
    statistics = {
        DISORDER: points["disorder_parameter"],
        "mean length": points["mean_length"],
        "slips of the last block per time": points["slip_count"][last] / measured_time,
        "crossings of the section per time": points["section_count"] / measured_time,
        "v_N at the section, mean": [_of(np.mean, values) for values in sections],
        "v_N at the section, standard deviation": [_of(np.std, values) for values in sections],
    }
    return pd.DataFrame({name: points[name] for name in _POINT} | statistics)


def slip_statistics(catalogue: Arrays) -> pd.DataFrame:
    """Per run: number, sizes and losses of the slips of the last block, and section points.

    Sizes are those in the laboratory frame (Fig. 9).
    """
    rows = []
    for run, n_blocks in enumerate(catalogue["n_blocks"]):
        slips, section = (
            events[events["point"] == run] for events in (catalogue["slips"], catalogue["section"])
        )
        of_last = slips[slips["block"] == n_blocks]
        sizes, losses = of_last["start_position"] - of_last["stop_position"], of_last["dissipated"]
        at_section = section["velocities"][:, n_blocks - 1]
        rows.append(
            {name: catalogue[name][run] for name in _POINT}
            | {
                "slips of the last block": sizes.size,
                "slip size, mean": _of(np.mean, sizes),
                "slip size, median": _of(np.quantile, sizes, 0.5),
                "slip size, 90 % quantile": _of(np.quantile, sizes, 0.9),
                "energy dissipated in a slip, mean": _of(np.mean, losses),
                "section points": at_section.size,
                "v_N at section points, mean": _of(np.mean, at_section),
                "v_N at section points, standard deviation": _of(np.std, at_section),
            }
        )
    return pd.DataFrame(rows)


def _of(statistic: Callable[..., float], values: np.ndarray, *options: float) -> float:
    return statistic(values, *options) if values.size else np.nan


def compare_points(tested: pd.DataFrame, reference: pd.DataFrame) -> Iterator[dict]:
    """Every quantity at every point (N, u, sigma) that both sides have; a row is a run."""
    at_point = dict(iter(reference.groupby(_POINT)))
    for point, runs in tested.groupby(_POINT):
        for quantity in tested.columns.drop(_POINT) if point in at_point else ():
            sides = runs[quantity], at_point[point][quantity]
            place = dict(zip(_POINT, point, strict=True))
            yield {"quantity": quantity} | place | samples.compare_samples(*sides)


def compare_attractors(tested: Arrays, reference: Arrays) -> Iterator[dict]:
    """Where runs without noise end, for each u, initial spread and time step of the tested side.

    The reference is the one with its smallest step.
    """
    names = [*_POINT, "initial_spread", "time_step"]
    ends = ("final_disorder", "lifetime", "escaped")
    ours, theirs = (
        pd.DataFrame({name: side[name] for name in (*names, *ends)}).assign(
            label=states.label_ends(side)
        )
        for side in (tested, reference)
    )
    finest = theirs[theirs["time_step"] == theirs["time_step"].min()]
    at_point = dict(iter(finest.groupby(names[:-1])))
    for (*point, step), runs in ours.groupby(names):
        if tuple(point) not in at_point:
            continue
        sides = runs, at_point[tuple(point)]
        labels, disorder, lifetimes, escaped = (
            [side[name] for side in sides] for name in ("label", *ends)
        )
        alike = {"labels": states.ATTRACTORS, "counted": states.STICK_SLIP}
        place = dict(zip(names, (*point, step), strict=True))
        for quantity, comparison in (
            (STILL_STICKING, samples.compare_shares(*labels, **alike)),
            (FINAL_DISORDER, samples.compare_samples(*disorder)),
            (LIFETIME, samples.compare_lifetimes(*lifetimes, *escaped)),
        ):
            yield {"quantity": quantity} | place | comparison

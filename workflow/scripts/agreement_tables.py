"""Compare the runs of two integrators and write the outcome as CSV."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from beltrepro import scripting, store
from beltrepro.analysis import agreement

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def tables(files: list, reference_step: float) -> dict[str, pd.DataFrame]:
    """Tables by name: comparisons, families, partings and convergence.

    files : PART/tested.h5 and PART/reference.h5 for each part. reference_step : time step of the
    reference runs.
    """
    data = {(Path(path).parent.name, Path(path).stem): store.read(path) for path in files}
    compared = _disorder(data) + _slips(data) + _attractors(data, reference_step)
    judged = agreement.judge([row | _methods(data, row["part"]) for row in compared])
    partings, convergence = _trajectories(data, reference_step)
    named = {
        "comparisons": judged,
        "families": [row | _methods(data, row["part"]) for row in agreement.summarise(judged)],
        "partings": partings,
        "convergence": convergence,
    }
    return {name: pd.DataFrame(rows) for name, rows in named.items()}


def _disorder(data):
    sides = _sides(data, "disorder")
    statistics = [
        agreement.disorder_statistics(
            side.arrays, measured_time=side.attributes["duration"] - side.attributes["transient"]
        )
        for side in sides
    ]
    return _of_part("disorder", agreement.compare_points(*_arrays(sides), *statistics))


def _slips(data):
    sides = _arrays(_sides(data, "slips"))
    statistics = [agreement.slip_statistics(arrays) for arrays in sides]
    return _of_part("slips", agreement.compare_points(*sides, *statistics))


def _attractors(data, reference_step):
    sides = _arrays(_sides(data, "attractors"))
    rows = agreement.compare_attractors(*sides, reference_step=reference_step)
    return _of_part("attractors", rows)


def _trajectories(data, reference_step):
    """Partings and errors against the reference with reference_step, errors by tolerance."""
    sides = _sides(data, "trajectories")
    reference = sides[1].arrays
    tolerance = next(
        (side.attributes["tolerance"] for side in sides if "tolerance" in side.attributes), np.nan
    )
    partings, convergence = [], []
    for side in sides:
        method = {"method": side.attributes["method"]}
        parted, errors = agreement.compare_trajectories(
            side.arrays, reference, reference_step=reference_step, tolerance=tolerance
        )
        errors += agreement.compare_tolerances(side.arrays, time_step=reference_step)
        partings += [method | row for row in parted]
        convergence += [method | row for row in errors]
    return partings, convergence


def _sides(data, part):
    return [data[part, role] for role in ("tested", "reference")]


def _arrays(sides):
    return [side.arrays for side in sides]


def _of_part(part, rows):
    return [{"part": part} | row for row in rows]


def _methods(data, part):
    sides = zip(("tested", "reference"), _sides(data, part), strict=True)
    return {role: side.attributes["method"] for role, side in sides}


def main(job):
    for name, table in tables(list(job.input), job.params.reference_step).items():
        table.to_csv(getattr(job.output, name), index=False, float_format="%.6g")


if __name__ == "__main__":
    scripting.run(main, snakemake)

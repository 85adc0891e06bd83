"""Simulate one batch of points of a dataset and write what its kind records."""

import numba

from beltrepro.base.progress import Progress
from beltrepro.replication.plan import io, scripting
from beltrepro.replication.plan.batch import record
from beltrepro.replication.plan.kinds import KINDS
from beltrepro.replication.plan.points import points_of


def main(job):
    # By itself it takes all cores.
    numba.set_num_threads(min(job.threads, numba.config.NUMBA_NUM_THREADS))
    spec, arrays = job.params.spec, job.params.arrays
    points = points_of(job.params.points)
    progress = Progress(f"{spec['dataset']}: {len(points)} points")
    recorded = record(KINDS[spec["kind"]].record, arrays, points, spec["settings"], progress)
    io.write(job.output[0], spec, recorded)


if __name__ == "__main__":
    scripting.run(main, snakemake)

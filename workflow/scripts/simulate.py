"""Simulate one batch of points of a dataset and write what its kind records."""

from typing import TYPE_CHECKING

from beltrepro import scripting
from beltrepro.datasets import files, running
from beltrepro.datasets.points import points_of

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def simulate(told: dict, output, progress=None) -> None:
    """Simulate what `Plan.told_batch` says.

    progress : called with the fraction done; a bar or log lines if not given.
    """
    points = points_of(told["points"])
    progress = progress or scripting.Progress(f"{told['dataset']}: {len(points)} points")
    arrays = running.run(told["kind"], points, told["settings"], progress)
    files.write(output, told, arrays)


def main(job):
    scripting.use_threads(job.threads)
    simulate(job.params.told, job.output[0])


if __name__ == "__main__":
    scripting.run(main, snakemake)

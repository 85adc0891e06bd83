"""Simulate one batch of points of a dataset and write what its kind records."""

from beltrepro.base.progress import Progress
from beltrepro.replication.plan import files, kinds, scripting
from beltrepro.replication.plan.points import points_of


def simulate(spec: dict, output, progress=None) -> None:
    """Simulate what `Plan.spec` says.

    progress : called with the fraction done; a bar or log lines if not given.
    """
    points = points_of(spec["points"])
    progress = progress or Progress(f"{spec['dataset']}: {len(points)} points")
    files.write(output, spec, kinds.record(spec["kind"], points, spec["settings"], progress))


def main(job):
    scripting.use_threads(job.threads)
    simulate(job.params.spec, job.output[0])


if __name__ == "__main__":
    scripting.run(main, snakemake)

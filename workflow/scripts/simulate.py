"""Simulate one batch of points of a dataset and write what its kind records."""

from pathlib import Path
from typing import TYPE_CHECKING

from beltrepro.base import provenance
from beltrepro.base.progress import Progress
from beltrepro.replication.plan import files, kinds, scripting
from beltrepro.replication.plan.points import points_of
from beltrepro.simulation import checkpoints

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def simulate(spec: dict, output, code: str = "", progress=None) -> None:
    """Simulate what `Plan.batch_spec` says; what is done of it outlives a kill, beside the output.

    code : hash of the code that simulates. progress : called with the fraction done; a bar or log
    lines if not given.
    """
    points = points_of(spec["points"])
    progress = progress or Progress(f"{spec['dataset']}: {len(points)} points")
    output = Path(output)
    work = files.digest({"told": spec, "code": code, "by": provenance.machine()})
    with checkpoints.keeping(output.with_name(f".{output.name}.checkpoint"), work):
        arrays = kinds.record(spec["kind"], points, spec["settings"], progress)
        files.write(output, spec, arrays)


def main(job):
    scripting.use_threads(job.threads)
    simulate(job.params.spec, job.output[0], job.params.code)


if __name__ == "__main__":
    scripting.run(main, snakemake)

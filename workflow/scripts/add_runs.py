"""Add runs to the replicates of some rows where they are not enough, and write only these."""

from pathlib import Path
from typing import TYPE_CHECKING

from beltrepro.base import provenance
from beltrepro.base.progress import Progress
from beltrepro.replication.plan import files, kinds, more_runs, scripting
from beltrepro.replication.plan.points import points_in, points_of
from beltrepro.simulation import checkpoints

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def add_runs(spec: dict, paths: list, expected: list[dict], output, code: str = "") -> None:
    """Simulate what is wanted beside the runs in some files; spec : see `Plan.batch_spec`.

    expected : what each of the files must say of itself. A file without a run is written, too.
    """
    parts = [files.read(path, one) for path, one in zip(paths, expected, strict=True)]
    kind, rule = kinds.KINDS[spec["kind"]], more_runs.MoreRuns(**spec["more_runs"])
    so_far = files.join(parts, kind.arrays)
    planned = points_of(spec["points"])
    points = more_runs.wanted(planned, points_in(so_far), so_far[rule.of], rule)
    scripting.logger.info("%d runs are added", len(points))
    if not points:
        files.write(output, spec, files.without_points(so_far, kind.arrays))
        return
    output = Path(output)
    work = files.digest({"told": spec, "code": code, "by": provenance.machine()})
    progress = Progress(f"{spec['dataset']}: {len(points)} points")
    with checkpoints.keeping(output.with_name(f".{output.name}.checkpoint"), work):
        arrays = kinds.record(spec["kind"], points, spec["settings"], progress)
        files.write(output, spec, arrays)


def main(job):
    scripting.use_threads(job.threads)
    add_runs(job.params.spec, list(job.input), job.params.expected, job.output[0], job.params.code)


if __name__ == "__main__":
    scripting.run(main, snakemake)

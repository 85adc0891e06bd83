"""Join the batches of a dataset into one file."""

from beltrepro.base import provenance
from beltrepro.replication.plan import files, kinds, scripting


def join(paths: list, expected: list[dict], spec: dict, output) -> None:
    """Join files in their order.

    expected : what each of them must say of itself.
    spec : what the whole is, see `Plan.spec`.
    """
    parts = [files.read(path, one) for path, one in zip(paths, expected, strict=True)]
    arrays = files.join(parts, kinds.KINDS[spec["kind"]].arrays)
    files.write(output, spec, arrays, provenance.of_all(part.attributes for part in parts))


def main(job):
    join(list(job.input), job.params.expected, job.params.spec, job.output[0])


if __name__ == "__main__":
    scripting.run(main, snakemake)

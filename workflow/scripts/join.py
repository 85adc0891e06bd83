"""Join the batches of a dataset into one file."""

from beltrepro.base import provenance, store
from beltrepro.replication.plan import io, scripting


def main(job):
    spec = job.params.spec
    parts = [store.read(path) for path in job.input]
    origin = provenance.of_all(part.attributes for part in parts)
    io.write(job.output[0], spec, io.join(parts, spec["kind"]), origin)


if __name__ == "__main__":
    scripting.run(main, snakemake)

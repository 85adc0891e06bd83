"""Measure the claims of the paper and write them as CSV."""

from beltrepro.replication.plan import inputs, scripting
from beltrepro.replication.plan import tables as files
from beltrepro.replication.studies.every_claim import measure

CLAIMS = "Every claim of the paper: what it prints, what was measured, and the verdict."
ESTIMATES = "The numbers that the verdicts rest on, with their intervals and the allowed ranges."


def claims(paths: dict, expected: dict, settings: dict, output) -> None:
    """Measure the claims from files by name of the dataset or track."""
    data = inputs.load(paths, expected)
    found = measure(data, settings)
    about = {"columns": {}, "sources": expected, "lineage": inputs.lineage(paths, data)}
    files.write(output.estimates, found.estimates, title=ESTIMATES, **about)
    files.write(output.claims, found.claims, title=CLAIMS, **about)


def main(job):
    files, params = dict(job.input.items()), job.params
    claims(files, params.expected, params.settings, job.output)


if __name__ == "__main__":
    scripting.run(main, snakemake)

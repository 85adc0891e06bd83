"""Measure the claims of the paper and write them as CSV."""

from beltrepro.replication.plan import io, scripting
from beltrepro.replication.studies.every_claim import measure

CLAIMS = "Every claim of the paper: what it prints, what was measured, and the verdict."
ESTIMATES = "The numbers that the verdicts rest on, with their intervals and the allowed ranges."


def main(job):
    data, sources = io.load(dict(job.input.items()))
    measured = measure(data, job.params.settings)
    about = {"columns": {}, "sources": sources}
    io.write_table(job.output.estimates, measured.estimates, title=ESTIMATES, **about)
    io.write_table(job.output.claims, measured.claims, title=CLAIMS, **about)


if __name__ == "__main__":
    scripting.run(main, snakemake)

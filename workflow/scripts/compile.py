"""Compile the kernels of one integrator for this processor, once for all jobs."""

from beltrepro.extras.cache import compile_kernels
from beltrepro.replication.plan import scripting


def main(job):
    compile_kernels(job.wildcards.method)


if __name__ == "__main__":
    scripting.run(main, snakemake)

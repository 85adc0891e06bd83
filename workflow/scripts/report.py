"""Write the report."""

from pathlib import Path

from beltrepro.replication.plan import scripting
from beltrepro.replication.report.material import Material
from beltrepro.replication.report.page import render


def main(job):
    # A name stands for one file or for a list of files.
    files = {
        name: [Path(path) for path in ([paths] if isinstance(paths, str) else paths)]
        for name, paths in job.input.items()
    }
    params = job.params
    material = Material(params.preset, params.settings, files, Path(params.benchmarks))
    render(Path(job.output[0]), material)


if __name__ == "__main__":
    scripting.run(main, snakemake)

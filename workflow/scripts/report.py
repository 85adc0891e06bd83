"""Write the report."""

from pathlib import Path

from beltrepro.replication.plan import inputs, scripting
from beltrepro.replication.report.material import Material
from beltrepro.replication.report.page import render


def main(job):
    # A name stands for one file or for a list of files.
    files = {
        name: [Path(path) for path in ([each] if isinstance(each, str) else each)]
        for name, each in job.input.items()
    }
    for name, by_stem in job.params.expected.items():
        for path in files[name] if name != "datasets" else ():  # large, and read by the report
            inputs.check(path, by_stem[path.stem])
    params = job.params
    material = Material(params.preset, params.settings, files, Path(params.benchmarks))
    render(Path(job.output[0]), material)


if __name__ == "__main__":
    scripting.run(main, snakemake)

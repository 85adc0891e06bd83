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
    expected = dict(job.params.expected)
    of_datasets = expected.pop(
        "datasets", {}
    )  # large: read once, and checked by who describes them
    for name, by_stem in expected.items():
        for path in files[name]:
            inputs.check(path, by_stem[path.stem])
    material = Material(
        preset=job.params.preset,
        settings=job.params.settings,
        files=files,
        benchmarks=Path(job.params.benchmarks),
        expected=of_datasets,
    )
    render(Path(job.output[0]), material)


if __name__ == "__main__":
    scripting.run(main, snakemake)

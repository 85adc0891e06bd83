"""Draw one figure from its datasets and tables."""

import importlib
from pathlib import Path

from beltrepro.replication.drawing import style
from beltrepro.replication.plan import inputs, scripting


def main(job):
    """`expected` : preset, run and in `sources` what the files must say of themselves, by name."""
    files, expected = dict(job.input.items()), job.params.expected
    data = inputs.load(files, expected["sources"])
    draw = getattr(importlib.import_module(job.params.module), Path(job.output.png).stem)
    figure = draw(data)
    about = inputs.source(expected), inputs.lineage(files, data)
    style.save(figure, job.output.png, job.output.pdf, *about)


if __name__ == "__main__":
    scripting.run(main, snakemake)

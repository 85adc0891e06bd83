"""Draw one figure from its datasets and tables."""

import importlib
from pathlib import Path

from beltrepro.replication.drawing import style
from beltrepro.replication.plan import io, scripting


def main(job):
    data, sources = io.load(dict(job.input.items()))
    draw = getattr(importlib.import_module(job.params.module), Path(job.output.png).stem)
    style.save(draw(data), job.output.png, job.output.pdf, sources)


if __name__ == "__main__":
    scripting.run(main, snakemake)

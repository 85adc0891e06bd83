"""Draw one figure from its datasets and tables."""

import importlib
from pathlib import Path
from typing import TYPE_CHECKING

from beltrepro.replication.drawing import style
from beltrepro.replication.plan import inputs, registry, scripting

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def draw(name: str, files: dict, expected: dict, png, pdf) -> None:
    """Draw figure `name` ("fig12") from files by dataset name; write it as PNG and PDF.

    expected : preset, run and in `sources` what the files must say of themselves, by name.
    """
    data = inputs.load(files, expected["sources"])
    module = importlib.import_module(registry.figures()[name].module)
    style.save(module.draw(data), png, pdf, inputs.source(expected), inputs.lineage(files, data))


def main(job):
    draw(
        Path(job.output.png).stem,
        dict(job.input.items()),
        job.params.expected,
        job.output.png,
        job.output.pdf,
    )


if __name__ == "__main__":
    scripting.run(main, snakemake)

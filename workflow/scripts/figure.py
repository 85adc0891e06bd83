"""Draw one figure from its datasets."""

import importlib
from pathlib import Path
from typing import TYPE_CHECKING

from beltrepro import scripting, store
from beltrepro.figures import style

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def draw(name: str, files: dict, preset: str, png, pdf) -> None:
    """Draw figure `name` ("fig12") from files by dataset name; write it as PNG and PDF."""
    data = {dataset: store.read(path) for dataset, path in files.items()}
    module = importlib.import_module(f"beltrepro.figures.{name}")
    figure = module.draw(data, style.small_print(list(data.values()), preset))
    style.save(figure, png, pdf)


def main(job):
    draw(
        Path(job.output.png).stem,
        dict(job.input.items()),
        job.params.preset,
        job.output.png,
        job.output.pdf,
    )


if __name__ == "__main__":
    scripting.run(main, snakemake)

"""Set the article."""

from pathlib import Path
from typing import TYPE_CHECKING

import yaml

from beltrepro.replication.plan import inputs, scripting
from beltrepro.replication.report import article

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main(job):
    figures = {Path(path).stem: Path(path) for path in job.input.figures}
    files = {"claims": [Path(job.input.claims)], "estimates": [Path(job.input.estimates)]}
    for name, told in job.params.expected.items():
        for path in [*figures.values()] if name == "figures" else files[name]:
            inputs.check(path, told[path.stem])
    citation = yaml.safe_load(Path(job.input.citation).read_text(encoding="utf-8"))
    material = article.Material(
        settings=job.params.settings,
        claims=Path(job.input.claims),
        estimates=Path(job.input.estimates),
        figures=figures,
        authors=tuple(article.name_of(each) for each in citation["authors"]),
    )
    article.write(Path(job.output[0]), material)


if __name__ == "__main__":
    scripting.run(main, snakemake)

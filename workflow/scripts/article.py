"""Set the article."""

from pathlib import Path
from typing import TYPE_CHECKING

import yaml

from beltrepro.replication.plan import inputs, scripting
from beltrepro.replication.report import article
from beltrepro.replication.report.material import Material

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main(job):
    files = {
        "claims": [Path(job.input.claims)],
        "estimates": [Path(job.input.estimates)],
        "figures": [Path(path) for path in job.input.figures],
    }
    for name, by_stem in job.params.expected.items():
        for path in files[name]:
            inputs.check(path, by_stem[path.stem])
    citation = yaml.safe_load(Path(job.input.citation).read_text(encoding="utf-8"))
    material = Material(job.params.settings["preset"], job.params.settings, files)
    authors = [article.name_of(author) for author in citation["authors"]]
    article.write(Path(job.output[0]), material, authors)


if __name__ == "__main__":
    scripting.run(main, snakemake)

"""Join the files of the jobs of one scan or ensemble into one file."""

import json
from typing import TYPE_CHECKING

from beltrepro import scripting, store

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def join(parts: list, settings: dict, output) -> None:
    """Join files along their first axis.

    settings : describes the whole and replaces the settings of the single jobs.
    """
    whole = store.join([store.read(part) for part in parts])
    attributes = whole.attributes | {
        "method": settings["method"],
        "config": json.dumps(settings, sort_keys=True),
    }
    store.write(output, whole.arrays, attributes)


def main(job):
    join(list(job.input), job.params.settings, job.output[0])


if __name__ == "__main__":
    scripting.run(main, snakemake)

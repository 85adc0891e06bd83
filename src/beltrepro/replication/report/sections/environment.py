"""Code, libraries, machines and constants behind the datasets."""

import os

from beltrepro.replication.report.material import distinct

TITLE = "Environment"
ANCHOR = "environment"
NEEDS = ()

_KEYS = ("code_version", "processor", "libraries", "seed", "time_step")


def gather(material) -> dict:
    """Texts by name; several values where datasets differ."""
    found = {key: "; ".join(distinct(each[key] for each in material.datasets)) for key in _KEYS}
    return found | {
        "cores": os.cpu_count(),
        "preset": material.preset,
        "constants": material.settings["model"],
        "laminar_time": material.settings["defaults"]["laminar_time"],
    }

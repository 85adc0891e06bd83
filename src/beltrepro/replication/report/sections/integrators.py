"""Whether two integrators agree: sentences and tables, and the figures of the comparison."""

from beltrepro.replication.studies.integrators import words as agreement

TITLE = "Integrators compared"
ANCHOR = "agreement"
CATEGORY = "Integrators compared"
NEEDS = ("agreement", "families", "partings", "convergence")


def gather(material) -> dict:
    """Sentences by part, rows of the tables, pictures."""
    tables = agreement.Tables(*(material.file(name) for name in NEEDS))
    described = agreement.describe(tables, material.settings)
    return described | {"figures": material.pictures_of(CATEGORY)}

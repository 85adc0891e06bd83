"""The figures of the paper, each with the claims that it shows, and those of further studies."""

from beltrepro.replication.report.sections import chaos, inference, integrators

TITLE = "Figures"
ANCHOR = "figures"
NEEDS = ("figures",)


def gather(material) -> dict:
    """Pictures with title, words and claims, and whether a section is on the films.

    A study that another section shows is left to it.
    """
    elsewhere = {
        name
        for section in (chaos, inference)
        if material.has(section.NEEDS)
        for name in section.PICTURES
    }
    studies = material.pictures_of("Further studies")
    return {
        "figures": material.pictures_of("Figures of the paper"),
        "studies": [each for each in studies if each["name"] not in elsewhere],
        "filmed": material.has(("recordings",)),
    }


def on_page(material) -> list[dict]:
    """The pictures that a section of the page shows, so that links to them lead somewhere."""
    compared = material.has(integrators.NEEDS)
    return [
        each for each in material.pictures if compared or each["category"] != integrators.CATEGORY
    ]

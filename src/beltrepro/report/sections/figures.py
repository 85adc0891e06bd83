"""The figures of the paper, each with the claims that it shows, and those of further studies."""

TITLE = "Figures"
ANCHOR = "figures"
NEEDS = ("figures",)


def gather(material) -> dict:
    """Pictures with title, words and claims, and whether a section is on the films."""
    return {
        "figures": material.pictures_of("Figures of the paper"),
        "studies": material.pictures_of("Further studies"),
        "filmed": material.has(("recordings",)),
    }

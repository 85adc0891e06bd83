"""Verdicts of this run beside those of other runs."""

TITLE = "Other presets"
ANCHOR = "presets"
NEEDS = ("claims", "estimates", "compared")


def gather(material) -> dict:
    """The comparison, and the name of this run's preset."""
    return {"comparison": material.comparison, "preset": material.preset}

"""What was run: a row for each dataset."""

TITLE = "What was run"
ANCHOR = "runs"
NEEDS = ()


def gather(material) -> dict:
    """Rows of plain values, from the attributes of the datasets."""
    return {"runs": material.datasets}

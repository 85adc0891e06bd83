"""What was run: a row for each dataset; and audits of some runs."""

import pandas as pd

from beltrepro.replication.report.material import Material

TITLE = "What was run"
ANCHOR = "runs"
NEEDS = ()

_DIGITS = {
    "energy_residual": ".1e",
    "wrong_way": ".2g",
    "overload": ".4g",
    "deviation": ".1e",
    "noise_ratio": ".3f",
    "noise_error": ".3f",
}


def gather(material: Material) -> dict:
    """Rows of plain values, from the attributes of the datasets and from audit.csv."""
    audits = []
    if material.has(["audit"]):
        audits = [_audit(row) for row in pd.read_csv(material.file("audit")).to_dict("records")]
    return {"runs": material.datasets, "audits": audits}


def _audit(row: dict) -> dict:
    """A row as text; what does not apply is empty."""
    found = {name: format(row[name], digits) for name, digits in _DIGITS.items()}
    return row | {name: "" if text == "nan" else text for name, text in found.items()}

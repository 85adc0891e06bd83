"""Tables of claims of a made-up run: every claim of the ledger, with all verdicts in turn."""

import math
from pathlib import Path

import pandas as pd

from beltrepro.replication.studies.every_claim import COLUMNS, ESTIMATE_COLUMNS
from beltrepro.replication.verdicts.criteria import Measurement, bounds, judge, show
from beltrepro.replication.verdicts.ledger import load_ledger
from beltrepro.stats.estimates import Estimate, sure

WHY = "the measured reason in words has number"
VERDICTS = ("holds", "fails", "partly", "undecided", "holds", "not measured", "holds")


def tables(verdicts=None) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Claims and estimates as `measure` makes them.

    verdicts : of single claims by id, in place of the one whose turn it is.
    """
    claims, estimates = [], []
    for index, claim in enumerate(load_ledger().values()):
        wanted = (verdicts or {}).get(claim.id, VERDICTS[index % len(VERDICTS)])
        if not claim.testable:
            wanted = "not testable here"
        readings = {"": wanted}
        if claim.open and wanted != "not measured":
            names = [*claim.changes, *(f"reading {k} of {index}" for k in range(1 + index % 3))]
            readings |= {name: VERDICTS[k % len(VERDICTS)] for k, name in enumerate(names)}
        for number, (variant, verdict) in enumerate(readings.items()):
            row, rows = _reading(claim, index, number, variant, verdict)
            claims.append(row)
            estimates += rows
    return (
        pd.DataFrame(claims, columns=list(COLUMNS)),
        pd.DataFrame(estimates, columns=list(ESTIMATE_COLUMNS)),
    )


def write(folder: Path, verdicts=None) -> tuple[Path, Path]:
    """Write both tables, and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = folder / "claims.csv", folder / "estimates.csv"
    for path, table in zip(paths, tables(verdicts), strict=True):
        table.to_csv(path, index=False, float_format="%.6g")
    return paths


def _reading(claim, index, number, variant, wanted):
    allowed = claim.criterion.get("allowed", {})
    estimates = {}
    if wanted not in ("not measured", "not testable here"):
        for place, (name, ends) in enumerate(allowed.items()):
            grade = wanted
            if wanted == "partly":
                grade = ("fails", "holds")[place > 0]
            estimates[name] = _estimate(grade, *bounds(ends), index + 10 * number, 8 + index)
    also = {f"also {index}": sure(-index)} if estimates else {}
    measurement = Measurement(estimates, also)
    judged = judge(claim.criterion if estimates else {}, measurement)
    verdict = judged.verdict if estimates else wanted
    reasons = {"not measured": f"this preset has no dataset_{index}"}
    reasons |= {"not testable here": claim.reason}
    row = {
        "id": claim.id,
        "figure": "" if claim.figure is None else str(claim.figure),
        "kind": claim.kind,
        "variant": variant,
        "statement": claim.statement,
        "paper": show(claim.paper),
        "measured": measurement.words,
        "runs": "" if measurement.runs is None else str(measurement.runs),
        "criterion": claim.criterion["text"],
        "verdict": verdict,
        "reason": judged.reason,
        "note": f"{WHY} {index}" if judged.reason else reasons.get(wanted, ""),
        "dataset": ", ".join(claim.needs),
    }
    rows = []
    for name, estimate in (estimates | also).items():
        low, high = bounds(allowed[name]) if name in allowed else (math.nan, math.nan)
        numbers = {key: getattr(estimate, key) for key in ("value", "low", "high", "runs")}
        ends = {"allowed_low": low, "allowed_high": high}
        grade = {"verdict": judged.components.get(name, "")}
        rows.append({"id": claim.id, "variant": variant, "name": name} | numbers | ends | grade)
    return row, rows


def _estimate(grade, low, high, index, runs):
    """An estimate that this range grades so; different for every claim."""
    if low == high:
        return sure(low if grade == "holds" else 1 - low)
    if math.isinf(low) and math.isinf(high):
        raise ValueError("a range without ends decides nothing")
    end, side = (high, -1) if math.isinf(low) else (low, 1)
    width = 1.0 if math.isinf(high - low) else high - low
    inside = side * width * (0.5 + 0.003 * (index % 50))
    centre = {"holds": end + inside, "fails": end - inside, "undecided": end}[grade]
    reach = 0.2 * width
    return Estimate(centre, centre - reach, centre + reach, runs)

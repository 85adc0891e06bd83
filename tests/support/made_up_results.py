"""Tables of claims of a made-up run: every claim of the ledger, with all verdicts in turn."""

import math
from pathlib import Path

import pandas as pd

from beltrepro.replication.plan import io
from beltrepro.replication.verdicts import measured
from beltrepro.replication.verdicts.criteria import Measurement, bounds, names_in
from beltrepro.replication.verdicts.ledger import load_ledger
from beltrepro.stats.estimates import Estimate, sure

MISSING = "missing"  # in place of a verdict: open, because this preset has no data
VERDICTS = ("yes", "no", "in part", "open", "yes", MISSING, "no")


def tables(verdicts=None) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Claims and estimates as `measure` makes them.

    verdicts : of single claims by id, in place of the one whose turn it is; a word for both
        questions, or words by question.
    """
    rows, estimates = [], []
    for index, claim in enumerate(load_ledger().values()):
        turn = {"replicated": VERDICTS[index % 7], "robust": VERDICTS[(index // 2 + 1) % 7]}
        asked = (verdicts or {}).get(claim.id, turn)
        wanted = asked if isinstance(asked, dict) else dict.fromkeys(turn, asked)
        readings, answers = {}, {}
        for question, criterion in claim.criteria.items():
            shared = question == "robust" and claim.robust == claim.replicated
            shared = shared and len({*wanted.values()}) == 1
            name = next(iter(readings)) if shared else f"{question} reading {index}"
            if not shared:
                readings[name] = _measurement(criterion, wanted[question], index, len(readings))
            named = type(criterion)(**vars(criterion) | {"reading": name})
            answers[question] = measured._judged(named, readings)
        if claim.testable:
            readings[f"another reading of {index}"] = Measurement({}, {"other": sure(index)})
        rows.append(measured._row(claim, answers, []))
        estimates += measured._estimates(claim, answers, readings)
    return pd.DataFrame(rows), pd.DataFrame(estimates)


def write(folder: Path, verdicts=None) -> tuple[Path, Path]:
    """Write both tables, and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = folder / "claims.csv", folder / "estimates.csv"
    for path, table in zip(paths, tables(verdicts), strict=True):
        io.write_table(path, table, title="Made up.", columns={}, sources={})
    return paths


def _measurement(criterion, wanted, index, place):
    """Numbers that get this verdict; different for every claim."""
    if wanted == MISSING:
        return f"this preset has no dataset_{index}"
    judged = {}
    for number, (name, allowed) in enumerate(criterion.allowed.items()):
        grade = wanted if wanted != "in part" else ("no", "yes")[number > 0]
        lenient = bounds(criterion.lenient.get(name, allowed))
        judged[name] = _estimate(grade, bounds(allowed), lenient, index + 10 * place, 8 + index)
    besides = {name: sure(0.5) for name in names_in(criterion.found) if name not in judged}
    return Measurement(judged, besides | {f"also {index}": sure(-index)}, f"note {index}")


def _estimate(grade, allowed, lenient, index, runs):
    """An estimate that this range grades so."""
    low, high = allowed
    if low == high in (0.0, 1.0):
        return {"yes": sure(low), "no": sure(1 - low), "open": Estimate(0.5, 0.0, 1.0, runs)}[grade]
    if math.isinf(low) and math.isinf(high):
        raise ValueError("a range without ends decides nothing")
    side = -1 if math.isinf(low) else 1
    end, beyond = (high, lenient[1]) if math.isinf(low) else (low, lenient[0])
    width = 1.0 if math.isinf(high - low) else high - low
    share = 0.3 + 0.003 * (index % 50)
    if grade == "open":
        return Estimate(end, beyond - side * width, end + side * 9 * width, runs) if side > 0 else (
            Estimate(end, end - 9 * width, beyond + width, runs))  # fmt: skip
    centre = end + side * width * share if grade == "yes" else beyond - side * width * share
    if math.isinf(centre):
        raise ValueError("nothing is wrong for a lenient reader")
    return Estimate(centre, centre - 0.2 * width, centre + 0.2 * width, runs)

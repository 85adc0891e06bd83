"""What a measurement is, and how a criterion of the ledger turns it into a verdict."""

import math
from dataclasses import dataclass, field

HOLDS = "holds"
PARTLY = "partly"
FAILS = "fails"
NOT_MEASURED = "not measured"
NOT_TESTABLE = "not testable here"
VERDICTS = (HOLDS, PARTLY, FAILS, NOT_MEASURED, NOT_TESTABLE)


@dataclass(frozen=True)
class Measurement:
    """What a claim function found.

    value : number, or a dict of numbers or (low, high) pairs by name; compared with the paper's
        under a numeric criterion. uncertainty : standard error, of the same form, or None.
    sample_size : how many slips, points, members ... it rests on. checks : named yes/no findings.
    note : what a reader should know.
    """

    value: object = None
    uncertainty: object = None
    sample_size: int | None = None
    checks: dict[str, bool] = field(default_factory=dict)
    note: str = ""


def judge(criterion: dict, paper, measurement: Measurement) -> tuple[str, str]:
    """Verdict of one measurement, with the reason where the data cannot decide.

    - exact, absolute, relative: each component holds within the tolerance `holds` of the printed
      value and is partly right within `partly` or two standard errors, whichever is larger. If a
      standard error exceeds `partly`, the claim is not measured.
    - interval: the value lies in `range`, or partly in the wider `partly`.
    - checks of any criterion each count as a component that holds or fails.
    All components hold: "holds"; all fail: "fails"; anything between: "partly".
    """
    if criterion["type"] == "none":
        return NOT_TESTABLE, ""
    grades = [HOLDS if passed else FAILS for passed in measurement.checks.values()]
    if criterion["type"] in ("exact", "absolute", "relative"):
        values, printed = components(measurement.value), components(paper)
        errors = components(measurement.uncertainty)
        for name, target in printed.items():
            scale = abs(target) if criterion["type"] == "relative" else 1.0
            holds = scale * _tolerance(criterion["holds"], name)
            partly = scale * _tolerance(criterion.get("partly", criterion["holds"]), name)
            error = errors.get(name, 0.0)
            error = error if math.isfinite(error) else 0.0
            if error > max(partly, holds) > 0:
                return NOT_MEASURED, (
                    f"standard error {error:.2g} exceeds the tolerance {max(partly, holds):.2g}"
                )
            distance = abs(values[name] - target)
            grades.append(_grade(distance <= holds, distance <= max(partly, 2 * error)))
    elif criterion["type"] == "interval":
        for value in components(measurement.value).values():
            grades.append(
                _grade(
                    _inside(value, criterion["range"]),
                    _inside(value, criterion.get("partly", criterion["range"])),
                )
            )
    if not grades:
        return NOT_MEASURED, "nothing to judge"
    return (grades[0] if len(set(grades)) == 1 else PARTLY), ""


def components(value) -> dict[str, float]:
    """Numbers of a value (number, pair, or dict of these) by a name; {} for None."""
    if value is None:
        return {}
    if isinstance(value, dict):
        return {
            f"{key} {name}".strip(): number
            for key, inner in value.items()
            for name, number in components(inner).items()
        }
    if isinstance(value, (list, tuple)):
        return {("low", "high")[place]: float(number) for place, number in enumerate(value)}
    return {"": float(value)}


def show(value, digits=4) -> str:
    """A value as short text: "low to high" for pairs, "name: value; ..." for dicts, "" for None."""
    if value is None:
        return ""
    if isinstance(value, dict):
        return "; ".join(f"{name}: {show(inner, digits)}" for name, inner in value.items())
    if isinstance(value, (list, tuple)):
        return " to ".join(show(inner, digits) for inner in value)
    return "not found" if math.isnan(value) else f"{value:.{digits}g}"


def _tolerance(tolerance, name: str) -> float:
    return float(tolerance[name]) if isinstance(tolerance, dict) else float(tolerance)


def _inside(value, interval):
    return interval[0] <= value <= interval[1]


def _grade(holds, partly):
    return HOLDS if holds else PARTLY if partly else FAILS

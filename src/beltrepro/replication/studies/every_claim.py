"""Measure every claim of the ledger."""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import chain

import pandas as pd

from beltrepro.replication.plan import registry
from beltrepro.replication.studies.avalanches import claims as avalanches
from beltrepro.replication.studies.chaos import claims as motion
from beltrepro.replication.studies.experiment import claims as experiment
from beltrepro.replication.studies.experiment import claims_noise as noise_of_experiment
from beltrepro.replication.studies.integrators import claims as integrators
from beltrepro.replication.studies.laws import claims as model
from beltrepro.replication.studies.noise import claims as transition_with_noise
from beltrepro.replication.studies.noise import claims_intermittency as intermittency
from beltrepro.replication.studies.sizes import claims as system_size
from beltrepro.replication.studies.sizes import claims_motion as motion_of_sizes
from beltrepro.replication.studies.sizes import claims_noise as noise_and_size
from beltrepro.replication.studies.transition import claims as transition_without_noise
from beltrepro.replication.studies.transition import claims_motion as without_noise
from beltrepro.replication.studies.transition import claims_transients as transients
from beltrepro.replication.verdicts.criteria import (
    FEW_RUNS,
    NOT_MEASURED,
    Judgement,
    Measurement,
    bounds,
    judge,
    show,
)
from beltrepro.replication.verdicts.evidence import Evidence
from beltrepro.replication.verdicts.ledger import REGISTRY, Claim, load_ledger
from beltrepro.stats.errors import NotEnoughDataError

SECTIONS = (
    model,
    experiment,
    without_noise,
    transition_without_noise,
    avalanches,
    motion,
    transients,
    transition_with_noise,
    intermittency,
    noise_of_experiment,
    motion_of_sizes,
    system_size,
    noise_and_size,
    integrators,
)
COLUMNS = (
    "id",
    "figure",
    "kind",
    "variant",
    "statement",
    "paper",
    "measured",
    "runs",
    "criterion",
    "verdict",
    "reason",
    "note",
    "dataset",
)
ESTIMATE_COLUMNS = (
    "id",
    "variant",
    "name",
    "value",
    "low",
    "high",
    "runs",
    "allowed_low",
    "allowed_high",
    "verdict",
    "figures",
)

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Measured:
    """Claims with their verdicts, and the numbers that these rest on.

    claims : one row per claim in the order of the ledger, and below it one row per further reading
        of an open point, with the reading in `variant` (empty for the one that counts). All cells
        are text. Columns COLUMNS.
    estimates : one row per number of each of these, with its interval, the range that is allowed
        for it (NaN if none is), what that makes of it, and the figures that show it. Columns
        ESTIMATE_COLUMNS.
    """

    claims: pd.DataFrame
    estimates: pd.DataFrame


def measure(datasets: dict, settings: dict) -> Measured:
    """Measured values and verdict of every claim.

    Only the reading that counts gives the verdict of a claim; other readings have their own.
    """
    evidence = Evidence(datasets, settings)
    rows = [_rows(evidence, name) for name in load_ledger()]
    claims, estimates = (list(chain.from_iterable(each)) for each in zip(*rows, strict=True))
    return Measured(
        pd.DataFrame(claims, columns=list(COLUMNS)),
        pd.DataFrame(estimates, columns=list(ESTIMATE_COLUMNS)),
    )


def _rows(evidence: Evidence, name: str) -> tuple[list[dict], list[dict]]:
    """Rows of a claim in both tables, for all its readings."""
    claim = load_ledger()[name]
    evidence.start(claim)
    claims, estimates = [], []
    for variant, reading in _readings(claim, evidence).items():
        found = _judged(claim, variant, reading)
        claims.append(_row(found, evidence))
        estimates += _estimate_rows(found)
    return claims, estimates


@dataclass(frozen=True)
class _Judged:
    """A claim in one reading."""

    claim: Claim
    variant: str
    measurement: Measurement
    judgement: Judgement
    note: str


def _readings(claim: Claim, evidence: Evidence) -> dict[str, Callable[[], Measurement]]:
    """Readings as functions, the one that counts first and without a name.

    A claim function that finds no data is a reading that says so.
    """
    function = REGISTRY.get(claim.id, lambda evidence: Measurement())
    try:
        found = function(evidence)
    except Exception as error:
        return {"": partial(_raise, error)}
    if not isinstance(found, dict):
        return {"": lambda: found}
    first, *others = found
    return {"": found[first]} | {name: found[name] for name in others}


def _judged(claim: Claim, variant: str, reading: Callable[[], Measurement]) -> _Judged:
    try:
        measurement = reading()
        judgement = judge(claim.criterion, measurement)
    except NotEnoughDataError as error:
        return _Judged(claim, variant, Measurement(), Judgement(NOT_MEASURED), str(error))
    except Exception as error:  # a fault in one claim must not cost the rest of a long run
        logger.exception("claim %s", claim.id)
        reason = f"fault in its code, see the log: {type(error).__name__}: {error}"
        return _Judged(claim, variant, Measurement(), Judgement(NOT_MEASURED), reason)
    runs = measurement.runs
    few = f"rests on {runs} run{'s' * (runs > 1)}" if runs and runs < FEW_RUNS else ""
    # Why there is nothing to test against comes first, then what was found all the same.
    note = _joined(claim.reason, measurement.note, few)
    return _Judged(claim, variant, measurement, judgement, note)


def _raise(error: Exception) -> Measurement:
    raise error


def _row(found: _Judged, evidence: Evidence) -> dict[str, str]:
    claim, runs = found.claim, found.measurement.runs
    return {
        "id": claim.id,
        "figure": "" if claim.figure is None else str(claim.figure),
        "kind": claim.kind,
        "variant": found.variant,
        "statement": claim.statement,
        "paper": show(claim.paper),
        "measured": found.measurement.words,
        "runs": "" if runs is None else str(runs),
        "criterion": claim.criterion["text"],
        "verdict": found.judgement.verdict,
        "reason": found.judgement.reason,
        "note": found.note,
        "dataset": ", ".join(evidence.used or claim.needs),
    }


def _estimate_rows(found: _Judged) -> list[dict[str, object]]:
    allowed = found.claim.criterion.get("allowed", {})
    rows: list[dict[str, object]] = []
    for name, each in (found.measurement.judged | found.measurement.also).items():
        own = name in allowed and name in found.measurement.judged
        low, high = bounds(allowed[name]) if own else (float("nan"), float("nan"))
        rows.append(
            {
                "id": found.claim.id,
                "variant": found.variant,
                "name": name,
                "value": each.value,
                "low": each.low,
                "high": each.high,
                "runs": each.runs,
                "allowed_low": low,
                "allowed_high": high,
                "verdict": found.judgement.components.get(name, "") if own else "",
                "figures": ", ".join(registry.figures_with(found.claim.id, found.variant, name)),
            }
        )
    return rows


def _joined(*parts: str) -> str:
    return ". ".join(dict.fromkeys(part for part in parts if part))

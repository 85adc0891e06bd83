"""Measure every claim of the ledger."""

import logging
from dataclasses import dataclass, replace
from functools import partial

import pandas as pd

from beltrepro.analysis.errors import NotEnoughDataError
from beltrepro.claims import experiment, model, motion, system_size, with_noise, without_noise
from beltrepro.claims.criteria import (
    FAILS,
    HOLDS,
    NOT_MEASURED,
    PARTLY,
    Measurement,
    judge,
    show,
)
from beltrepro.claims.evidence import Evidence
from beltrepro.claims.ledger import Claim, load_ledger
from beltrepro.claims.registry import REGISTRY

SECTIONS = (model, experiment, without_noise, motion, with_noise, system_size)
COLUMNS = (
    "id",
    "figure",
    "variant",
    "statement",
    "paper",
    "measured",
    "uncertainty",
    "sample_size",
    "criterion",
    "verdict",
    "note",
    "dataset",
)

logger = logging.getLogger(__name__)


def measure(datasets: dict, settings: dict) -> pd.DataFrame:
    """Measured value and verdict of every claim.

    Parameters
    ----------
    datasets : `store.Dataset` by name, a series of one point as that run, and the tracks of films,
        `experiment.Track`, by the name of the film and "_track"; missing ones make the claims that
        need them "not measured".
    settings : the resolved configuration of the preset as plain values.

    Returns
    -------
    One row per claim in the order of the ledger, and below it one row per further reading of an
    open point, with the reading in `variant` (empty for the one that counts). A claim whose counted
    reading fails while another one holds is "partly", and its note says which. All cells are text.
    """
    evidence = Evidence(datasets, settings)
    rows = []
    for claim in load_ledger().values():
        rows += _claim_rows(claim, evidence)
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _claim_rows(claim: Claim, evidence: Evidence) -> list[dict]:
    evidence.start(claim)
    readings = _readings(claim, evidence)
    judged = {name: _judged(claim, reading) for name, reading in readings.items()}
    counted, *variants = judged
    holding = [name for name in variants if judged[name].verdict == HOLDS]
    if judged[counted].verdict == FAILS and holding:
        note = f"fails in the reading that counts, holds for: {'; '.join(holding)}"
        judged[counted] = replace(
            judged[counted], verdict=PARTLY, note=_joined(note, judged[counted].note)
        )
    rows = [_row(claim, "", judged[counted], evidence)]
    return rows + [_row(claim, name, judged[name], evidence) for name in variants]


@dataclass(frozen=True)
class _Judged:
    measurement: Measurement
    verdict: str
    note: str


def _readings(claim, evidence) -> dict:
    """Readings as functions; a claim function that finds no data is a reading that says so."""
    function = REGISTRY.get(claim.id, lambda evidence: Measurement())
    try:
        found = function(evidence)
    except Exception as error:
        return {"": partial(_raise, error)}
    return found if isinstance(found, dict) else {"": lambda: found}


def _judged(claim, reading) -> _Judged:
    try:
        measurement = reading()
    except NotEnoughDataError as error:
        return _Judged(Measurement(), NOT_MEASURED, str(error))
    except Exception as error:  # a fault in one claim must not cost the rest of a long run
        logger.exception("claim %s", claim.id)
        reason = f"fault in its code, see the log: {type(error).__name__}: {error}"
        return _Judged(Measurement(), NOT_MEASURED, reason)
    verdict, reason = judge(claim.criterion, claim.paper, measurement)
    failed = [name for name, passed in measurement.checks.items() if not passed]
    failed = f"not met: {'; '.join(failed)}" if failed else ""
    # Why there is nothing to test against comes first, then what was found all the same.
    return _Judged(measurement, verdict, _joined(claim.reason, reason, measurement.note, failed))


def _raise(error):
    raise error


def _row(claim: Claim, variant: str, judged: _Judged, evidence: Evidence) -> dict:
    measurement = judged.measurement
    kind = f"{claim.criterion['type']}: " if claim.testable else ""
    size = measurement.sample_size
    return {
        "id": claim.id,
        "figure": "" if claim.figure is None else str(claim.figure),
        "variant": variant,
        "statement": claim.statement,
        "paper": show(claim.paper),
        "measured": show(measurement.value) or _passed(measurement.checks),
        "uncertainty": show(measurement.uncertainty, digits=2),
        "sample_size": "" if size is None else str(int(size)),
        "criterion": f"{kind}{claim.criterion['text']}",
        "verdict": judged.verdict,
        "note": judged.note,
        "dataset": ", ".join(evidence.used or claim.needs),
    }


def _passed(checks: dict[str, bool]) -> str:
    return f"{sum(checks.values())} of {len(checks)} checks met" if checks else ""


def _joined(*parts: str) -> str:
    return ". ".join(dict.fromkeys(part for part in parts if part))

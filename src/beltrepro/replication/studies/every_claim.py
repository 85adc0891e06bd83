"""Measure every claim of the ledger."""

import logging
import math
from collections.abc import Callable
from itertools import chain
from typing import NamedTuple

import pandas as pd

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.plan import registry
from beltrepro.replication.studies.avalanches import claims as avalanches
from beltrepro.replication.studies.chaos import claims as chaos
from beltrepro.replication.studies.experiment import claims as experiment
from beltrepro.replication.studies.experiment import claims_noise as noise_of_experiment
from beltrepro.replication.studies.integrators import claims as integrators
from beltrepro.replication.studies.laws import claims as laws
from beltrepro.replication.studies.noise import claims as noise
from beltrepro.replication.studies.sizes import claims as sizes
from beltrepro.replication.studies.transition import claims as transition
from beltrepro.replication.verdicts import criteria
from beltrepro.replication.verdicts.criteria import NOT_MEASURED, Judgement, Measurement
from beltrepro.replication.verdicts.evidence import Evidence
from beltrepro.replication.verdicts.ledger import REGISTRY, Claim, load_ledger

# Importing them registers the functions of their claims.
STUDIES = (
    *(avalanches, chaos, experiment, noise_of_experiment, integrators),
    *(laws, noise, sizes, transition),
)
COLUMNS = (
    "id", "figure", "kind", "variant", "statement", "paper", "measured", "runs", "criterion",
    "verdict", "reason", "note", "dataset",
)  # fmt: skip
ESTIMATE_COLUMNS = (
    "id", "variant", "name", "value", "low", "high", "runs", "allowed_low", "allowed_high",
    "verdict", "figures",
)  # fmt: skip

logger = logging.getLogger(__name__)


class Measured(NamedTuple):
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
    """Measured values and verdict of every claim, of each reading by itself."""
    evidence = Evidence(datasets, settings)
    rows = [rows_of for claim in load_ledger().values() for rows_of in _rows(evidence, claim)]
    claims, estimates = zip(*rows, strict=True)
    return Measured(
        pd.DataFrame(claims, columns=list(COLUMNS)),
        pd.DataFrame(chain.from_iterable(estimates), columns=list(ESTIMATE_COLUMNS)),
    )


def _rows(evidence: Evidence, claim: Claim) -> list[tuple[dict, list[dict]]]:
    """Rows of a claim in both tables, for each reading; the one that counts has no name."""
    evidence.start(claim)
    function = REGISTRY.get(claim.id, lambda evidence: Measurement())
    measurement, *outcome = _tried(claim, lambda: function(evidence))
    if not isinstance(measurement, dict):
        return [_rows_of_reading(evidence, claim, "", measurement, *outcome)]
    return [
        _rows_of_reading(evidence, claim, name if number else "", *_tried(claim, reading))
        for number, (name, reading) in enumerate(measurement.items())
    ]


def _tried(claim: Claim, reading: Callable) -> tuple[Measurement | dict, Judgement, str]:
    """What a reading measures, the verdict, and the reason if it measures nothing.

    The function of a claim may return its readings by name instead.
    """
    try:
        measurement = reading()
        if isinstance(measurement, dict):
            return measurement, Judgement(""), ""
        return measurement, criteria.judge(claim.criterion, measurement), ""
    except NotEnoughDataError as error:
        reason = str(error)
    except Exception as error:  # a fault in one claim must not cost the rest of a long run
        logger.exception("claim %s", claim.id)
        reason = f"fault in its code, see the log: {type(error).__name__}: {error}"
    return Measurement(), Judgement(NOT_MEASURED), reason


def _rows_of_reading(
    evidence: Evidence,
    claim: Claim,
    variant: str,
    measurement: Measurement,
    judgement: Judgement,
    missing: str,
) -> tuple[dict[str, str], list[dict[str, object]]]:
    runs = measurement.runs
    few = f"rests on {runs} run{'s' * (runs > 1)}" if runs and runs < criteria.FEW_RUNS else ""
    # Why there is nothing to test against comes first, then what was found all the same.
    notes = (missing,) if missing else (claim.reason, measurement.note, few)
    row = {
        "id": claim.id,
        "figure": "" if claim.figure is None else str(claim.figure),
        "kind": claim.kind,
        "variant": variant,
        "statement": claim.statement,
        "paper": criteria.show(claim.paper),
        "measured": measurement.words,
        "runs": "" if runs is None else str(runs),
        "criterion": claim.criterion["text"],
        "verdict": judgement.verdict,
        "reason": judgement.reason,
        "note": ". ".join(dict.fromkeys(filter(None, notes))),
        "dataset": ", ".join(evidence.used or claim.needs),
    }
    allowed = claim.criterion.get("allowed", {})
    ranges = {name: criteria.bounds(allowed[name]) for name in measurement.judged.keys() & allowed}
    estimates = [
        {
            "id": claim.id,
            "variant": variant,
            "name": name,
            **{key: getattr(estimate, key) for key in ("value", "low", "high", "runs")},
            **dict(zip(ESTIMATE_COLUMNS[7:9], ranges.get(name, (math.nan, math.nan)), strict=True)),
            "verdict": judgement.components.get(name, ""),
            "figures": ", ".join(registry.figures_with(claim.id, variant, name)),
        }
        for name, estimate in (measurement.judged | measurement.also).items()
    ]
    return row, estimates

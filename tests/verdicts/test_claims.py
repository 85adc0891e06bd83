"""Claims: the ledger is whole, and measuring all of it takes whatever data there are."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

import figure_data
from alternating import experiments
from beltrepro.base.store import Dataset
from beltrepro.replication.plan import io
from beltrepro.replication.studies.every_claim import measure
from beltrepro.replication.verdicts import evidence
from beltrepro.replication.verdicts.criteria import NOT_TESTABLE, OPEN, QUESTIONS, YES, bounds
from beltrepro.replication.verdicts.ledger import KINDS, REGISTRY, load_ledger
from made_up import SETTINGS, few_resamples  # noqa: F401

ROOT = Path(__file__).parents[2]
LEDGER = load_ledger()
# `figure_data` has none of these, or lacks columns that claims read, and figures do not.
LACKING = ("belt_", "pairs_", "noise_steps", "noisy_motion")


def made_up(names, *, every=1):
    """Datasets by name, of each so many points, runs or events."""
    data = {name: figure_data.dataset(name) for name in names} | experiments([1.0, 2.0], runs=9)
    for name, dataset in data.items():
        if dataset.attributes.get("kind") != "series":
            method = np.full(len(next(iter(dataset.arrays.values()))), "verlet")
            arrays = {"method": method} | dataset.arrays
            arrays = {key: values[: len(values) // every] for key, values in arrays.items()}
            data[name] = Dataset(arrays, dataset.attributes)
    return data


def needed():
    """All that claims need but films, pairs of trajectories, and what figures do not show."""
    names = {name for claim in LEDGER.values() for name in claim.needs}
    return sorted(name for name in names if not name.startswith(LACKING) and _can_be_made(name))


def _can_be_made(name):
    try:
        return bool(figure_data.dataset(name))
    except KeyError:
        return False


# --- ledger ---------------------------------------------------------------------------------------


def test_every_claim_has_a_function():
    assert {claim.id for claim in LEDGER.values() if claim.testable} <= set(REGISTRY) <= set(LEDGER)
    assert {claim.kind for claim in LEDGER.values()} <= set(KINDS)


def test_every_criterion_can_come_out_both_ways():
    for criterion in (one for claim in LEDGER.values() for one in claim.criteria.values()):
        assert bool(criterion.untestable) != bool(criterion.allowed) and criterion.tried >= 1
        assert criterion.lenient.keys() <= criterion.allowed.keys()
        for name, allowed in criterion.allowed.items():
            low, high = bounds(allowed)
            widest = bounds(criterion.lenient.get(name, allowed))
            assert widest[0] <= low <= high <= widest[1], name
            assert math.isfinite(widest[0]) or math.isfinite(widest[1]), name


def test_the_datasets_that_claims_need_are_in_the_configuration():
    config = yaml.safe_load((ROOT / "config.yaml").read_text())
    expected = set(config["datasets"]) | {f"{film}_track" for film in config["films"]}
    assert {name for claim in LEDGER.values() for name in claim.needs} <= expected


# --- made-up data -------------------------------------------------------------------------------


def assert_layout(measured):
    claims, estimates = measured
    for name, table in (("claims", claims), ("estimates", estimates)):
        published = io.read_table(ROOT / f"docs/results/paper/{name}.csv", nrows=0)
        assert list(table) == list(published)
    assert list(claims["id"]) == list(LEDGER)
    assert claims.map(lambda cell: isinstance(cell, str)).all(axis=None)
    judged = estimates[estimates["verdict"] != ""]
    assert judged["allowed_low"].notna().all() and (judged["decides"] != "").all()
    for row in claims.to_dict("records"):
        for question in QUESTIONS:
            decide = judged[(judged["id"] == row["id"]) & judged["decides"].str.contains(question)]
            assert set(decide["reading"]) <= {row[f"{question}_reading"]}
            criterion = getattr(LEDGER[row["id"]], question)
            assert row[question] in (OPEN, NOT_TESTABLE) or list(decide["name"]) == list(
                criterion.allowed
            )
            assert "nan" not in re.findall(r"[a-z]+", row[f"{question}_found"])


@pytest.mark.thorough
def test_the_tables_have_the_promised_layout(monkeypatch):
    monkeypatch.setattr(evidence, "SETTLED_TRANSIENT", 0.0)
    assert_layout(measure(made_up(needed()), SETTINGS))


# --- too little data ------------------------------------------------------------------------------


def test_without_datasets_all_but_the_model_is_open():
    measured = measure({}, SETTINGS)
    assert_layout(measured)
    model = {"units", "friction-constants", "spring-law", "setup"}
    formula = {("scheme-order", "replicated")}
    for row in measured.claims.to_dict("records"):
        for question, criterion in LEDGER[row["id"]].criteria.items():
            sure = row["id"] in model or (row["id"], question) in formula
            wanted = YES if sure else NOT_TESTABLE if criterion.untestable else OPEN
            assert row[question] == wanted, row["id"]
            assert wanted == YES or row[f"{question}_found"] == row[f"{question}_reason"] != ""


def test_short_runs_are_not_judged():
    claims = measure(made_up(figure_data.SCANS), SETTINGS).claims.set_index("id")
    scans = claims.loc[["u-critical", "uc-sigma22", "transition-width"]]
    assert set(scans["replicated"]) == set(scans["robust"]) == {OPEN}
    assert scans["robust_reason"].str.contains("discards a transient of 500").any()


@pytest.mark.parametrize("every", [17, 10**9])
def test_tiny_and_empty_datasets_cause_no_fault(every, monkeypatch):
    monkeypatch.setattr(evidence, "SETTLED_TRANSIENT", 0.0)
    measure(made_up(needed(), every=every), SETTINGS)

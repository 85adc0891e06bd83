"""Claims: the ledger is whole, and measuring all of it takes whatever data there are."""

import datetime
from pathlib import Path

import numpy as np
import pytest
import yaml

import figure_data
from alternating import experiments
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.every_claim import COLUMNS, ESTIMATE_COLUMNS, measure
from beltrepro.replication.verdicts import evidence
from beltrepro.replication.verdicts.criteria import (
    HOLDS,
    NOT_MEASURED,
    bounds,
)
from beltrepro.replication.verdicts.ledger import KINDS, REGISTRY, SECTIONS, load_ledger
from made_up import SETTINGS, few_resamples  # noqa: F401

CONFIG = Path(__file__).parents[2] / "config.yaml"
# Those of `figure_data` lack columns that claims read, and figures do not.
LACKING = {"noise_steps", "noisy_motion", "steps"}


def made_up(names, *, every=1):
    """Datasets by name, of each so many points, runs or events."""
    data = {name: figure_data.dataset(name) for name in names} | experiments([1.0, 2.0], runs=9)
    for name, each in data.items():
        if each.attributes.get("kind") != "series":
            method = np.full(len(next(iter(each.arrays.values()))), "verlet")
            arrays = {"method": method} | each.arrays
            arrays = {key: values[: len(values) // every] for key, values in arrays.items()}
            data[name] = Dataset(arrays, each.attributes)
    return data


def needed():
    """All that claims need but films and pairs of trajectories."""
    names = {name for claim in load_ledger().values() for name in claim.needs} - LACKING
    return sorted(name for name in names if not name.startswith(("belt_", "stage_", "pairs_")))


def verdicts(measured):
    counted = measured.claims[measured.claims["variant"] == ""]
    return dict(zip(counted["id"], counted["verdict"], strict=True))


# --- ledger ---------------------------------------------------------------------------------------


def test_every_claim_has_a_function_in_the_module_of_its_section():
    ledger = load_ledger()
    assert set(REGISTRY) <= set(ledger)
    for claim in ledger.values():
        assert claim.kind in KINDS
        if claim.testable:
            study = SECTIONS[claim.section].split("/")[0]
            module = f"beltrepro.replication.studies.{study}.claims"
            assert REGISTRY[claim.id].__module__.startswith(module)
        assert bool(claim.open) == bool(claim.reading)
        assert claim.testable or claim.id in REGISTRY or claim.reason


def test_every_criterion_can_hold_and_can_fail_and_says_when_it_was_written():
    for claim in load_ledger().values():
        criterion = claim.criterion
        assert criterion.keys() <= {"allowed", "text", "version", "since", "changed"}, claim.id
        assert criterion["text"]
        if not claim.testable:
            continue
        assert isinstance(criterion["since"], datetime.date) and criterion["version"] >= 1
        assert criterion["version"] == 1 or criterion["changed"], claim.id
        ends = [bounds(allowed) for allowed in criterion["allowed"].values()]
        assert all(low <= high and (low, high) != (-np.inf, np.inf) for low, high in ends), claim.id


def test_the_datasets_that_claims_need_are_in_the_configuration():
    config = yaml.safe_load(CONFIG.read_text())
    known = set(config["datasets"]) | {f"{film}_track" for film in config["films"]}
    needed = {name for claim in load_ledger().values() for name in claim.needs}
    assert needed <= known


def test_what_is_true_by_construction_is_marked():
    marked = {claim.id for claim in load_ledger().values() if not claim.finding}
    assert marked == {"units", "friction-constants", "spring-law", "friction-law", "setup"}


# --- made-up data -------------------------------------------------------------------------------


@pytest.mark.thorough
def test_the_tables_have_the_promised_layout(monkeypatch):
    monkeypatch.setattr(evidence, "SETTLED_TRANSIENT", 0.0)
    claims, estimates = found = measure(made_up(needed()), SETTINGS)
    assert_no_fault(found)
    assert list(claims.columns) == list(COLUMNS)
    assert list(estimates.columns) == list(ESTIMATE_COLUMNS)
    assert list(claims.loc[claims["variant"] == "", "id"]) == list(load_ledger())
    assert claims.map(lambda cell: isinstance(cell, str)).all(axis=None)
    judged = estimates[estimates["verdict"] != ""]
    assert judged["allowed_low"].notna().all() and set(judged["id"]) <= set(claims["id"])
    measured = claims[(claims["variant"] == "") & ~claims["verdict"].isin([NOT_MEASURED])]
    ledger = load_ledger()
    for claim in map(ledger.get, measured["id"]):
        own = judged[(judged["id"] == claim.id) & (judged["variant"] == "")]
        assert list(own["name"]) == list(claim.criterion.get("allowed", {})), claim.id


# --- too little data ------------------------------------------------------------------------------


def assert_no_fault(measured):
    notes = measured.claims["note"]
    assert not notes.str.contains("fault in its code").any(), notes.tolist()


def test_without_datasets_all_but_the_model_is_not_measured():
    found = measure({}, SETTINGS)
    assert_no_fault(found)
    model = {"units", "friction-constants", "spring-law", "setup"}
    for name, verdict in verdicts(found).items():
        assert verdict == (HOLDS if name in model else NOT_MEASURED), name
    claims = found.claims
    assert (claims.loc[claims["verdict"] == NOT_MEASURED, "note"] != "").all()


def test_short_runs_are_not_judged():
    found = measure(made_up(figure_data.SCANS), SETTINGS)
    assert_no_fault(found)
    scans = found.claims.set_index("id").loc[["u-critical", "uc-sigma22", "transition-width"]]
    assert set(scans["verdict"]) == {NOT_MEASURED}
    assert scans["note"].str.contains("discards a transient of 500").any()


@pytest.mark.parametrize("every", [17, 10**9])
def test_tiny_and_empty_datasets_cause_no_fault(every, monkeypatch):
    monkeypatch.setattr(evidence, "SETTLED_TRANSIENT", 0.0)
    assert_no_fault(measure(made_up(needed(), every=every), SETTINGS))

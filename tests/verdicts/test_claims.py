"""Claims: the ledger is whole, and measuring all of it takes whatever data there are."""

import datetime
import math
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

import figure_data
from alternating import experiments
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.every_claim import measure
from beltrepro.replication.verdicts import evidence
from beltrepro.replication.verdicts.criteria import NOT_TESTABLE, OPEN, QUESTIONS, YES, bounds
from beltrepro.replication.verdicts.ledger import KINDS, REGISTRY, SEEN, load_ledger
from beltrepro.replication.verdicts.measured import COLUMNS, ESTIMATE_COLUMNS
from made_up import SETTINGS, few_resamples  # noqa: F401

CONFIG = Path(__file__).parents[2] / "config.yaml"
LEDGER = load_ledger()
# `figure_data` has none of these, or lacks columns that claims read, and figures do not.
LACKING = ("belt_", "pairs_", "noise_steps", "noisy_motion")
# Words that no sentence of the ledger may have: they tell a verdict, which the numbers decide.
FORBIDDEN = r"\bnan\b|undecided|\bholds?\b|\bfails?\b|not measured|allowed"


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


def criteria():
    """Every criterion with the names of its claim and question."""
    for claim in LEDGER.values():
        for question, criterion in claim.criteria.items():
            yield pytest.param(claim, criterion, id=f"{claim.id}-{question}")


CRITERIA = list(criteria())


def test_every_claim_has_a_function():
    assert {claim.id for claim in LEDGER.values() if claim.testable} <= set(REGISTRY) <= set(LEDGER)
    assert {claim.kind for claim in LEDGER.values()} <= set(KINDS)


@pytest.mark.parametrize(("claim", "criterion"), CRITERIA)
def test_every_criterion_can_come_out_both_ways(claim, criterion):
    assert bool(criterion.untestable) != bool(criterion.allowed)
    assert criterion.lenient.keys() <= criterion.allowed.keys() and criterion.tried >= 1
    for name, allowed in criterion.allowed.items():
        low, high = bounds(allowed)
        assert low <= high
        widest = bounds(criterion.lenient.get(name, allowed))
        assert widest[0] <= low and high <= widest[1], name
        assert math.isfinite(widest[0]) or math.isfinite(widest[1]), name


@pytest.mark.parametrize(("claim", "criterion"), CRITERIA)
def test_its_sentence_tells_no_verdict(claim, criterion):
    assert not re.search(FORBIDDEN, criterion.found, re.I)
    assert not criterion.found or criterion.found[-1] in ".”"


@pytest.mark.parametrize(("claim", "criterion"), CRITERIA)
def test_it_has_the_words_of_the_paper_a_sentence_a_protocol_and_a_reason(claim, criterion):
    assert bool(claim.says) == (claim.kind != "explanation")
    assert criterion.untestable or criterion.found
    assert criterion.untestable or not claim.finding or (criterion.how and criterion.because)


def test_every_change_is_dated_and_says_what_had_been_seen():
    for claim in LEDGER.values():
        assert claim.history, claim.id
        dates = [change.date for change in claim.history]
        assert all(isinstance(date, datetime.date) for date in dates) and dates == sorted(dates)
        assert all(change.seen in SEEN and change.what for change in claim.history), claim.id


def test_what_rests_on_starts_at_rest_says_so():
    at_rest = {"n5_replicates", "size_replicates", "n5_replicates_beyond"}
    for name in ("u-critical", "r-jump", "outliers", "continuous-slip", "sharpest-at-n5"):
        assert at_rest & set(LEDGER[name].needs)
        assert "begin near rest" in LEDGER[name].starts


def test_the_datasets_that_claims_need_are_in_the_configuration():
    config = yaml.safe_load(CONFIG.read_text())
    expected = set(config["datasets"]) | {f"{film}_track" for film in config["films"]}
    assert {name for claim in LEDGER.values() for name in claim.needs} <= expected


def test_what_is_true_by_construction_is_marked():
    marked = {claim.id for claim in LEDGER.values() if claim.kind == "construction"}
    assert marked == {"units", "friction-constants", "spring-law", "friction-law", "setup"}
    recordings = [claim for claim in LEDGER.values() if claim.kind == "recording"]
    assert recordings and {claim.finding for claim in recordings} == {True}


# --- made-up data -------------------------------------------------------------------------------


def assert_layout(measured):
    claims, estimates = measured
    assert list(claims.columns) == list(COLUMNS)
    assert list(estimates.columns) == list(ESTIMATE_COLUMNS)
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

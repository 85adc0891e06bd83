"""From measurements to the table of claims: criteria at their edges, readings, notes, evidence."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.studies import every_claim
from beltrepro.replication.verdicts import evidence
from beltrepro.replication.verdicts.criteria import (
    FAILS,
    HOLDS,
    NOT_MEASURED,
    NOT_TESTABLE,
    PARTLY,
    UNDECIDED,
    Measurement,
    judge,
    range_in_words,
    show,
)
from beltrepro.replication.verdicts.ledger import Claim
from beltrepro.stats.estimates import Estimate, absent, single, sure

# --- criteria -------------------------------------------------------------------------------------


def verdict_of(allowed, *found):
    names = [f"c{number}" for number in range(len(found))]
    criterion = {"allowed": dict(zip(names, allowed, strict=True))}
    return judge(criterion, Measurement(dict(zip(names, found, strict=True))))


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (1.0, 2.0, HOLDS),
        (0.99, 2.0, UNDECIDED),
        (1.0, 2.01, UNDECIDED),
        (0.0, 9.0, UNDECIDED),
        (0.5, 1.0, UNDECIDED),  # touches the range
        (0.5, 0.99, FAILS),
        (2.01, 9.0, FAILS),
        (math.nan, math.nan, UNDECIDED),
        (-math.inf, math.inf, UNDECIDED),
    ],
)
def test_the_whole_interval_decides(low, high, verdict):
    assert verdict_of([[1, 2]], Estimate(1.5, low, high, 9)).verdict == verdict
    assert verdict_of([[1, math.inf]], Estimate(1.5, 1.0, 1e9, 9)).verdict == HOLDS


def test_a_larger_error_never_helps():
    for value in (0.5, 1.2, 1.8, 2.5):
        grades = [
            verdict_of([[1, 2]], Estimate(value, value - reach, value + reach, 9)).verdict
            for reach in (0.0, 0.1, 0.3, 1.0, 10.0)
        ]
        assert grades[-1] == UNDECIDED
        assert grades == sorted(grades, key=(grades[0], UNDECIDED).index)


def test_yes_and_no_and_what_is_not_found():
    assert verdict_of([True], sure(True)).verdict == HOLDS
    assert verdict_of([True], sure(False)).verdict == FAILS
    assert verdict_of([False], sure(False)).verdict == HOLDS
    assert verdict_of([[0, 1]], absent(8)).verdict == FAILS


def test_components_make_the_claim():
    holds, fails, open_ = (Estimate(v, v - 0.1, v + 0.1, 9) for v in (0.0, 2.0, 1.0))
    expected = {
        (holds, holds): HOLDS,
        (fails, fails): FAILS,
        (open_, open_): UNDECIDED,
        (holds, fails): PARTLY,
        (holds, open_): UNDECIDED,
        (fails, open_): UNDECIDED,
        (holds, fails, open_): PARTLY,
    }
    for found, verdict in expected.items():
        assert verdict_of([[-1, 1]] * len(found), *found).verdict == verdict
    judged = verdict_of([[-1, 1]] * 3, holds, fails, open_)
    assert judged.components == {"c0": HOLDS, "c1": FAILS, "c2": UNDECIDED}


def test_the_reason_says_what_would_decide():
    judged = verdict_of([[1, 2]], Estimate(1.2, 0.8, 1.6, 8))
    assert judged.reason == (
        "c0: 1.2 (0.8 to 1.6) covers the limit 1; "
        "some 32 independent runs would decide, 8 were made"
    )
    at_limit = verdict_of([[1, 2]], Estimate(1.001, 0.8, 1.2, 8)).reason
    assert at_limit == "c0: 1 (0.8 to 1.2) covers the limit 1, at which it lies"
    alone = verdict_of([[1, 2]], single(1.2)).reason
    assert alone == "c0: 1.2 in one run, whose error is not known"
    assert verdict_of([[1, 2]], Estimate(3, 2.5, 3.5, 8)).reason == "c0: 3 (2.5 to 3.5), not 1 to 2"
    assert verdict_of([True], sure(False)).reason == "c0: no"
    assert verdict_of([[1, 2]], Estimate(1.5, 1.2, 1.8, 8)).reason == ""


def test_the_limit_that_is_named_is_the_one_that_the_interval_covers():
    """None of the runs is below the upper limit for sure, and zero is not in question."""
    nearer = verdict_of([[0, 0.05]], Estimate(0.0, 0.0, 0.06, 60)).reason
    assert nearer.startswith("c0: 0 (0 to 0.06) covers the limit 0.05; some 87 independent runs")
    both = verdict_of([[0, 1]], Estimate(0.9, -1, 2, 8)).reason
    assert "covers the limit 1" in both


def test_longer_runs_are_asked_for_where_some_are_open():
    reason = verdict_of([[0.5, 1]], Estimate(0.4, 0.3, 0.8, 40, still_open=12)).reason
    assert (
        reason == "c0: 0.4 (0.3 to 0.8) covers the limit 0.5; 12 of 40 runs must be longer to tell"
    )


def test_nothing_to_test_against():
    assert judge({"text": "t"}, Measurement()).verdict == NOT_TESTABLE


def test_values_in_words():
    assert show({"a": 12345.6, "b": [1, 2.5]}) == "a: 1.235e+04; b: 1 to 2.5" and show(None) == ""
    found = {"a": sure(True), "b": sure(2.5), "c": Estimate(1.2345, 1.1, 1.36, 4), "d": absent()}
    words = "a: yes; b: 2.5; c: 1.23 (1.1 to 1.36); d: not found"
    assert Measurement(found).words == words
    ranges = ([1, 2], [1, math.inf], [-math.inf, 0.5], True, False)
    assert [*map(range_in_words, ranges)] == ["1 to 2", "1 or more", "0.5 or less", "yes", "no"]


# --- readings -------------------------------------------------------------------------------------


def claim(**change):
    settings = {"id": "x", "section": "model", "figure": 7, "kind": "number", "statement": "words"}
    settings["criterion"] = {"allowed": {"a": [0.5, 1.5]}, "text": "near"}
    return Claim(**settings | {"needs": ("series/one",), "paper": 1.0} | change)


def rows_of(monkeypatch, found, **change):
    """Rows of both tables for a claim whose function returns or raises this."""

    def function(evidence):
        if isinstance(found, Exception):
            raise found
        return found

    own = claim(**{key: value for key, value in change.items() if key != "used"})
    monkeypatch.setattr(every_claim, "load_ledger", lambda: {"x": own})
    monkeypatch.setitem(every_claim.REGISTRY, "x", function)
    used = SimpleNamespace(used=change.get("used", []), start=lambda claim: None)
    monkeypatch.setattr(every_claim, "Evidence", lambda datasets, settings: used)
    measured = every_claim.measure({}, {})
    return measured.claims.to_dict("records"), measured.estimates.to_dict("records")


def failing(error):
    def reading():
        raise error

    return reading


def near(value, reach=0.1, runs=9):
    return Measurement({"a": Estimate(value, value - reach, value + reach, runs)})


def test_a_row_holds_what_was_measured(monkeypatch):
    found = Measurement({"a": Estimate(1.25, 1.125, 1.375, 4)}, {"b": sure(3)}, "noted")
    (row,), estimates = rows_of(monkeypatch, found, used=["one", "two"], reason="reasoned")
    assert row == {
        "id": "x",
        "figure": "7",
        "kind": "number",
        "variant": "",
        "statement": "words",
        "paper": "1",
        "measured": "a: 1.25 (1.12 to 1.38); b: 3",
        "runs": "4",
        "criterion": "near",
        "verdict": HOLDS,
        "reason": "",
        "note": "reasoned. noted. rests on 4 runs",
        "dataset": "one, two",
    }
    first, second = estimates
    assert (first["value"], first["low"], first["high"], first["runs"]) == (1.25, 1.125, 1.375, 4)
    assert (first["allowed_low"], first["allowed_high"], first["verdict"]) == (0.5, 1.5, HOLDS)
    assert second["name"] == "b" and math.isnan(second["allowed_low"]) and not second["verdict"]
    (row,), _ = rows_of(monkeypatch, Measurement(), figure=None, criterion={"text": "t"})
    assert (row["criterion"], row["verdict"], row["figure"]) == ("t", NOT_TESTABLE, "")
    assert (row["measured"], row["runs"], row["dataset"]) == ("", "", "series/one")


@pytest.mark.parametrize(
    ("counted", "others"), [(9.0, [1.0, 9.0]), (1.0, [9.0]), (1.45, [1.0, 9.0])]
)
def test_other_readings_change_nothing(monkeypatch, counted, others):
    readings = {"counts": lambda: near(counted)}
    readings |= {f"v{k}": (lambda v=v: near(v)) for k, v in enumerate(others)}
    rows, estimates = rows_of(monkeypatch, readings)
    assert [row["variant"] for row in rows] == ["", *(f"v{k}" for k in range(len(others)))]
    expected = [verdict_of([[0.5, 1.5]], near(v).judged["a"]).verdict for v in (counted, *others)]
    assert [row["verdict"] for row in rows] == expected
    assert [row["verdict"] for row in estimates] == expected


def test_missing_data_and_faults_are_said_and_cost_one_reading(monkeypatch):
    (row,), _ = rows_of(monkeypatch, NotEnoughDataError("too short"))
    assert (row["verdict"], row["note"]) == (NOT_MEASURED, "too short")
    readings = {"a": failing(ZeroDivisionError("by zero")), "b": lambda: near(1.0)}
    (first, second), _ = rows_of(monkeypatch, readings)
    assert first["verdict"] == NOT_MEASURED and second["verdict"] == HOLDS
    assert first["note"] == "fault in its code, see the log: ZeroDivisionError: by zero"
    (row,), _ = rows_of(monkeypatch, Measurement({"b": sure(1)}))
    assert row["verdict"] == NOT_MEASURED and "KeyError: 'a'" in row["note"]


# --- evidence -------------------------------------------------------------------------------------


def test_events_of_the_last_block_only():
    events = np.array(
        [(1.0, 2, "slip"), (2.0, 2, "stick"), (3.0, 1, "slip"), (4.0, 2, "slip")],
        [("time", "f8"), ("block", "i8"), ("kind", "U5")],
    )
    series = SimpleNamespace(arrays={"events": events}, attributes={"n_blocks": 2})
    slips, sticks = evidence.last_block_events(series)
    assert slips["time"].tolist() == [1, 4] and sticks["time"].tolist() == [2]


@pytest.mark.parametrize(("transient", "refused"), [(5000.0, False), (4999.0, True)])
def test_short_transients_are_not_settled(transient, refused):
    cut = evidence.Cut({}, transient, 1e4)
    if refused:
        with pytest.raises(NotEnoughDataError, match="scans/a discards a transient of 4999"):
            evidence._settled(cut, "scans/a")
    else:
        assert evidence._settled(cut, "scans/a") is cut


def test_runs_come_from_the_first_dataset_that_has_any():
    def dataset(n_blocks, place):
        arrays = {
            "n_blocks": np.array(n_blocks),
            "u": np.array(place),
            "name": np.array(["x", "y"]),
        }
        return SimpleNamespace(arrays=arrays, attributes={"duration": place[0]})

    datasets = {"a": dataset([5, 6], [1.0, 2.0]), "b": dataset([5, 5], [2.0, 2.0 + 1e-9])}
    found = evidence.Evidence(datasets, {})
    found.start(claim())
    arrays, attributes = found.runs("missing", "a", "b", n_blocks=5, u=2.0)
    assert arrays["name"].tolist() == ["x", "y"] and attributes == {"duration": 2.0}
    assert found.used == ["b"]
    arrays, _ = found.runs("a", "b", n_blocks=6)
    assert arrays["u"].tolist() == [2.0] and found.used == ["b", "a"]
    with pytest.raises(NotEnoughDataError, match=r"n_blocks = 7, u = 2\.5 in a or b"):
        found.runs("a", "b", n_blocks=7, u=2.5)
    datasets["b"].attributes["transient"] = 4999.0
    with pytest.raises(NotEnoughDataError, match="b discards a transient of 4999"):
        found.runs("b", n_blocks=5)

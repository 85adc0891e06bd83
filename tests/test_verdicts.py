"""From measurements to the table of claims: criteria at their edges, readings, notes, evidence."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from beltrepro.analysis.errors import NotEnoughDataError
from beltrepro.claims import evidence, measuring
from beltrepro.claims.criteria import (
    FAILS,
    HOLDS,
    NOT_MEASURED,
    NOT_TESTABLE,
    PARTLY,
    Measurement,
    components,
    judge,
    show,
)
from beltrepro.claims.ledger import Claim

WITHIN = {"type": "absolute", "holds": 0.25, "partly": 0.5}

# --- criteria -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "error", "verdict"),
    [
        (1.25, None, HOLDS),
        (0.75, None, HOLDS),
        (1.26, None, PARTLY),
        (1.5, None, PARTLY),
        (0.49, None, FAILS),
        (1.75, 0.375, PARTLY),  # two standard errors
        (1.76, 0.375, FAILS),
        (1.0, 0.5, HOLDS),
        (1.0, 0.51, NOT_MEASURED),
        (1.0, math.inf, HOLDS),  # no error is known
        (1.0, math.nan, HOLDS),
    ],
)
def test_an_absolute_criterion_at_its_edges(value, error, verdict):
    assert judge(WITHIN, 1.0, Measurement(value, error))[0] == verdict


def test_errors_are_set_against_the_wider_tolerance_and_say_so():
    verdict, reason = judge(WITHIN, 1.0, Measurement(1.0, 0.75))
    assert (verdict, reason) == (NOT_MEASURED, "standard error 0.75 exceeds the tolerance 0.5")
    only = {"type": "absolute", "holds": 0.25}
    assert judge(only, 1.0, Measurement(1.0, 0.26))[0] == NOT_MEASURED
    assert [judge(only, 1.0, Measurement(v))[0] for v in (1.25, 1.26)] == [HOLDS, FAILS]
    # nothing but equality holds, and no error is too large for it
    exact = {"type": "absolute", "holds": 0.0, "partly": 0.05}
    assert judge(exact, 0.0, Measurement(0.04, 0.01))[0] == PARTLY
    assert judge({"type": "absolute", "holds": 0.0}, 0.0, Measurement(0.1, 0.05))[0] == PARTLY


def test_a_relative_criterion_scales_with_the_size_of_the_printed_value():
    relative = {"type": "relative", "holds": 0.1, "partly": 0.2}
    found = [judge(relative, -10.0, Measurement(v))[0] for v in (-11.0, -11.5, -12.1, 10.0)]
    assert found == [HOLDS, PARTLY, FAILS, FAILS]
    assert judge(relative, 10.0, Measurement(10.0, 2.1))[0] == NOT_MEASURED
    assert judge(relative, 10.0, Measurement(10.0, 1.9))[0] == HOLDS


def test_components_of_every_kind_count_alike():
    criterion = {"type": "absolute", "holds": {"a": 1.0, "b low": 1.0, "b high": 3.0}}
    paper, error = {"a": 5.0, "b": [10.0, 20.0]}, {"b": (0.1, 2.9)}
    assert judge(criterion, paper, Measurement({"a": 6, "b": (11, 17)}, error))[0] == HOLDS
    assert judge(criterion, paper, Measurement({"a": 6, "b": (11, 13)}, error))[0] == PARTLY
    assert judge(criterion, paper, Measurement({"a": 9, "b": (13, 30)}))[0] == FAILS
    both = Measurement({"a": 6, "b": (11, 17)}, checks={"one": False})
    assert judge(criterion, paper, both)[0] == PARTLY
    none = Measurement({"a": 9, "b": (13, 30)}, checks={"one": False})
    assert judge(criterion, paper, none)[0] == FAILS
    assert components({"a": {"b": (1, 2)}, "c": 3}) == {"a b low": 1, "a b high": 2, "c": 3}
    assert components([4, 5]) == {"low": 4, "high": 5} and components(None) == {}


def test_intervals_include_their_ends():
    interval = {"type": "interval", "range": [0.5, 2.0], "partly": [0.5, 3.0]}
    values = (0.5, 2.0, 2.1, 3.0, 3.1, 0.4)
    found = [judge(interval, None, Measurement(v))[0] for v in values]
    assert found == [HOLDS, HOLDS, PARTLY, PARTLY, FAILS, FAILS]
    narrow = {"type": "interval", "range": [0, 1]}
    assert judge(narrow, None, Measurement((0.5, 1.5)))[0] == PARTLY
    assert judge(narrow, None, Measurement(0.5, checks={"a": True}))[0] == HOLDS
    assert judge({"type": "none"}, 3.0, Measurement(3.0)) == (NOT_TESTABLE, "")
    ordering = judge({"type": "ordering"}, None, Measurement(3.0))
    assert ordering == (NOT_MEASURED, "nothing to judge")


def test_values_in_words():
    assert show((1.23456, math.nan), digits=2) == "1.2 to not found"
    assert show({"a": {"b": 12345.6}}) == "a: b: 1.235e+04" and show(0) == "0"


# --- readings -------------------------------------------------------------------------------------


def claim(**change):
    settings = {"id": "x", "section": "model", "figure": 7, "kind": "number", "statement": "words"}
    settings |= {"criterion": WITHIN | {"text": "near"}, "needs": ("series/one",), "paper": 1.0}
    return Claim(**settings | change)


def rows_of(monkeypatch, found, **change):
    """Rows of the table for a claim whose function returns or raises this."""

    def function(evidence):
        if isinstance(found, Exception):
            raise found
        return found

    monkeypatch.setitem(measuring.REGISTRY, "x", function)
    used = SimpleNamespace(used=change.pop("used", []), start=lambda claim: None)
    return measuring._claim_rows(claim(**change), used)


def failing(error):
    def reading():
        raise error

    return reading


def test_a_row_holds_what_was_measured(monkeypatch):
    measurement = Measurement(1.2345678, 0.01234, 7, {"a": True, "b": False}, "noted")
    (row,) = rows_of(monkeypatch, measurement, used=["scans/a", "scans/b"], reason="reasoned")
    assert row == {
        "id": "x",
        "figure": "7",
        "variant": "",
        "statement": "words",
        "paper": "1",
        "measured": "1.235",
        "uncertainty": "0.012",
        "sample_size": "7",
        "criterion": "absolute: near",
        "verdict": PARTLY,
        "note": "reasoned. noted. not met: b",
        "dataset": "scans/a, scans/b",
    }
    checks = Measurement(checks={"a": True, "b": True, "c": False})
    ordering = {"type": "ordering", "text": "t"}
    (row,) = rows_of(monkeypatch, checks, figure=None, paper=None, criterion=ordering)
    assert (row["figure"], row["measured"]) == ("", "2 of 3 checks met")
    assert row["dataset"] == "series/one"
    assert (row["sample_size"], row["uncertainty"], row["note"]) == ("", "", "not met: c")
    (row,) = rows_of(monkeypatch, Measurement(), criterion={"type": "none", "text": "t"})
    assert (row["criterion"], row["verdict"], row["measured"]) == ("t", NOT_TESTABLE, "")


@pytest.mark.parametrize(
    ("counted", "others", "verdict", "note"),
    [
        (9.0, [1.0, 9.0, 1.1], PARTLY, "fails in the reading that counts, holds for: v0; v2"),
        (9.0, [1.4, 9.0], FAILS, ""),
        (1.4, [1.0], PARTLY, ""),
        (1.0, [9.0], HOLDS, ""),
    ],
)
def test_a_variant_that_holds_makes_a_failing_claim_partly(
    monkeypatch, counted, others, verdict, note
):
    readings = {"counts": lambda: Measurement(counted)}
    readings |= {f"v{k}": (lambda v=v: Measurement(v)) for k, v in enumerate(others)}
    first, *variants = rows_of(monkeypatch, readings)
    assert (first["variant"], first["verdict"], first["note"]) == ("", verdict, note)
    assert [row["variant"] for row in variants] == [f"v{k}" for k in range(len(others))]
    expected = [judge(WITHIN, 1.0, Measurement(value))[0] for value in others]
    assert [row["verdict"] for row in variants] == expected


def test_missing_data_and_faults_are_said_and_cost_one_reading(monkeypatch):
    (row,) = rows_of(monkeypatch, NotEnoughDataError("too short"))
    assert (row["verdict"], row["note"]) == (NOT_MEASURED, "too short")
    readings = {"a": failing(ZeroDivisionError("by zero")), "b": lambda: Measurement(1.0)}
    first, second = rows_of(monkeypatch, readings)
    assert first["verdict"] == NOT_MEASURED and second["verdict"] == HOLDS
    assert first["note"] == "fault in its code, see the log: ZeroDivisionError: by zero"


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

"""From measurements to the table of claims: criteria at their edges, words, readings, evidence."""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.verdicts import criteria, evidence, measured
from beltrepro.replication.verdicts.criteria import (
    IN_PART,
    NO,
    NOT_TESTABLE,
    OPEN,
    YES,
    Criterion,
    Measurement,
    judge,
)
from beltrepro.replication.verdicts.ledger import Change, Claim
from beltrepro.stats.estimates import Estimate, absent, sure

# --- criteria -------------------------------------------------------------------------------------


def judged(allowed, *estimates, lenient=None):
    """Judgement of numbers c0, c1, ... by these ranges; `lenient` is that of c0."""
    numbers = {f"c{place}": estimate for place, estimate in enumerate(estimates)}
    ranges = dict(zip(numbers, allowed, strict=True))
    return judge(Criterion(ranges, {"c0": lenient} if lenient else {}), Measurement(numbers))


@pytest.mark.parametrize(
    ("value", "low", "high", "strictly", "leniently"),
    [
        (1.5, 1.0, 2.0, YES, YES),
        (1.5, 0.99, 2.0, OPEN, YES),  # the number is right, and no reader minds its interval
        (1.5, 0.8, 2.2, OPEN, YES),
        (1.5, 0.79, 2.0, OPEN, OPEN),
        (1.5, 1.0, 2.21, OPEN, OPEN),
        (0.9, 0.81, 0.99, NO, IN_PART),
        (0.9, 0.79, 0.99, NO, OPEN),
        (0.7, 0.6, 0.79, NO, NO),
        (math.nan, math.nan, math.nan, OPEN, OPEN),  # not found is no failure
        (1.5, -math.inf, math.inf, OPEN, OPEN),
    ],
)
def test_the_interval_decides_within_what_a_reader_allows(value, low, high, strictly, leniently):
    estimate = Estimate(value, low, high, 9)
    assert judged([[1, 2]], estimate).verdict == strictly
    assert judged([[1, 2]], estimate, lenient=[0.8, 2.2]).verdict == leniently


def test_yes_and_no():
    assert judged([True], sure(True)).verdict == YES
    assert judged([True], sure(False)).verdict == NO
    assert judged([False], sure(False)).verdict == YES
    assert judged([[1, math.inf]], Estimate(1.5, 1.0, 1e9, 9)).verdict == YES
    assert judged([[0, 1]], absent(8)).verdict == OPEN


RIGHT, WRONG, UNSURE = (Estimate(value, value - 0.1, value + 0.1, 9) for value in (0.0, 2.0, 1.0))


@pytest.mark.parametrize(
    ("estimates", "verdict"),
    [
        ((RIGHT, RIGHT, RIGHT), YES),
        ((WRONG, WRONG), NO),
        ((UNSURE, UNSURE), OPEN),
        ((RIGHT, WRONG), IN_PART),
        ((RIGHT, UNSURE), OPEN),
        ((WRONG, UNSURE), NO),  # one number that is surely wrong decides
        ((UNSURE, UNSURE, WRONG), NO),
        ((RIGHT, WRONG, UNSURE), IN_PART),
    ],
)
def test_numbers_make_the_verdict(estimates, verdict):
    for order in itertools.permutations(estimates):
        assert judged([[-1, 1]] * len(order), *order).verdict == verdict


def test_a_number_that_is_right_in_part():
    near = Estimate(1.5, 1.4, 1.6, 9)
    for others, verdict in (((RIGHT,), IN_PART), ((UNSURE,), OPEN), ((WRONG,), IN_PART)):
        made = judged([[-1, 1]] * 2, near, *others, lenient=[-2, 2])
        assert made.verdict == verdict and made.components["c0"] == IN_PART


# --- words ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("place", "estimate", "words"),
    [
        ("{x}", Estimate(1.2345, 1.1, 1.36, 4), "1.23 (1.1 to 1.36)"),
        ("{value x}", Estimate(1.2345, 1.1, 1.36, 4), "1.23"),
        ("{percent x}", Estimate(0.25, 0.1, 0.5, 4), "25 % (10 to 50 %)"),
        ("{count x}", Estimate(0.0, 0.0, 0.2, 13), "none of 13"),
        ("{count x}", Estimate(5 / 13, 0.1, 0.7, 13), "5 of 13"),
        ("{count x}", Estimate(0.0, 0.0, 0.7, 13, 4), "none of 13 (4 open)"),
        ("{x}", Estimate(2.7, math.nan, math.nan, 8), "2.7 (error not known)"),
    ],
)
def test_a_sentence_takes_its_numbers(place, estimate, words):
    template = f"Of {place} and {{value other, N = 5}}."
    numbers = {"x": estimate, "other, N = 5": sure(3)}
    assert criteria.sentence(template, numbers) == f"Of {words} and 3."
    assert criteria.names_in(template) == ["x", "other, N = 5"]


def test_in_place_of_a_sentence_without_its_number_stands_what_was_not_found():
    template = "It is {a}, not {b}. Above σ = 1. {value a} or {b}, says {value b}. Then {a}."
    numbers = {"a": sure(2), "b": absent(8)}
    assert criteria.sentence(template, numbers) == "Above σ = 1. Then 2. Not found: b."
    assert criteria.sentence("{a}, {b}.", {"a": absent(), "b": absent()}) == "Not found: a; b."


# --- readings -------------------------------------------------------------------------------------


def claim(**change):
    settings = {"id": "x", "section": "model", "figure": 7, "kind": "number", "says": "“near”",
                "statement": "words", "needs": ("one",), "paper": 1.0}  # fmt: skip
    settings["replicated"] = Criterion({"a": [0.5, 1.5]}, how="once", found="It is {a}.")
    settings["robust"] = Criterion({"a": [0.5, 9.5]}, because="so", found="It is {value a}.")
    settings["history"] = (Change(None, "nothing", "written"), Change(None, "short runs", "wider"))
    return Claim(**settings | change)


def tables_of(monkeypatch, readings, **change):
    """Row and estimates of a claim whose readings give or raise this."""

    def made(outcome):
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    functions = {name: lambda _, one=one: made(one) for name, one in readings.items()}
    monkeypatch.setattr(measured, "load_ledger", lambda: {"x": claim(**change)})
    monkeypatch.setitem(measured.REGISTRY, "x", functions)
    data = SimpleNamespace(used=[], start=lambda claim: None)
    monkeypatch.setattr(measured, "Evidence", lambda datasets, settings: data)
    (row,), estimates = (table.to_dict("records") for table in measured.measure({}, {}))
    return row, estimates


def near(value, reach=0.125, runs=9):
    return Measurement({"a": Estimate(value, value - reach, value + reach, runs)})


def test_each_question_judges_the_reading_that_it_names(monkeypatch):
    readings = {"p": near(1.0), "q": near(5.0), "r": near(20.0)}
    for reading, robust in (("", YES), ("q", YES), ("r", NO)):
        row, estimates = tables_of(
            monkeypatch, readings, robust=Criterion({"a": [0.5, 9.5]}, reading=reading)
        )
        assert (row["replicated"], row["replicated_reading"]) == (YES, "p")
        assert (row["robust"], row["robust_reading"]) == (robust, reading or "p")
        names = {e["reading"] for e in estimates if "robust" in e["decides"]}
        assert names == {reading or "p"} and {e["reading"] for e in estimates} == set("pqr")


def test_missing_data_cost_one_reading_and_a_bug_stops_the_run(monkeypatch):
    row, _ = tables_of(monkeypatch, {"": NotEnoughDataError("too short")})
    assert [row[f"robust{end}"] for end in ("", "_found", "_reason")] == [OPEN, *2 * ["too short"]]
    readings = {"p": NotEnoughDataError("no p"), "q": near(1.0)}
    row, estimates = tables_of(monkeypatch, readings, robust=Criterion({"a": [0, 2]}, reading="q"))
    assert (row["replicated"], row["replicated_found"], row["robust"]) == (OPEN, "no p", YES)
    assert {e["reading"] for e in estimates} == {"q"}
    with pytest.raises(ZeroDivisionError):
        tables_of(monkeypatch, {"p": ZeroDivisionError("by zero")})
    with pytest.raises(KeyError, match="a"):
        tables_of(monkeypatch, {"": Measurement({"b": sure(1)})})
    with pytest.raises(KeyError, match="s"):
        tables_of(monkeypatch, readings, robust=Criterion({"a": [0, 2]}, reading="s"))


def test_what_cannot_be_tested_still_says_what_the_model_does(monkeypatch):
    criterion = Criterion(untestable="no recordings", found="The model gives {value a}.")
    row, estimates = tables_of(monkeypatch, {"": near(1.0)}, replicated=criterion, robust=criterion)
    assert (row["robust"], row["robust_found"]) == (NOT_TESTABLE, "The model gives 1.")
    assert [(e["name"], e["decides"]) for e in estimates] == [("a", "")]
    row, _ = tables_of(monkeypatch, {"": NotEnoughDataError("no u1")}, robust=criterion)
    assert (row["robust"], row["robust_found"]) == (NOT_TESTABLE, "no recordings")


def test_what_had_been_seen_by_the_last_change_and_what_can_be_tested():
    assert claim().seen == "short runs"
    assert claim(history=claim().history[::-1]).seen == "short runs"
    untestable = Criterion(untestable="no recordings")
    assert claim().testable and claim(robust=untestable).testable
    assert not claim(replicated=untestable, robust=untestable).testable


# --- evidence -------------------------------------------------------------------------------------


def test_runs_come_from_the_first_dataset_that_has_any():
    def dataset(n_blocks, place):
        arrays = {
            "n_blocks": np.array(n_blocks),
            "u": np.array(place),
            "name": np.array(["x", "y"]),
        }
        return SimpleNamespace(arrays=arrays, attributes={"duration": place[0]})

    datasets = {"a": dataset([5, 6], [1.0, 2.0]), "b": dataset([5, 5], [2.0, 2.0 + 1e-9])}
    data = evidence.Evidence(datasets, {})
    data.start(claim())
    arrays, attributes = data.runs("missing", "a", "b", n_blocks=5, u=2.0)
    assert arrays["name"].tolist() == ["x", "y"] and attributes == {"duration": 2.0}
    assert data.used == ["b"]
    arrays, _ = data.runs("a", "b", n_blocks=6)
    assert arrays["u"].tolist() == [2.0] and data.used == ["b", "a"]
    arrays, _ = data.runs("a", "b", n_blocks=(5, 6), u=(0.5, 2.0))
    assert arrays["u"].tolist() == [1.0, 2.0]
    with pytest.raises(NotEnoughDataError, match=r"N = 7, u = 2\.5 to 3 in a or b"):
        data.runs("a", "b", n_blocks=7, u=(2.5, 3.0))
    datasets["b"].attributes["transient"] = 4999.0
    with pytest.raises(NotEnoughDataError, match="b discards a transient of 4999"):
        data.runs("b", n_blocks=5)

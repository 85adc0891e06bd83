"""Findings, sentences, readings and comparisons say what the tables of claims say."""

import re

import numpy as np
import pandas as pd
import pytest

import made_up_results
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import registry
from beltrepro.replication.report import findings
from beltrepro.replication.report.findings import (
    pictures,
    presets,
    readings,
    reliability,
    sentences,
    topics,
)
from beltrepro.replication.verdicts.criteria import (
    FAILS,
    HOLDS,
    NOT_MEASURED,
    PARTLY,
    UNDECIDED,
    VERDICTS,
)
from beltrepro.replication.verdicts.entries import load_ledger

LEDGER = load_ledger()


def results(folder, **verdicts):
    """Results of a made-up run; `everything` is the verdict of all claims but those given."""
    given = dict.fromkeys(LEDGER, everything) if (everything := verdicts.pop("everything", None)) \
        else {}  # fmt: skip
    given |= {name.replace("_", "-"): verdict for name, verdict in verdicts.items()}
    return findings.read(*made_up_results.write(folder, given))


# --- tables ---------------------------------------------------------------------------------------


def test_all_that_the_tables_say_is_read(tmp_path):
    claims, estimates = made_up_results.tables()
    found = results(tmp_path)
    assert list(found) == list(LEDGER)
    for row in claims.to_dict("records"):
        result = found[row["id"]]
        reading = {each.name: each for each in result.readings}[row["variant"]]
        assert (reading.verdict, reading.note) == (row["verdict"], row["note"])
        own = estimates[(estimates["id"] == row["id"]) & (estimates["variant"] == row["variant"])]
        assert list(reading.numbers) == list(own["name"])
        for name, verdict, value in zip(own["name"], own["verdict"], own["value"], strict=True):
            number = reading.numbers[name]
            assert number.verdict == verdict
            assert number.estimate.value == pytest.approx(value, rel=1e-5)


def test_a_claim_that_the_ledger_lacks_is_refused(tmp_path):
    claims, estimates = made_up_results.write(tmp_path)
    claims.write_text(claims.read_text().replace("u-critical,", "u-crit,"))
    with pytest.raises(InputError, match="'u-crit' is not in the ledger"):
        findings.read(claims, estimates)
    with pytest.raises(InputError, match=r"none.csv: no such file"):
        findings.read(tmp_path / "none.csv", estimates)


@pytest.mark.parametrize(
    ("note", "verdict", "why"),
    [
        ("a: 1, not 2", FAILS, "It fails by a: 1, not 2."),
        ("a: 1.5, not 2. the runs end", FAILS, "It fails by a: 1.5, not 2. The runs end."),
        ("a: 1.5, not 2. r is low", PARTLY, "It fails in part, by a: 1.5, not 2. r is low."),
        ("a: 1 covers the limit 1", UNDECIDED, "It is undecided by a: 1 covers the limit 1."),
        ("only noted", HOLDS, ""),
        ("only noted", "not testable here", ""),
    ],
)
def test_why_a_claim_does_not_hold(note, verdict, why):
    number = findings.Number("a", None, (0.0, 1.0), verdict)
    reading = findings.Reading("", verdict, note, "9", {"a": number})
    assert reading.why == why


def test_claims_are_counted(tmp_path):
    counts = findings.count(results(tmp_path).values())
    verdicts = [each.verdict for each in results(tmp_path).values() if each.claim.finding]
    assert counts.by_verdict == {name: verdicts.count(name) for name in VERDICTS}
    assert counts.total + counts.construction == len(LEDGER)
    assert counts.testable == counts.total - verdicts.count("not testable here")


# --- sentences ------------------------------------------------------------------------------------


def test_sentences_take_their_numbers_from_the_tables(tmp_path):
    found = results(tmp_path, everything=HOLDS)
    number = found["u-critical"].counted.numbers["critical"]
    assert sentences.filled("At {u-critical: critical}.", found) == f"At {number.words}."
    assert sentences.filled("At {u-critical}.", found) == f"At {number.words}."
    assert sentences.filled("It {verdict u-critical}.", found) == "It holds."
    assert sentences.filled("{=a} of {=b}", found, {"a": "1", "b": "2"}) == "1 of 2"


@pytest.mark.parametrize(
    "template",
    ["{u-critical: nothing}", "{nothing}", "{r-jump}", "{why u-critical}", "{=nothing}"],
)
def test_a_sentence_without_its_number_is_left_out(tmp_path, template):
    found = results(tmp_path, everything=HOLDS)
    assert sentences.filled(f"Here {template}.", found) is None
    assert sentences.all_filled([f"Here {template}.", "There."], found) == ["There."]


def test_what_was_not_found_is_no_number(tmp_path):
    claims, estimates = made_up_results.write(tmp_path, {"u-critical": HOLDS})
    table = pd.read_csv(estimates)
    own = (table["id"] == "u-critical") & (table["name"] == "critical")
    table.loc[own, ["value", "low", "high"]] = float("nan")
    table.to_csv(estimates, index=False)
    assert sentences.filled("At {u-critical}.", findings.read(claims, estimates)) is None


def test_minus_signs():
    assert sentences.typeset("-1.5 (-2 to -0.5), a-b, N - 1, 1e-05, x_-inf") == (
        "−1.5 (−2 to −0.5), a-b, N - 1, 1e−05, x_−∞"
    )


# --- findings -------------------------------------------------------------------------------------


def test_templates_name_what_the_ledger_has():
    for template in topics.templates():
        assert set(template["claims"]) <= set(LEDGER)
        assert set(template["heading"]) == {HOLDS, PARTLY, FAILS, UNDECIDED}
        assert template["figure"] in registry.figures()
        for sentence in template["sentences"]:
            texts = [sentence]
            if isinstance(sentence, dict):
                texts = [text for key, text in sentence.items() if key != "of"]
                assert sentence["of"] in LEDGER
                assert set(sentence) <= {"of", *VERDICTS}
            for place in (place for text in texts for place in sentences.places(text)):
                claim, name = sentences.place_of(place)
                allowed = LEDGER[claim].criterion["allowed"]
                if name is None:
                    assert len(allowed) == 1 or place.startswith(("why ", "verdict "))
                else:
                    assert name in allowed


@pytest.mark.parametrize("verdict", [HOLDS, FAILS, UNDECIDED])
def test_the_words_of_a_finding_follow_its_verdict(tmp_path, verdict):
    found = findings.chosen(results(tmp_path, everything=verdict))
    assert len(found) == len(topics.templates())
    for finding, template in zip(found, topics.templates(), strict=True):
        assert finding.verdict == verdict and finding.heading == template["heading"][verdict]
        assert len(finding.sentences) >= 2
        assert not re.search(r"nan|\{|\}", " ".join(finding.sentences))


def test_a_finding_is_told_only_if_its_claims_are_measured(tmp_path):
    found = findings.chosen(results(tmp_path, everything=HOLDS, r_jump=NOT_MEASURED))
    assert "transition" not in [each.name for each in found]
    assert len(found) == len(topics.templates()) - 1


@pytest.mark.parametrize(
    ("verdicts", "together"),
    [
        ([HOLDS, HOLDS], HOLDS),
        ([FAILS, FAILS], FAILS),
        ([HOLDS, FAILS], PARTLY),
        ([PARTLY, PARTLY], PARTLY),
        ([HOLDS, UNDECIDED], UNDECIDED),
        ([FAILS, UNDECIDED], UNDECIDED),
        ([UNDECIDED, UNDECIDED], UNDECIDED),
        ([HOLDS, PARTLY, UNDECIDED], PARTLY),
    ],
)
def test_claims_taken_together(verdicts, together):
    class Judged:
        def __init__(self, verdict):
            self.verdict = verdict

    assert topics.together(map(Judged, verdicts)) == together


def test_what_a_figure_shows_is_said_by_verdict(tmp_path):
    found = results(tmp_path, u_critical=FAILS, r_jump=HOLDS)
    said = pictures.seen([found["r-jump"], found["u-critical"]])
    words = sentences.typeset(found["u-critical"].counted.numbers["critical"].words)
    assert said[1] == f"Not as the paper says: u-critical, with critical {words}."
    assert said[0].startswith("As the paper says: r-jump, with r_chaotic ") and len(said) == 2


# --- readings and other runs ----------------------------------------------------------------------


def test_a_printed_number_lies_inside_or_outside_what_the_readings_give(tmp_path):
    inside = {each.result.id: each for each in readings.printed(results(tmp_path).values())}
    assert inside["u-critical"].value == 16.5
    claims, estimates = made_up_results.write(tmp_path)
    table = pd.read_csv(estimates)
    own = table["id"] == "u-critical"
    table.loc[own, ["value", "low", "high"]] = [18.0, 17.9, 18.2]
    table.to_csv(estimates, index=False)
    (moved,) = (
        each
        for each in readings.printed(findings.read(claims, estimates).values())
        if each.result.id == "u-critical"
    )
    assert (moved.low, moved.high, moved.inside) == (17.9, 18.2, False)
    table.loc[own & table["variant"].isna(), ["low"]] = 16.4
    table.to_csv(estimates, index=False)
    again = readings.printed(findings.read(claims, estimates).values())
    assert next(each for each in again if each.result.id == "u-critical").inside


def test_whether_the_verdict_depends_on_the_reading(tmp_path):
    found = results(tmp_path)
    for result in found.values():
        verdicts = {each.verdict for each in result.readings}
        said = readings.together(result)
        if len(result.readings) == 1:
            assert said == ""
        elif len(verdicts) == 1:
            assert said == f"All {len(result.readings)} readings give this verdict."
        else:
            assert said.startswith("The verdict depends on the reading: ")
            assert all(f" {verdict}" in said for verdict in verdicts)


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("the paper's scheme", ["integrator"]),
        ("wider starts", ["initial state"]),
        ("time step 0.002", ["time step"]),
        ("one run at each u", ["number of runs"]),
        ("one long run", ["length"]),
        ("exact dynamics, run from the declared state", ["integrator"]),
        ("phases longer than 784", []),
        ("after a transient of 1e5", ["transient"]),
        ("running median over 5", []),
    ],
)
def test_what_a_reading_changes(name, what):
    assert readings.changed(name) == what


@pytest.mark.parametrize("place", [20.0, 10.0])
def test_shifts_of_the_claims_that_carry_the_paper(tmp_path, place):
    assert set(readings.CARRYING) <= set(LEDGER)
    claims, estimates = made_up_results.write(tmp_path, dict.fromkeys(LEDGER, HOLDS))
    for path in (claims, estimates):
        path.write_text(re.sub(r"reading 0 of \d+", "wider starts", path.read_text()))
    found = readings.shifts(findings.read(claims, estimates))
    assert {each.what for each in found} == {"initial state"}
    assert not any(each.matters or each.turns for each in found)
    table = pd.read_csv(estimates)
    own = (table["id"] == "u-critical") & (table["variant"] == "wider starts")
    table.loc[own, ["value", "low", "high", "verdict"]] = [place, place - 0.1, place + 0.1, FAILS]
    table.to_csv(estimates, index=False)
    found = readings.shifts(findings.read(claims, estimates))
    (moved,) = (each for each in found if each.matters)
    assert moved.result.id == "u-critical" and moved.turns and abs(moved.shift.value) > 2
    table.loc[own, ["low", "high"]] = [-np.inf, np.inf]
    table.to_csv(estimates, index=False)
    found = {each.result.id: each for each in readings.shifts(findings.read(claims, estimates))}
    assert found["u-critical"].matters is None
    assert found["u-critical"].other.words == f"{place:g} (one run)"
    table.loc[own, ["value", "low", "high"]] = np.nan
    table.to_csv(estimates, index=False)
    found = readings.shifts(findings.read(claims, estimates))
    assert "u-critical" not in {each.result.id for each in found}


def test_runs_are_compared_claim_by_claim(tmp_path):
    ours = results(tmp_path / "a", everything=HOLDS)
    other, _ = made_up_results.write(
        tmp_path / "b", dict.fromkeys(LEDGER, HOLDS) | {"r-jump": FAILS}
    )
    text = other.read_text().replace(LEDGER["u-critical"].criterion["text"], "an earlier one")
    other.write_text(text)
    found = presets.compare(ours, {"b": other})
    assert (found.runs, found.known, found.same) == (("b",), (len(LEDGER) - 1,), (len(LEDGER) - 2,))
    assert [(result.id, verdicts) for result, verdicts in found.rows] == [("r-jump", (FAILS,))]
    assert presets.compare(ours, {}) is None


@pytest.mark.parametrize(
    ("duration", "words"),
    [(1e5, "t = 100000, those of the paper t = 2e6"), (2e6, "t = 2e6, as long as those")],
)
def test_trust_says_how_long_the_runs_are(tmp_path, duration, words):
    settings = {"datasets": {reliability.DECIDING: {"duration": duration}}}
    said = reliability.trust(results(tmp_path), settings)
    assert words in said[0]
    missing = [each.id for each in results(tmp_path).values() if each.verdict == NOT_MEASURED]
    assert said[-1] == f"Not measured: {', '.join(missing)}."

"""Results, sentences, findings and comparisons say what the tables of claims say."""

import math
import re
from collections import Counter

import pandas as pd
import pytest

import made_up_results
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import io, registry
from beltrepro.replication.report import findings
from beltrepro.replication.report.claim_results import count, read
from beltrepro.replication.verdicts.criteria import QUESTIONS, VERDICTS, names_in
from beltrepro.replication.verdicts.ledger import load_ledger

LEDGER = load_ledger()


def results(folder, everything, **verdicts):
    """Results of a made-up run; `everything` is the verdict of all claims but those given."""
    made_up_results.write(folder, dict.fromkeys(LEDGER, everything) | verdicts)
    return read(folder)


def with_numbers(folder, *numbers):
    """Results of a run with these rows for u-critical: reading, name, value, low, high, decides,
    allowed range, verdict; the first reading is that of `replicated`, the last that of `robust`."""
    claims, estimates = made_up_results.tables({"u-critical": "yes"})
    ours = claims["id"] == "u-critical"
    claims.loc[ours, "replicated_reading"] = numbers[0][0]
    claims.loc[ours, "robust_reading"] = numbers[-1][0]
    names = ("reading", "name", "value", "low", "high", "decides",
             "allowed_low", "allowed_high", "verdict")  # fmt: skip
    rows = pd.DataFrame(numbers, columns=names).assign(id="u-critical", runs=8)
    estimates = pd.concat([estimates[estimates["id"] != "u-critical"], rows])
    folder.mkdir(exist_ok=True)
    claims.to_csv(folder / "claims.csv", index=False)
    estimates.to_csv(folder / "estimates.csv", index=False)
    return read(folder)


ROW = ("scheme", "critical", 16.7, 16.4, 17.2, "replicated", 15.0, 18.0, "yes")
EXACT = ("exact", "critical", 17.3, 16.9, 17.5, "robust", 15.0, 17.0, "open")
BESIDE = ("exact", "width", -0.5, math.nan, math.nan, "", math.nan, math.nan, "")


def test_all_that_the_tables_say_is_read(tmp_path):
    claims, estimates = made_up_results.tables()
    made_up_results.write(tmp_path)
    made = read(tmp_path)
    assert list(made) == list(LEDGER)
    for row in claims.to_dict("records"):
        result, rows = made[row["id"]], estimates[estimates["id"] == row["id"]]
        for name in ("paper", "note", "dataset"):
            assert getattr(result, name) == row[name]
        assert list(result.readings) == list(rows["reading"].unique())
        for question, answer in result.answers.items():
            assert answer.verdict == row[question] == result.verdicts[question]
            for end in ("found", "reading", "runs"):
                assert getattr(answer, end) == row[f"{question}_{end}"]
            of_reading = rows[rows["reading"] == answer.reading]
            assert list(answer.numbers) == list(of_reading["name"].unique())
            deciding = of_reading[of_reading["decides"].str.contains(question)]
            for number, other in zip(answer.judged, deciding.to_dict("records"), strict=True):
                assert (number.name, number.verdict) == (other["name"], other["verdict"])
                ends = ("value", "low", "high", "allowed_low", "allowed_high")
                expected = pytest.approx([other[name] for name in ends], rel=1e-5)
                assert [*number.estimate.numbers, *number.allowed] == expected
    for question, numbers in count(made).items():
        answers = claims.loc[claims["kind"].isin(["number", "shape", "recording"]), question]
        assert numbers == dict.fromkeys(VERDICTS, 0) | Counter(answers)


def test_each_question_has_the_numbers_of_its_reading_by_its_range(tmp_path):
    same = (*ROW[:5], "robust", 17.0, 18.0, "no")
    answers = with_numbers(tmp_path, ROW, same)["u-critical"].answers.values()
    judged = [(number.allowed, number.verdict) for one in answers for number in one.judged]
    assert judged == [((15.0, 18.0), "yes"), ((17.0, 18.0), "no")]
    answers = with_numbers(tmp_path, ROW, BESIDE, EXACT)["u-critical"].answers.values()
    assert [list(one.numbers) for one in answers] == [["critical"], ["width", "critical"]]
    assert [[number.name for number in one.judged] for one in answers] == [["critical"]] * 2


def test_tables_that_do_not_fit_are_refused(tmp_path):
    claims, _ = made_up_results.write(tmp_path)
    whole = io.rows(claims)
    claims.write_text(claims.read_text().replace("u-critical,", "u-crit,"))
    with pytest.raises(InputError, match=r"claims.csv: damaged: its bytes are not those of its se"):
        read(tmp_path)
    claims.write_text(whole.replace("replicated", "variant"))
    with pytest.raises(InputError, match=r"tables made by an earlier version \('replicated'\)"):
        read(tmp_path)


def test_sentences_take_their_numbers_from_the_tables(tmp_path):
    made = with_numbers(tmp_path, ROW, BESIDE, EXACT)
    for template, text in (
        ("At {u-critical: critical}.", "At 16.7 (16.4 to 17.2)."),
        ("At {value robust u-critical: critical}.", "At 17.3."),
        ("At {robust u-critical: width}.", "At −0.5 (error not known)."),
        ("At {u-critical: width}.", "Not found: u-critical: width."),
    ):
        assert findings.filled(template, made) == text
    assert findings.typeset("-1.5 (-2 to -0.5), a-b, N - 1, 1e-05") == (
        "−1.5 (−2 to −0.5), a-b, N - 1, 1e−05"
    )


def test_findings_name_what_the_ledger_has():
    rows = findings.words()["numbers"]
    assert all(row["claim"] in LEDGER for row in rows)
    places = [row[way] for row in rows for way in findings.WAYS if way in row]
    for entry in findings.words()["findings"] + findings.words()["fall"]:
        assert entry["figure"] in registry.figures() and entry["verdicts"].keys() <= LEDGER.keys()
        for wanted in entry["verdicts"].values():
            assert {*wanted} <= {*QUESTIONS} and {*wanted.values()} <= {*VERDICTS}
        places += [*names_in(entry["text"]), *entry["numbers"]]
    for place in places:
        claim, name = place.removeprefix("robust ").split(": ")
        criterion = LEDGER[claim].criteria[QUESTIONS[place.startswith("robust ")]]
        assert name in {*criterion.allowed, *names_in(criterion.found)}, place


def test_a_claim_that_a_run_lacks_is_a_number_not_found(tmp_path, monkeypatch):
    made = with_numbers(tmp_path, ROW, EXACT)
    entry = {"what": "u", "printed": "-16", "scheme": "u-critical: critical",
             "starts": "no-claim: critical", "claim": "no-claim"}  # fmt: skip
    monkeypatch.setattr(findings, "words", lambda: {"numbers": [entry]})
    row = ("u", "\u221216", "16.7 (16.4 to 17.2)", "", "not found", "")
    assert list(findings.printed_and_measured(made)) == [row]


@pytest.mark.parametrize(
    ("change", "unmet"),
    [
        ({}, ""),
        ({"numbers": {"robust u-critical: critical": [16.9, 17.5]}}, ""),
        ({"verdicts": {"u-critical": {"robust": "open"}}}, "u-critical is yes as robust, not open"),
        ({"numbers": {"u-critical: critical": [16.5, 18]}},
         "u-critical: critical is 16.7 (16.4 to 17.2), not 16.5 to 18"),
        ({"numbers": {"u-critical: critical": [16, 17.1]}},
         "u-critical: critical is 16.7 (16.4 to 17.2), not 16 to 17.1"),
        ({"numbers": {"u-critical: none": [0, 1]}}, "u-critical: none is not found, not 0 to 1"),
        ({"text": "At {u-critical: none}."}, "a number in it was not found"),
    ],
)  # fmt: skip
def test_the_condition_that_is_not_met_is_named(tmp_path, monkeypatch, change, unmet):
    entry = {"topic": "t", "text": "At {u-critical: critical}.", "figure": "fig12"}
    entry |= {"verdicts": {"u-critical": {"replicated": "yes"}}}
    entry |= {"numbers": {"u-critical: critical": [16, 18]}} | change
    monkeypatch.setattr(findings, "words", lambda: {"findings": [entry], "why": []})
    made = with_numbers(tmp_path, ROW, EXACT)
    (finding,) = findings.findings_of(made)
    assert finding.unmet == [unmet] * bool(unmet)
    if not unmet:
        assert finding.text == "At 16.7 (16.4 to 17.2)." and findings.check(made) is None
        return
    with pytest.raises(InputError, match=re.escape(f"is not what this run found: {unmet};")):
        findings.check(made)

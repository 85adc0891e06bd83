"""Results, sentences, findings and comparisons say what the tables of claims say."""

import math
import re
from collections import Counter

import pandas as pd
import pytest

import made_up_results
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import io, registry
from beltrepro.replication.report import claim_results, findings, sentences, trust
from beltrepro.replication.report.claim_results import count, read, read_tables
from beltrepro.replication.verdicts.criteria import QUESTIONS, VERDICTS, names_in
from beltrepro.replication.verdicts.ledger import FINDINGS, SEEN, load_ledger

LEDGER = load_ledger()
ENTRIES = {entry["topic"]: entry for entry in findings.words()["findings"]}


def results(folder, everything=None, **verdicts):
    """Results of a made-up run; `everything` is the verdict of all claims but those given."""
    wanted = dict.fromkeys(LEDGER, everything) if everything else {}
    wanted |= {name.replace("_", "-"): verdict for name, verdict in verdicts.items()}
    return read_tables(*made_up_results.write(folder, wanted))


def with_numbers(folder, *numbers):
    """Results of a run with these rows for u-critical: reading, name, value, low, high, decides,
    allowed range, verdict; the first reading is that of `replicated`, the last that of `robust`."""
    claims, estimates = made_up_results.tables({"u-critical": "yes"})
    ours = claims["id"] == "u-critical"
    claims.loc[ours, "replicated_reading"] = numbers[0][0]
    claims.loc[ours, "robust_reading"] = numbers[-1][0]
    names = ("reading", "name", "value", "low", "high", "decides",
             "allowed_low", "allowed_high", "verdict")  # fmt: skip
    rows = [
        {"id": "u-critical", "runs": 8, **dict(zip(names, row, strict=True))} for row in numbers
    ]
    folder.mkdir(exist_ok=True)
    claims.to_csv(folder / "claims.csv", index=False)
    table = pd.concat([estimates[estimates["id"] != "u-critical"], pd.DataFrame(rows)])
    table.to_csv(folder / "estimates.csv", index=False)
    return read_tables(folder / "claims.csv", folder / "estimates.csv")


BOTH = "replicated, robust"
ROW = ("scheme", "critical", 16.7, 16.4, 17.2, "replicated", 15.0, 18.0, "yes")
EXACT = ("exact", "critical", 17.3, 16.9, 17.5, "robust", 15.0, 17.0, "open")
BESIDE = ("exact", "width", -0.5, math.nan, math.nan, "", math.nan, math.nan, "")


# --- tables ---------------------------------------------------------------------------------------


def test_all_that_the_tables_say_is_read(tmp_path):
    claims, estimates = made_up_results.tables()
    made = results(tmp_path)
    assert list(made) == list(LEDGER)
    for row in claims.to_dict("records"):
        result = made[row["id"]]
        rows = estimates[estimates["id"] == row["id"]]
        assert (result.paper, result.note, result.dataset) == (
            row["paper"], row["note"], row["dataset"])  # fmt: skip
        assert list(result.readings) == list(rows["reading"].unique())
        for question, answer in result.answers.items():
            assert answer.verdict == row[question] == result.verdicts[question]
            for end in ("found", "reading", "tried", "how", "because", "reason", "runs"):
                assert getattr(answer, end) == row[f"{question}_{end}"]
            of_reading = rows[rows["reading"] == answer.reading]
            assert list(answer.numbers) == list(of_reading["name"].unique())
            deciding = of_reading[of_reading["decides"].str.contains(question)]
            for number, other in zip(answer.judged, deciding.to_dict("records"), strict=True):
                assert (number.name, number.verdict) == (other["name"], other["verdict"])
                ends = (*number.estimate.numbers, *number.allowed)
                expected = [other[name] for name in
                        ("value", "low", "high", "allowed_low", "allowed_high")]  # fmt: skip
                assert ends == pytest.approx(expected, rel=1e-5)


def test_each_question_has_the_numbers_of_its_reading_by_its_range(tmp_path):
    same = [(*ROW[:5], "robust", 17.0, 18.0, "no")]
    answers = with_numbers(tmp_path, ROW, *same)["u-critical"].answers
    assert [answer.numbers["critical"].allowed for answer in answers.values()] == [
        (15.0, 18.0), (17.0, 18.0)]  # fmt: skip
    assert [answer.numbers["critical"].verdict for answer in answers.values()] == ["yes", "no"]
    for rows in ([ROW, EXACT, BESIDE], [ROW, BESIDE, EXACT]):
        result = with_numbers(tmp_path, *rows)["u-critical"]
        replicated, robust = result.answers.values()
        assert list(replicated.numbers) == ["critical"] and [*result.readings] == [
            "scheme",
            "exact",
        ]
        assert {n.name: n.words for n in robust.numbers.values()} == {
            "critical": "17.3 (16.9 to 17.5)", "width": "-0.5 (error not known)"}  # fmt: skip
        assert [n.name for n in robust.judged] == ["critical"]
        assert robust.numbers["width"].allowed_words == robust.numbers["width"].verdict == ""


def test_tables_that_do_not_fit_are_refused(tmp_path):
    claims, estimates = made_up_results.write(tmp_path)
    whole = io.rows(claims)
    claims.write_text(claims.read_text().replace("u-critical,", "u-crit,"))
    with pytest.raises(InputError, match=r"claims.csv: damaged: its bytes are not those of its se"):
        read(tmp_path)
    claims.write_text(whole.replace("u-critical,", "u-crit,"))
    with pytest.raises(InputError, match="'u-crit' is not in the ledger"):
        read_tables(claims, estimates)
    claims.write_text(whole.replace("replicated", "variant"))
    with pytest.raises(InputError, match="made by an earlier version"):
        read_tables(claims, estimates)
    with pytest.raises(InputError, match=r"claims.csv: no such file"):
        read(tmp_path / "none")


def test_claims_are_counted_by_question_and_what_could_not_come_out_otherwise_apart(tmp_path):
    claims, _ = made_up_results.tables()
    counts = count(results(tmp_path))
    findings_only = claims[claims["kind"].isin(FINDINGS)]
    for question in QUESTIONS:
        numbers = Counter(findings_only[question])
        assert counts.verdicts[question] == {verdict: numbers[verdict] for verdict in VERDICTS}
    kinds = Counter(claim.kind for claim in LEDGER.values())
    apart = ("validation", "construction", "explanation")
    assert counts.apart == {kind: kinds[kind] for kind in apart}
    assert counts.total == len(findings_only) == len(LEDGER) - sum(counts.apart.values())
    untestable = claims[[*QUESTIONS]].eq("not testable").all(axis=1).sum()
    assert counts.testable == counts.total - untestable < counts.total


# --- sentences ------------------------------------------------------------------------------------


def test_sentences_take_their_numbers_from_the_tables(tmp_path):
    made = with_numbers(tmp_path, ROW, BESIDE, EXACT)
    for template, text in (
        ("At {u-critical: critical}.", "At 16.7 (16.4 to 17.2)."),
        ("At {u-critical}.", "At 16.7 (16.4 to 17.2)."),
        ("At {value robust u-critical: critical}.", "At 17.3."),
        ("At {robust u-critical: width}.", "At −0.5 (error not known)."),
        ("{=a} of {=b}", "1 of 2"),
    ):
        assert sentences.filled(template, made, {"a": "1", "b": "2"}) == text
    for place in ("u-critical: width", "nothing: a", "robust u-critical: none", "r-jump", "=none"):
        assert sentences.filled(f"Here {{{place}}}.", made) is None


def test_what_was_searched_for_and_not_found_is_no_number(tmp_path):
    lost = with_numbers(tmp_path, (*ROW[:2], math.nan, math.nan, math.nan, *ROW[5:]))
    assert sentences.filled("At {u-critical}.", lost) is None


def test_signs_and_stops():
    assert sentences.typeset("-1.5 (-2 to -0.5), a-b, N - 1, 1e-05, x_-inf") == (
        "−1.5 (−2 to −0.5), a-b, N - 1, 1e−05, x_−∞"
    )
    whole = {"the end": "The end.", "r is": "r is.", "Why?": "Why?", "“so.”": "“so.”", " ": ""}
    assert {text: sentences.as_sentence(text) for text in whole} == whole


# --- findings -------------------------------------------------------------------------------------


def test_there_are_five_to_seven_findings_and_they_name_what_the_ledger_has():
    assert 5 <= len(ENTRIES) <= 7
    for topic, entry in ENTRIES.items():
        assert entry["figure"] in registry.figures() and entry["verdicts"], topic
        assert entry["text"].endswith(".") and "{" not in topic
        for claim, wanted in entry["verdicts"].items():
            assert claim in LEDGER and set(wanted) <= set(QUESTIONS)
            assert {findings.word_of(word) for word in wanted.values()} <= set(VERDICTS)
    places = [place for entry in ENTRIES.values()
              for place in (*names_in(entry["text"]), *entry["numbers"])]  # fmt: skip
    places += [row["place"] for row in findings.words()["numbers"]]
    for place in places:
        question, claim, name = sentences.place_of(place)
        criterion = getattr(LEDGER[claim], question)
        names = [*criterion.allowed, *names_in(criterion.found)]
        assert name in names if name else len(criterion.allowed) == 1, place


def finding(tmp_path, monkeypatch, *rows, **change):
    """A finding on the critical velocity in a run with these numbers."""
    entry = {"topic": "t", "text": "At {u-critical: critical}.", "figure": "fig12"}
    entry |= {"verdicts": {"u-critical": {"replicated": True}}}
    entry |= {"numbers": {"u-critical: critical": [16, 18]}} | change
    monkeypatch.setattr(findings, "words", lambda: {"findings": [entry]})
    made = with_numbers(tmp_path, *(rows or [ROW]))
    (one,) = findings.findings_of(made)
    if one.unmet:
        with pytest.raises(InputError, match=re.escape(f"{one.text!r} is not what")):
            findings.check(made)
    else:
        findings.check(made)
    return one


def test_a_finding_holds_if_all_its_conditions_are_met(tmp_path, monkeypatch):
    met = finding(tmp_path, monkeypatch)
    assert (met.unmet, met.text) == ((), "At 16.7 (16.4 to 17.2).")
    assert [result.id for result in met.results] == ["u-critical"]
    robust = {"robust u-critical: critical": [16.9, 17.5]}
    assert finding(tmp_path, monkeypatch, ROW, EXACT, numbers=robust).unmet == ()


@pytest.mark.parametrize(
    ("change", "unmet"),
    [
        ({"verdicts": {"u-critical": {"robust": "open"}}}, "u-critical is yes as robust, not open"),
        ({"verdicts": {"u-critical": {"replicated": False}}},
         "u-critical is yes as replicated, not no"),
        ({"numbers": {"u-critical": [16.5, 18]}},
         "u-critical is 16.7 (16.4 to 17.2), not 16.5 to 18"),
        ({"numbers": {"u-critical": [16, 17.1]}},
         "u-critical is 16.7 (16.4 to 17.2), not 16 to 17.1"),
        ({"numbers": {"u-critical: none": [0, 1]}}, "u-critical: none is not found, not 0 to 1"),
        ({"text": "At {u-critical: none}."}, "a number in it was not found"),
        ({"verdicts": {"none": {"robust": True}}}, "none is missing as robust, not yes"),
    ],
)  # fmt: skip
def test_the_condition_that_is_not_met_is_named(tmp_path, monkeypatch, change, unmet):
    assert finding(tmp_path, monkeypatch, **change).unmet == (unmet,)


# --- other runs, and trust ------------------------------------------------------------------------


def test_runs_are_compared_by_what_both_decide(tmp_path):
    taken = ("r-jump", "outliers")
    several = next(claim.id for claim in LEDGER.values() if claim.finding and claim.id not in taken
                   and all(len(one.allowed) > 1 for one in claim.criteria.values()))  # fmt: skip
    ours = results(tmp_path / "a", "yes", outliers="no", u_critical="open")
    changed = {"r-jump": "no", several: "in part", "outliers": "open", "units": "no"}
    paths = [
        made_up_results.write(tmp_path / name, dict.fromkeys(LEDGER, "yes") | verdicts)[0]
        for name, verdicts in (("b", changed), ("c", {}), ("d", {}))
    ]
    whole = paths[1].read_text()
    paths[1].write_text(whole.replace(",yes,", ",no,", 1))
    with pytest.raises(InputError, match=r"c.claims.csv: damaged: its bytes are not those of its"):
        claim_results.compared(ours, paths)
    paths[1].write_text(whole)
    earlier = io.read_table(paths[1], dtype=str, keep_default_na=False)
    earlier.loc[earlier["id"] == "r-windows", "robust_criterion"] = "an earlier one"
    earlier.to_csv(paths[1], index=False)
    paths[2].write_text("id,variant,verdict\nr-jump,,holds\n")  # of an earlier version: left out
    one, two = claim_results.compared(ours, paths)
    for question, fewer in (("replicated", 0), ("robust", 1)):
        criteria = [claim.criteria[question] for claim in LEDGER.values() if claim.finding]
        both = sum(not criterion.untestable for criterion in criteria) - 2
        assert one.agreement(ours, question) == (both, both - 2, 1)
        differ = {
            name: pair for name, pair in one.pairs(ours, question).items() if len({*pair}) > 1
        }
        assert differ == {"r-jump": ("yes", "no"), several: ("yes", "in part")}
        both += 1 - fewer  # outliers too
        assert two.agreement(ours, question) == (both, both - 1, 1)
    _, _, compared = trust.trust(ours, {}, [one])
    begin = f"The run b decides {len(one.pairs(ours, 'robust'))} of the same statements as robust: "
    assert compared.startswith(begin) and compared.endswith(" alike, 1 the other way round.")


@pytest.mark.parametrize(
    ("duration", "words"),
    [(40000.0, "last t = 40000, those of the paper t = 2e6."),
     (2e6, "last t = 2e6, as long as those of the paper.")],
)  # fmt: skip
def test_trust_says_how_long_the_runs_are_and_how_many(tmp_path, duration, words):
    settings = {"datasets": {trust.DECIDING: {"duration": duration}}}
    made = results(tmp_path)
    said = list(trust.trust(made, settings))
    assert words in said[0]
    # frames of a film, of which a test of our camera counts thousands, are no runs
    findings = [result for result in made.values() if result.claim.finding]
    answers = [answer for result in findings for answer in result.answers.values()]
    numbers = [number.estimate.runs for answer in answers for number in answer.judged]
    runs = sorted(filter(None, numbers))
    assert len(findings) < len(made)
    middle = runs[(len(runs) - 1) // 2]
    assert f"on {middle} independent runs (median; {runs[0]} to {runs[-1]})" in said[1]


def test_dates_are_told_with_a_count_of_what_had_been_seen(tmp_path):
    made = results(tmp_path)
    testable = [claim for claim in LEDGER.values() if claim.finding and claim.testable]
    counts = Counter(claim.seen for claim in testable)
    begin, *numbers = (counts[seen] or "none" for seen in SEEN)
    assert trust.dates(made) == (
        f"The criteria are no predictions. Of {len(testable)} statements that can be tested, "
        f"{numbers[2]} have criteria that were written or last changed after the published run had "
        f"been seen, {numbers[1]} after long trial runs, {numbers[0]} after short ones and {begin} "
        "before any run."
    )
    after = [claim.id for claim in testable if claim.seen == "the published run"]
    assert [result.id for result in trust.dated(made, "the published run")] == after != []

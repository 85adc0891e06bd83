"""Results, sentences, findings, readings and comparisons say what the tables of claims say."""

import dataclasses
import math

import numpy as np
import pandas as pd
import pytest

import made_up_results
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import registry
from beltrepro.replication.report import findings, readings, sentences, trust
from beltrepro.replication.report.claim_results import Number, Reading, read, read_tables
from beltrepro.replication.verdicts.criteria import VERDICTS
from beltrepro.replication.verdicts.ledger import CHANGES, load_ledger
from beltrepro.stats.estimates import Estimate

LEDGER = load_ledger()


def results(folder, everything=None, **verdicts):
    """Results of a made-up run; `everything` is the verdict of all claims but those given."""
    wanted = dict.fromkeys(LEDGER, everything) if everything else {}
    wanted |= {name.replace("_", "-"): verdict for name, verdict in verdicts.items()}
    return read_tables(*made_up_results.write(folder, wanted))


def edited(folder, change, **verdicts):
    """Results of a made-up run whose table of estimates was changed by `change(table)`."""
    verdicts = {name.replace("_", "-"): verdict for name, verdict in verdicts.items()}
    paths = made_up_results.write(folder, verdicts)
    table = pd.read_csv(paths[1])
    change(table)
    table.to_csv(paths[1], index=False)
    return read_tables(*paths)


# --- tables ---------------------------------------------------------------------------------------


def test_all_that_the_tables_say_is_read(tmp_path):
    claims, estimates = made_up_results.tables()
    made = results(tmp_path)
    assert list(made) == list(LEDGER)
    for row in claims.to_dict("records"):
        reading = {one.name: one for one in made[row["id"]].readings}[row["variant"]]
        said = (reading.verdict, reading.reason, reading.note)
        assert said == (row["verdict"], row["reason"], row["note"])
        rows = estimates[(estimates["id"] == row["id"]) & (estimates["variant"] == row["variant"])]
        assert list(reading.numbers) == list(rows["name"])
        for name, verdict, value in zip(rows["name"], rows["verdict"], rows["value"], strict=True):
            number = reading.numbers[name]
            assert number.verdict == verdict
            assert number.estimate.value == pytest.approx(value, rel=1e-5)


def test_a_table_without_reasons_has_them_at_the_head_of_its_notes(tmp_path):
    """As runs of beltrepro up to 0.1 left it, and as the published one has it."""
    claims, estimates = made_up_results.write(tmp_path)
    table = pd.read_csv(claims, dtype=str, keep_default_na=False)
    new = read_tables(claims, estimates)
    both = [
        ". ".join(filter(None, row)) for row in zip(table["reason"], table["note"], strict=True)
    ]
    table.assign(note=both).drop(columns="reason").to_csv(claims, index=False)
    old = read_tables(claims, estimates)
    pairs = [(x, y) for name in new
             for x, y in zip(old[name].readings, new[name].readings, strict=True)]  # fmt: skip
    same = [x.why == y.why for x, y in pairs if y.reason]
    assert len(same) > 40 and np.mean(same) > 0.8  # others differ in a digit that was rounded
    said = [". ".join(filter(None, (x.reason, x.note))) for x, _ in pairs]
    assert said == both  # nothing is lost


def test_a_claim_that_the_ledger_lacks_is_refused(tmp_path):
    claims, _ = made_up_results.write(tmp_path)
    claims.write_text(claims.read_text().replace("u-critical,", "u-crit,"))
    with pytest.raises(InputError, match="'u-crit' is not in the ledger"):
        read(tmp_path)
    with pytest.raises(InputError, match=r"claims.csv: no such file"):
        read(tmp_path / "none")


@pytest.mark.parametrize(
    ("verdict", "reason", "note", "why"),
    [
        ("fails", "a: 1.5, not 2", "the runs end", "It fails by a: 1.5, not 2. The runs end."),
        ("partly", "a: 1, not 2", "r is low", "It fails in part, by a: 1, not 2. r is low."),
        ("undecided", "a: 1. b", "Why. So", "It is undecided by a: 1. b. Why. So."),
        ("not measured", "", "there is no u1", "There is no u1."),
        ("holds", "", "only noted", ""),
    ],
)
def test_why_a_claim_does_not_hold(verdict, reason, note, why):
    number = Number("a", Estimate(1.0, 1.0, 1.0, None), (0.0, 1.0), verdict)
    assert Reading("", verdict, reason, note, "9", {"a": number}).why == why


# --- sentences ------------------------------------------------------------------------------------


def test_sentences_take_their_numbers_from_the_tables(tmp_path):
    made = results(tmp_path, "holds", u_critical="fails")
    number = made["u-critical"].counted.numbers["critical"].words
    for template, text in (
        ("At {u-critical: critical}.", f"At {number}."),
        ("At {u-critical}.", f"At {number}."),
        ("It {verdict u-critical}.", "It fails."),
        ("{=a} of {=b}", "1 of 2"),
    ):
        assert sentences.filled(template, made, {"a": "1", "b": "2"}) == text
    assert sentences.filled("{why u-critical}", made).startswith("It fails by critical: ")
    for place in ("u-critical: nothing", "nothing", "r-jump", "why r-jump", "=nothing"):
        templates = [f"Here {{{place}}}.", "There."]
        assert sentences.all_filled(templates, made) == ["There."]


def test_what_was_searched_for_and_not_found_is_no_number(tmp_path):
    def lose(table):
        table.loc[table["id"] == "u-critical", ["value", "low", "high"]] = math.nan

    assert sentences.filled("At {u-critical}.", edited(tmp_path, lose, u_critical="holds")) is None


def test_minus_signs():
    assert sentences.typeset("-1.5 (-2 to -0.5), a-b, N - 1, 1e-05, x_-inf") == (
        "−1.5 (−2 to −0.5), a-b, N - 1, 1e−05, x_−∞"
    )


# --- findings -------------------------------------------------------------------------------------


def test_templates_name_what_the_ledger_has():
    for template in findings.templates():
        assert set(template["claims"]) <= set(LEDGER)
        assert set(template["heading"]) == {"holds", "partly", "fails", "undecided"}
        assert template["figure"] in registry.figures()
        for entry in template["sentences"]:
            texts = [entry]
            if isinstance(entry, dict):
                texts = [text for key, text in entry.items() if key != "of"]
                assert entry["of"] in LEDGER and set(entry) <= {"of", *VERDICTS}
            for place in (place for text in texts for place in sentences.places(text)):
                claim, name = sentences.place_of(place)
                allowed = LEDGER[claim].criterion["allowed"]
                if name is None:
                    assert len(allowed) == 1 or place.startswith(("why ", "verdict "))
                else:
                    assert name in allowed


def test_a_finding_is_told_only_if_all_its_claims_are_measured(tmp_path):
    made = findings.findings_of(results(tmp_path, "holds", r_jump="not measured"))
    topics = [template["topic"] for template in findings.templates()]
    assert [finding.topic for finding in made] == topics[1:]
    assert topics[0] == "The transition without noise"


@pytest.mark.parametrize(
    ("verdicts", "together"),
    [
        (["holds", "holds", "holds"], "holds"),
        (["fails", "fails"], "fails"),
        (["holds", "holds", "fails"], "partly"),
        (["holds", "undecided", "holds"], "undecided"),
        (["fails", "undecided"], "undecided"),
        (["holds", "partly", "undecided"], "partly"),
    ],
)
def test_claims_taken_together(tmp_path, verdicts, together):
    (claim, *_) = results(tmp_path).values()
    reading = claim.counted
    judged = [
        dataclasses.replace(claim, readings=(dataclasses.replace(reading, verdict=verdict),))
        for verdict in verdicts
    ]
    assert findings.verdict_of(judged) == together


# --- readings and other runs ----------------------------------------------------------------------


def test_a_printed_number_lies_inside_or_outside_what_the_readings_give(tmp_path):
    def printed(low, value, high, first_low):
        def change(table):
            rows = table["id"] == "u-critical"
            table.loc[rows, ["value", "low", "high"]] = [value, low, high]
            table.loc[rows & table["variant"].isna(), "low"] = first_low

        made = readings.printed(edited(tmp_path, change, u_critical="holds").values())
        return next(number for number in made if number.result.id == "u-critical")

    above = printed(17.9, 18.0, 18.2, first_low=16.6)
    assert (above.value, above.low, above.high, above.inside) == (16.5, 16.6, 18.2, False)
    assert printed(17.9, 18.0, 18.2, first_low=16.4).inside
    assert not printed(14.0, 15.0, 16.4, first_low=15.5).inside


def test_whether_the_verdict_depends_on_the_reading(tmp_path):
    for result in results(tmp_path).values():
        verdicts = {reading.verdict for reading in result.readings}
        said = readings.depends_on_reading(result)
        if len(verdicts) == 1:
            same = f"All {len(result.readings)} readings give this verdict."
            assert said == (same if result.variants else "")
            continue
        begin, _, parts = said.rstrip(".").partition(": ")
        assert begin == "The verdict depends on the reading"
        counts = [sum(r.verdict == verdict for r in result.readings) for verdict in verdicts]
        expected = {f"{n} {verdict}" for n, verdict in zip(counts, verdicts, strict=True)}
        assert set(parts.split(", ")) == expected


def test_shifts_of_the_claims_that_carry_the_paper(tmp_path):
    def shift(value, low, high):
        def change(table):
            rows = (table["id"] == "u-critical") & (table["variant"] == "wider starts")
            numbers = {"value": value, "low": low, "high": high, "verdict": "fails"}
            table.loc[rows, list(numbers)] = list(numbers.values())
            table.loc[(table["id"] == "u-critical") & table["variant"].isna(),
                      ["value", "low", "high"]] = [16.5, 16.2, 16.8]  # fmt: skip

        rows = readings.shifts(edited(tmp_path, change, u_critical="holds"))
        assert list(rows) == list(CHANGES) and not rows["time step"]
        for what in CHANGES:
            assert all(row.result.claim.changes[row.reading.name] == what for row in rows[what])
        return {row.result.id: row for row in rows["initial state"]}.get("u-critical")

    # the error of the difference: 0.5 of two independent ones of 0.3 and 0.4
    near, far = shift(16.9, 16.5, 17.3), shift(17.1, 16.7, 17.5)
    assert (near.matters, far.matters) == (False, True)
    assert near.turns and near.counted.verdict == "holds"
    assert far.shift.value == pytest.approx(0.6)
    single = shift(20.0, -np.inf, np.inf)
    assert single.matters is None and single.other.words == "20 (one run)"
    assert shift(math.nan, math.nan, math.nan) is None


def test_runs_are_compared_claim_by_claim(tmp_path):
    ours = results(tmp_path / "a", "holds")
    paths = []
    for name, failing in (("b", ("r-jump",)), ("c", ("outliers", "r-jump")), ("d", ())):
        verdicts = dict.fromkeys(LEDGER, "holds") | dict.fromkeys(failing, "fails")
        paths.append(made_up_results.write(tmp_path / name, verdicts)[0])
    criterion = LEDGER["u-critical"].criterion["text"]
    paths[1].write_text(paths[1].read_text().replace(criterion, "an earlier one"))
    others = readings.compared(ours, paths)
    total = len(LEDGER)
    assert [(run.name, len(run.verdicts), run.same) for run in others] == [
        ("b", total, total - 1), ("c", total - 1, total - 3), ("d", total, total)
    ]  # fmt: skip
    rows = [(result.id, verdicts) for result, verdicts in readings.differing(ours, others)]
    assert sorted(rows) == [
        ("outliers", ["holds", "fails", "holds"]),
        ("r-jump", ["fails", "fails", "holds"]),
    ]
    (*_, first, second, third) = trust.trust(ours, {}, others)
    assert second == f"{total - 3} of {total - 1} verdicts are those of the run c."
    assert readings.compared(ours, []) == [] and first != third


@pytest.mark.parametrize(
    ("duration", "words"),
    [(1e5, "t = 100000, those of the paper t = 2e6"), (1.6e6, "t = 1.6e6, those of the paper"),
     (2e6, "t = 2e6, as long as those"), (2.4e6, "t = 2.4e6, as long as those")],
)  # fmt: skip
def test_trust_says_how_long_the_runs_are_and_how_many(tmp_path, duration, words):
    settings = {"datasets": {trust.DECIDING: {"duration": duration}}}
    made = results(tmp_path)
    said = list(trust.trust(made, settings))
    assert words in said[0]
    runs = sorted(
        n.estimate.runs for r in made.values() for n in r.counted.judged if n.estimate.runs
    )
    middle = runs[(len(runs) - 1) // 2]
    assert f"on {middle} independent runs (median; {runs[0]} to {runs[-1]})" in said[1]
    missing = [result.id for result in made.values() if result.verdict == "not measured"]
    assert said[-1] == f"Not measured: {', '.join(missing)}."

"""What each verdict must say, and must not, on page, in article, README and terminal.

The tables below are written by hand, beside the code, so that words of one verdict under another,
or of one question under the other, are seen. One claim of a made-up run has the verdicts, all
others are replicated and robust.
"""

import re

import pytest

import pages
from beltrepro.cli import app
from beltrepro.replication.report import article, findings, publishing
from beltrepro.replication.report.sentences import typeset
from beltrepro.replication.verdicts.ledger import load_ledger
from made_up_results import MISSING

# Has a figure, and several numbers for each question, so that it can hold in part.
CLAIM = next(
    claim.id
    for claim in load_ledger().values()
    if claim.figure and claim.finding
    and all(len(one.allowed) > 1 for one in claim.criteria.values())
)  # fmt: skip
# A verdict: its badge.
TABLE = {
    "yes": ("✓", "yes"),
    "in part": ("◐", "in part"),
    "no": ("✗", "no"),
    "open": ("?", "open"),
    MISSING: ("?", "open"),
}
PAIRS = [("yes", "no"), ("no", "yes"), ("in part", "open"), ("open", "in part"), (MISSING, "yes")]
# Nothing that a reader sees may have these, whatever the verdicts.
NEVER = r"\bnan\b|\binf\b|\{|\}|undecided|not measured|fixed before|It fails by"


@pytest.fixture(scope="module", params=PAIRS, ids=" and ".join)
def run(request, tmp_path_factory):
    """(verdicts by question, material) of a run in docs/results/smoke."""
    folder = tmp_path_factory.mktemp("run") / "docs" / "results" / "smoke"
    asked = dict(zip(("replicated", "robust"), request.param, strict=True))
    verdicts = dict.fromkeys(load_ledger(), "yes") | {CLAIM: asked}
    return asked, pages.material(folder, verdicts=verdicts)


def test_the_page_says_it(run, tmp_path):
    asked, material = run
    text = pages.written(tmp_path, material)
    card = pages.cards(text)[CLAIM]
    badges = " ".join(f"{TABLE[asked[q]][0]} {q}: {TABLE[asked[q]][1]}" for q in asked)
    summary = re.search("<summary>(.*?)</summary>", card, re.S)[1]
    assert pages.words(summary).startswith(f"{CLAIM} {badges}")
    for question, verdict in asked.items():
        word = TABLE[verdict][1]
        assert f'data-{question}="{word}"' in card
        assert ("this preset has no dataset" in card.lower()) == (MISSING in asked.values())
        buttons = dict(re.findall(
            rf'data-show="{question}" data-verdict="([a-z ]+)" aria-pressed="false">[a-z ]+ (\d+)<',
            text))  # fmt: skip
        assert set(buttons) - {"not testable"} == {"yes", word}
        assert buttons[word] == "1" or word == "yes"
    number = load_ledger()[CLAIM].figure
    shown = pages.words(pages.picture(text, f"fig{number:02d}"))
    assert f"{CLAIM} {badges}" in shown
    visible = re.sub(r"<(script|style)\b[^>]*>.*?</\1>", "", text, flags=re.S)
    assert not re.search(NEVER, pages.words(visible))


def test_the_article_says_it(run):
    asked, material = run
    statement = typeset(load_ledger()[CLAIM].statement)
    rows = article.supplement(material.claims)["claims"]
    (row,) = [row for row in rows if row["statement"] == statement]
    assert (row["replicated"], row["robust"]) == tuple(TABLE[v][1] for v in asked.values())
    assert set(row["numbers"]) == {q for q, verdict in asked.items() if verdict != MISSING}
    assert not re.search(NEVER, str([*row.values()][:-1]))


def test_the_article_lists_the_criteria_not_changed_after_the_published_run(run):
    listed = article.supplement(run[1].claims)["before"]
    early = {
        typeset(claim.statement)
        for claim in load_ledger().values()
        if claim.finding and claim.testable and claim.seen != "the published run"
    }
    assert listed and set(listed) == early


def test_readme_counts_it(run):
    asked, material = run
    text = publishing.block(material.file("claims").parent.parent)
    for question, verdict in asked.items():
        (row,) = re.findall(rf"^\| {question} \| (.*) \|$", text, re.M)
        words = ("yes", "in part", "no", "open", "not testable")
        numbers = dict(zip(words, row.split(" | "), strict=True))
        word = TABLE[verdict][1]
        counted = {key for key, number in numbers.items() if number != "0"}
        assert counted == {"yes", "not testable", word}
        assert numbers[word] == "1" or word == "yes"
    assert not re.search(NEVER, text)


def test_the_terminal_says_it(run, capsys, monkeypatch):
    asked, material = run
    monkeypatch.setenv("COLUMNS", "300")  # a row on one line
    folder = str(material.file("claims").parent)
    assert app.main(["claims", "--results", folder]) == 0
    text = capsys.readouterr().out
    (row,) = [line for line in text.splitlines() if line.startswith(f"{CLAIM} ")]
    assert re.split(r"\s{2,}", row)[2:4] == [TABLE[verdict][1] for verdict in asked.values()]
    assert ("this preset has no dataset" in row) == (MISSING in asked.values())
    assert not re.search(NEVER, text)


def test_a_finding_stands_only_where_its_verdicts_do(run):
    """Sentences that rest on the claim, or on a verdict that is another in this run."""
    _, material = run
    text = publishing.block(material.file("claims").parent.parent)
    page = [finding.topic for finding in findings.findings_of(material.claims) if not finding.unmet]
    for entry in findings.words()["findings"]:
        begin = pages.typeset(entry["text"].partition("{")[0])
        assert (f"- {begin}" in text) == (entry["topic"] in page)
        for claim, wanted in entry["verdicts"].items():
            verdicts = material.claims[claim].verdicts
            if any(verdicts[q] != findings.word_of(word) for q, word in wanted.items()):
                assert entry["topic"] not in page

"""What each verdict must say, and must not, on page, in article, README and terminal.

The table below is written by hand, beside the code, so that words of one verdict under another are
seen. One claim of a made-up run has the verdict, all others hold.
"""

import re

import pytest

import made_up_results
import pages
from beltrepro.cli import app
from beltrepro.replication.report import article, publishing
from beltrepro.replication.report.claim_results import read
from beltrepro.replication.report.findings import findings_of, templates
from beltrepro.replication.verdicts.ledger import load_ledger

CLAIM = "r-jump"  # has a figure, a finding, and several numbers
# A verdict: what must stand in the card of the claim, what begins the sentence below its figure,
# and the lists of the article that have it.
TABLE = {
    "holds": ("✓ holds", "As the paper says", ()),
    "partly": ("◐ partly", "In part as the paper says", ("failing",)),
    "fails": ("✗ fails", "Not as the paper says", ("failing",)),
    "undecided": ("? undecided", "Undecided", ("undecided",)),
    "not measured": ("– not measured", "Not measured in this run", ("undecided",)),
}
WHY = {
    "partly": "Why: It fails in part, by",
    "fails": "Why: It fails by",
    "undecided": "Why: It is undecided by",
    "not measured": "Why: This preset has no dataset",
}
# Words of one outcome that a finding must not have under another, however it is put.
FOREIGN = {
    "holds": r"undecided|\bfails?\b|in part|only a part|does not hold|not measured",
    "partly": r"undecided|not measured",
    "fails": r"undecided|in part|\bholds\b|not measured",
    "undecided": r"\bfails\b|\bholds\b|in part|not measured",
}


@pytest.fixture(scope="module", params=TABLE)
def run(request, tmp_path_factory):
    """(verdict, material) of a run in docs/results/smoke."""
    folder = tmp_path_factory.mktemp("run") / "docs" / "results" / "smoke"
    verdicts = dict.fromkeys(load_ledger(), "holds") | {CLAIM: request.param}
    return request.param, pages.material(folder, verdicts=verdicts)


def test_the_page_says_it(run, tmp_path):
    verdict, material = run
    text = pages.written(tmp_path, material)
    badge, begin, *_ = TABLE[verdict]
    card = re.sub(r"<details>.*</details>", "", pages.cards(text)[CLAIM], flags=re.S)
    said = pages.words(card)
    assert said.startswith(f"{CLAIM} {badge}")
    assert [why for why in WHY.values() if why in said] == (
        [WHY[verdict]] if verdict in WHY else []
    )
    seen = pages.words(re.search(r"What we see.</strong>(.*?)</p>",
                                 pages.picture(text, "fig12"), re.S)[1])  # fmt: skip
    (sentence,) = [one for one in re.split(r"\. (?=[A-Z])", seen) if f"{CLAIM}, with" in one
                   or re.search(rf"{CLAIM}[;.]|{CLAIM}$", one)]  # fmt: skip
    assert sentence.startswith(f"{begin}: ")
    counted = {word: int(number) for word, number in re.findall(
        r'<button type="button" data-show="([a-z ]+)" aria-pressed="false">[a-z ]+ (\d+)<', text
    )}  # fmt: skip
    assert {word for word, number in counted.items() if number} == {
        "holds", "not testable here", verdict
    }  # fmt: skip
    assert counted.get(verdict) == 1 or verdict == "holds"


def test_the_article_says_it(run):
    verdict, material = run
    text = article.content(material, [])
    for name in ("failing", "undecided"):
        listed = {claim["id"]: claim["verdict"] for claim in text[name]}
        assert (CLAIM in listed) == (name in TABLE[verdict][2])
        assert set(listed.values()) <= {verdict}
    (row,) = [row for row in text["claims"] if row["id"] == CLAIM]
    assert row["verdict"] == verdict and bool(row["numbers"]) == (verdict != "not measured")
    told = {finding["topic"]: finding["verdict"] for finding in text["findings"]}
    expected = {"partly": "partly", "fails": "partly", "undecided": "undecided", "holds": "holds"}
    assert told.get("The transition without noise") == expected.get(verdict)


def test_readme_says_it(run):
    verdict, material = run
    text = publishing.block(material.file("claims").parent.parent)
    counts = re.search(r"(\d+) hold, (\d+) hold in part, (\d+) fail, and (\d+) stay open", text)
    others = [int(count) for count in counts.groups()[1:]]
    assert others == [int(verdict == v) for v in ("partly", "fails", "undecided")]
    factor = [entry["text"] for entry in publishing.WORDS["found"] if CLAIM in entry["rests_on"]]
    begin = factor[0].partition("{")[0]
    assert (f"- {begin}" in text) == (verdict == "holds")  # of this run no other sentence is true


def test_the_terminal_says_it(run, capsys, monkeypatch):
    verdict, material = run
    monkeypatch.setenv("COLUMNS", "300")  # a row on one line
    folder = str(material.file("claims").parent)
    assert app.main(["claims", "--results", folder]) == 0
    (row,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith(CLAIM)]
    assert re.split(r"\s{2,}", row)[2] == verdict
    assert (" [" in row) == (verdict != "not measured")


@pytest.mark.parametrize("verdict", FOREIGN)
def test_a_finding_has_no_words_of_another_outcome(verdict):
    for template in templates():
        heading = template["heading"][verdict]
        assert not re.search(FOREIGN[verdict], heading, re.I), heading
        assert list(template["heading"].values()).count(heading) == 1
        conditional = [entry for entry in template["sentences"] if isinstance(entry, dict)]
        for sentence in (entry[verdict] for entry in conditional if verdict in entry):
            assert not re.search(FOREIGN[verdict], sentence, re.I), sentence


@pytest.mark.parametrize("verdict", ["holds", "fails", "undecided"])
def test_a_sentence_on_one_verdict_stands_under_no_other(tmp_path, verdict):
    """Sentences that wait for a verdict of a claim, when all claims have one verdict."""
    verdicts = dict.fromkeys(load_ledger(), verdict)
    results = read(made_up_results.write(tmp_path, verdicts)[0].parent)
    findings = findings_of(results)
    assert [finding.topic for finding in findings] == [one["topic"] for one in templates()]
    for finding, template in zip(findings, templates(), strict=True):
        assert (finding.verdict, finding.heading) == (verdict, template["heading"][verdict])
        text = " ".join(finding.sentences)
        assert len(finding.sentences) >= 2 and not re.search(r"nan|\{|\}", text)
        for entry in (entry for entry in template["sentences"] if isinstance(entry, dict)):
            if results[entry["of"]].claim.testable:
                begins = {key: sentence.partition("{")[0] for key, sentence in entry.items()}
                for other in ("holds", "partly", "fails", "undecided"):
                    begin = begins.get(other)
                    if begin and other != verdict and begin not in entry.get(verdict, ""):
                        assert begin not in text, (template["name"], other)

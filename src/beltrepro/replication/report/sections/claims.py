"""The claims as cards, each with its numbers, its reason and a link to the figure that shows it."""

from beltrepro.replication.report.diagnostics import diagnostic
from beltrepro.replication.report.findings import count
from beltrepro.replication.report.sections.figures import on_page
from beltrepro.replication.verdicts.criteria import VERDICTS
from beltrepro.replication.verdicts.entries import SECTIONS

TITLE = "Claims"
ANCHOR = "claims"
NEEDS = ("claims", "estimates")

GROUPS = {
    "model": "The model",
    "experiment": "The recordings",
    "without_noise": "Motion without noise",
    "transition_without_noise": "The transition without noise",
    "avalanches": "Avalanches",
    "motion": "Chaos and periods",
    "transients": "Transients",
    "transition_with_noise": "The transition with noise",
    "intermittency": "Intermittency",
    "noise_of_experiment": "The noise of the experiment",
    "motion_of_sizes": "Chaos and number of blocks",
    "system_size": "The transition and number of blocks",
    "noise_and_size": "Noise and number of blocks",
    "integrators": "The numerical method",
}
BUILT_SO = "True because the model is built so"


def gather(material) -> dict:
    """Claims by group, verdicts with their counts."""
    results = material.claims.values()
    pictures = on_page(material)
    cards = [_card(result, pictures) for result in results]
    findings = [card for card in cards if card["result"].claim.finding]
    groups = {
        GROUPS.get(section, section): [
            card for card in findings if card["result"].claim.section == section
        ]
        for section in SECTIONS
    }
    groups[BUILT_SO] = [card for card in cards if not card["result"].claim.finding]
    return {
        "groups": {title: own for title, own in groups.items() if own},
        "verdicts": VERDICTS,
        "counts": count(results),
    }


def _card(result, pictures) -> dict:
    """The result, the figure of its number, and another picture that shows it, if there is one."""
    number = "" if result.claim.figure is None else str(result.claim.figure)
    figure = next((each for each in pictures if number and each["number"] == number), None)
    shown = diagnostic(result, pictures)
    return {
        "result": result,
        "number": number,
        "figure": figure,
        "shown": shown if shown is not figure else None,
    }

"""Sections on what was judged: summary, claims, their readings, and other runs."""

from beltrepro.replication.report.claim_results import Result, count
from beltrepro.replication.report.findings import findings_of
from beltrepro.replication.report.material import Material
from beltrepro.replication.report.readings import depends_on_reading, differing, printed, shifts
from beltrepro.replication.report.trust import trust
from beltrepro.replication.verdicts.criteria import VERDICTS
from beltrepro.replication.verdicts.ledger import SECTIONS

TABLES = ("claims", "estimates")  # files that these sections need
MOST, SENTENCES = 5, 4  # findings on the first screen, and sentences of each
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
# Claims that another picture than the figure of their number shows best.
SHOWN_BY = {
    "scheme-order": "agreement_trajectories",
    "u15-aperiodic": "survival",
    "permanent-chaos": "motion_map",
    "no-permanent-chaos": "motion_map",
    "bifurcation-sigma0": "motion_map",
    "transient-lifetime": "survival",
    "u7-transient-chaos": "survival",
    "small-n-regular": "motion_map",
    "chaos-from-n5": "motion_map",
    "complexity-at-n5": "motion_map",
    "experiment-022": "experiment_noise",
    "r-experiment": "experiment_noise",
    "intermittency-experiment": "experiment_noise",
    "sigma-experiment": "experiment_noise",
    "u-critical": "critical_velocity",
    "uc-of-sigma": "critical_velocity",
    "uc-sigma22": "critical_velocity",
    "transition-width": "critical_velocity",
    "sharpest-at-n5": "critical_velocity",
    "soc-cutoff": "avalanches",
    "method-independence": "agreement_disorder",
}
# Points of the model that the text leaves open, and the reading taken.
MODEL = (
    (
        "When a stuck block gets a new threshold of static friction.",
        "It keeps the one drawn where it stuck: its place on the belt does not change. A slipping "
        "block draws anew at every step.",
    ),
    (
        "What happens when the relative velocity changes sign while the external force exceeds "
        "static friction.",
        "The block slips on towards the external force; both events, a stick and a slip, are "
        "recorded at that instant.",
    ),
    (
        "The first step of the position formula, which needs the position one step earlier.",
        "All blocks start stuck, so the step before follows from the velocity of the belt.",
    ),
    (
        "The section for other numbers of blocks than five.",
        "615 for 5 blocks, as in the paper. This is nearly the length at which the springs balance "
        "the kinetic friction of all blocks; for other N the same fraction of that length.",
    ),
    (
        "Which criterion makes a point intermittent, periodic or chaotic.",
        "Shares and numbers of laminar phases, recurrence of section velocities and the 0-1 test "
        "for chaos; the thresholds stand in the documentation of the functions and in the criteria "
        "of the claims.",
    ),
    (
        "How the transition region and its midpoint are read off r(u).",
        "From 90 % to 10 % of the fall between two plateaus, in the median of the runs at each u; "
        "the error of the midpoint comes from resampled runs.",
    ),
)


def summary(material: Material) -> dict:
    """What was run in numbers, findings, number of claims with each verdict, and trust."""
    return {
        "preset": material.preset,
        "datasets": len(material.datasets),
        "pictures": sum(bool(picture["number"]) for picture in material.pictures),
        "findings": findings_of(material.claims)[:MOST],
        "shown": SENTENCES,
        "drawn": set(material.images),
        "verdicts": VERDICTS,
        "counts": count(material.claims),
        "trust": list(trust(material.claims, material.settings, material.others)),
    }


def cards(material: Material) -> dict:
    """Claims by group, with their pictures; verdicts with their counts."""
    groups: dict[str, list[dict]] = {GROUPS[section]: [] for section in SECTIONS}
    groups[BUILT_SO] = []
    for result in material.claims.values():
        group = GROUPS[result.claim.section] if result.claim.finding else BUILT_SO
        groups[group].append(_card(result, material.pictures))
    return {
        "groups": {title: group for title, group in groups.items() if group},
        "verdicts": VERDICTS,
        "counts": count(material.claims),
    }


def sensitivity(material: Material) -> dict:
    """Rows by what is changed, and what no reading of these claims changes."""
    by_change = shifts(material.claims)
    return {
        "groups": {what: rows for what, rows in by_change.items() if rows},
        "untried": [what for what, rows in by_change.items() if not rows],
    }


def open_points(material: Material) -> dict:
    """Printed numbers beside what the readings span; points of the model, and of claims."""
    results = list(material.claims.values())
    return {
        "printed": printed(results),
        "model": [{"open": point, "reading": reading} for point, reading in MODEL],
        "claims": [(result, depends_on_reading(result)) for result in results if result.claim.open],
    }


def presets(material: Material) -> dict:
    """Other runs, and the claims that any two runs judge differently."""
    rows = differing(material.claims, material.others)
    return {"others": material.others, "rows": rows, "preset": material.preset}


def _card(result: Result, pictures: list[dict]) -> dict:
    """The result, the figure of its number, and another picture that shows it, if there is one."""
    number = "" if result.claim.figure is None else str(result.claim.figure)
    figure = next((picture for picture in pictures if number and picture["number"] == number), None)
    shown = shown_by(result, pictures)
    return {
        "result": result,
        "number": number,
        "figure": figure,
        "shown": shown if shown is not figure else None,
    }


def shown_by(result: Result, pictures: list[dict]) -> dict | None:
    """The picture that shows a claim best, or that shares most datasets with it."""
    by_name = {picture["name"]: picture for picture in pictures}
    if SHOWN_BY.get(result.id) in by_name:
        return by_name[SHOWN_BY[result.id]]
    for picture in pictures:
        if picture["number"] and picture["number"] == str(result.claim.figure):
            return picture
    used = set(result.dataset.split(", "))

    def shared(picture: dict) -> tuple[int, int]:
        return len(used & set(picture["uses"])), -len(picture["uses"])

    best = max(pictures, key=shared, default=None)
    return best if best and shared(best)[0] else None

"""The sections of the page, in their order."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from beltrepro.replication.plan import io, registry
from beltrepro.replication.report import conduct, judged, live_chain
from beltrepro.replication.report.material import Material
from beltrepro.replication.studies.chaos import measure as chaos
from beltrepro.replication.studies.experiment import measure as experiment
from beltrepro.replication.studies.integrators import measure as integrators

COMPARED = registry.CATEGORIES[1]


@dataclass(frozen=True)
class PageSection:
    """A section: its template in `templates/`, its anchor too, and what gathers values for it.

    needs : names of the files without which it is left out, as in `Material.files`.
    pictures : names of figures that it shows in place of the section on figures.
    folded : whether the reader has to open it.
    """

    template: str
    title: str
    gather: Callable[[Material], dict[str, Any]]
    needs: tuple[str, ...] = ()
    pictures: tuple[str, ...] = ()
    styles: tuple[str, ...] = ()
    folded: bool = False


def _study(template, title, describe, tables, pictures=()) -> PageSection:
    """A study in its own words, from its tables, with its pictures."""

    def gather(material: Material) -> dict[str, Any]:
        read = {name: io.read_table(material.file(name)) for name in tables}
        shown = [picture for picture in material.pictures if picture["name"] in pictures]
        return describe(read, material.settings) | {"figures": shown}

    return PageSection(template, title, gather, tables, pictures)


def _figures(material: Material) -> dict[str, Any]:
    """The pictures that no section of a study shows."""
    elsewhere = {
        name for section in SECTIONS if material.has(section.needs) for name in section.pictures
    }
    pictures = [picture for picture in material.pictures if picture["name"] not in elsewhere]
    return {
        "figures": [picture for picture in pictures if picture["number"]],
        "studies": [picture for picture in pictures if not picture["number"]],
        "filmed": material.has(RECORDINGS.needs),
    }


def _folded(template, title, gather, needs=()) -> PageSection:
    """A section for those who check."""
    return PageSection(template, title, gather, needs, folded=True)


SUMMARY = PageSection("summary", "", judged.summary)
RECORDINGS = _study(
    "experiment", "The virtual experiment", experiment.of_recordings, ("recordings",)
)
MOTION = PageSection("motion", "The chain, live", live_chain.gather, styles=live_chain.STYLES)
SECTIONS: tuple[PageSection, ...] = (
    MOTION,
    PageSection("figures", "Figures", _figures, ("figures",)),
    PageSection("claims", "Claims", judged.cards, judged.TABLES),
    _study(
        "chaos",
        "Is the motion chaotic?",
        chaos.describe,
        chaos.TOLD_BY,
        ("motion_map", "survival"),
    ),
    _study(
        "trials",
        "What the model says about the experiment",
        experiment.of_trials,
        experiment.TRIALS_TOLD_BY,
        ("experiment_noise",),
    ),
    RECORDINGS,
    _study(
        "integrators",
        "Integrators compared",
        integrators.describe,
        integrators.TOLD_BY,
        tuple(name for name, entry in registry.figures().items() if entry.category == COMPARED),
    ),
    _folded("dates", "When it was judged", judged.dates, judged.TABLES),
    _folded("open_points", "What the paper leaves open", judged.open_points, judged.TABLES),
    _folded("presets", "Other presets", judged.presets, (*judged.TABLES, "compared")),
    _folded("deviations", "Deviations from the paper", conduct.deviations),
    _folded("runs", "What was run", conduct.runs),
    _folded("times", "Time per rule", conduct.times),
    _folded("environment", "Environment", conduct.environment),
)

"""The page: its template, and in it one section after the other."""

import functools
import re
from collections.abc import Callable
from datetime import timedelta
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup

from beltrepro.base import seal
from beltrepro.base.atomic import replacing
from beltrepro.model import ChainParameters
from beltrepro.model.spring import SECTION_POSITION
from beltrepro.model.units import TIME_S
from beltrepro.replication.plan import io
from beltrepro.replication.report import sections
from beltrepro.replication.report.findings import typeset
from beltrepro.replication.report.material import ROOM, WORDS, Material, length
from beltrepro.replication.studies.chaos import measure as chaos
from beltrepro.replication.studies.experiment import measure as experiment
from beltrepro.replication.studies.integrators import measure as integrators
from beltrepro.replication.verdicts.criteria import QUESTIONS, VERDICTS, range_in_words
from beltrepro.replication.verdicts.ledger import read_yaml

SYMBOLS = dict(zip(VERDICTS, "✓◐✗?○", strict=True))
_STYLES = ("report.css", "live/live.css")
_CHAIN = ChainParameters(5, 17.0)  # the paper's; its velocity plays no part
_LAW = ("rest_length", "linear_limit", "compression_rate", "extension_rate", "static_friction")
_BLOCK = 28.6  # length of a block, 4 cm


class PageSection(NamedTuple):
    """A section: its template in `templates/`, its anchor too, and what gathers values for it.

    Each template has the words of the page, and what the run left, besides.
    """

    template: str
    title: str
    gather: Callable[[Material], dict[str, Any]] = lambda _: {}
    needs: tuple[str, ...] = ()  # names of the files without which it is left out
    folded: bool = False  # whether the reader has to open it, as those who check do
    pictures: tuple[str, ...] = ()  # that it shows in place of the section on figures


def render(output: Path, material: Material) -> None:
    """Write the report of one run as one HTML file; a section whose files lack is left out."""
    shown = [section for section in SECTIONS if material.has(section.needs)]
    html = _template("page").render(
        preset=material.preset,
        style="".join(resources.files(ROOM).joinpath(name).read_text("utf-8") for name in _STYLES),
        motion=_body(MOTION, material),
        summary=_body(SUMMARY, material),
        parts=[(section, _body(section, material)) for section in shown],
    )
    with replacing(output) as unfinished:
        unfinished.write_text(html, encoding="utf-8")
        seal.put(unfinished)


def _body(section: PageSection, material: Material) -> Markup:
    values = section.gather(material)
    return Markup(_template(section.template).render(values, run=material, words=WORDS))


def _template(name: str) -> jinja2.Template:
    return _environment().get_template(f"templates/{name}.html.j2")


@functools.cache
def _environment() -> jinja2.Environment:
    """What each template has: filters, the questions and verdicts, and the macros."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(ROOM, "."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "slug": lambda verdict: verdict.replace(" ", "-"),
        "symbol": SYMBOLS.__getitem__,
        "minus": typeset,
        "range": range_in_words,
        "in_short": length,
        "sentence": _sentence,
        "lower_first": lambda text: text[:1].lower() + text[1:],
        "time": lambda seconds: timedelta(seconds=round(seconds)),
        "number": _number,
    }
    environment.globals |= {"questions": QUESTIONS, "verdicts": VERDICTS}
    macros = environment.get_template("templates/macros.html.j2").module
    environment.globals |= {name: made for name, made in vars(macros).items() if callable(made)}
    return environment


def _sentence(text: str) -> str:
    """With a full stop, and a capital for words, not for symbols."""
    begin = text[0].upper() if re.match(r"[a-z]{3}", text) else text[:1]
    return begin + text[1:] + ("" if text.endswith((".", "?", "!", ".”")) or not text else ".")


def _number(value: float, form: str = ".3g") -> str:
    """A number in this form, and nothing for what is not known."""
    return "" if value != value else f"{value:{form}}"


# --- the sections -----------------------------------------------------------------------------


def live_chain(_: Material) -> dict[str, Any]:
    """Controls, constants and beginnings of the chain that moves in the page itself."""
    choices = read_yaml(ROOM, "live/presets.yaml")
    for preset in choices["presets"]:
        preset["settings"]["f"] = _CHAIN.friction_ratio
    law = {name: getattr(_CHAIN, name) for name in _LAW} | {"section": SECTION_POSITION}
    law["section_chain"] = {"blocks": _CHAIN.n_blocks, "ratio": _CHAIN.friction_ratio}
    settings = {"law": law, "second": TIME_S, "block": _BLOCK, "presets": choices["presets"]}
    return choices | {"second": f"{TIME_S:.4f}", "settings": settings}


def _figures(material: Material) -> dict[str, Any]:
    """The pictures that no section of a study shows."""
    shown = [section.pictures for section in SECTIONS if material.has(section.needs)]
    pictures = [one for one in material.pictures if one["name"] not in sum(shown, ())]
    return {
        "figures": [picture for picture in pictures if picture["number"]],
        "studies": [picture for picture in pictures if not picture["number"]],
        "filmed": material.has(RECORDINGS.needs),
    }


def _study(template, title, describe, tables, pictures=()) -> PageSection:
    """A study in its own words, from its tables, with its pictures."""

    def gather(material: Material) -> dict[str, Any]:
        read = {name: io.read_table(material.files[name][0]) for name in tables}
        shown = [picture for picture in material.pictures if picture["name"] in pictures]
        return describe(read, material.settings) | {"figures": shown}

    return PageSection(template, title, gather, tables, pictures=pictures)


MOTION = PageSection("motion", "The chain, live", live_chain)
SUMMARY = PageSection("summary", "What was found", sections.summary)
RECORDINGS = _study(
    "experiment", "The virtual experiment", experiment.of_recordings, ("recordings",)
)
SECTIONS = (
    PageSection("why", "Why r falls", sections.why, ("claims",)),
    PageSection("figures", "Figures", _figures, ("figures",)),
    PageSection("claims", "Claims", sections.cards),
    _study(
        "chaos", "Is the motion chaotic?", chaos.describe, chaos.TOLD_BY, ("motion_map", "survival")
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
        ("agreement",),
        ("agreement_attractors", "agreement_disorder"),
    ),
    PageSection("open_points", "What the paper leaves open", folded=True),
    PageSection("deviations", "Deviations from the paper", folded=True),
    PageSection("runs", "What was run", folded=True),
    PageSection("times", "Time per rule", sections.times, folded=True),
    PageSection("environment", "Environment", sections.environment, folded=True),
)

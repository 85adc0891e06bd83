"""The page: what was found, then question by question words, statements and figures."""

import functools
import re
from datetime import timedelta
from importlib import resources
from pathlib import Path
from typing import Any

import jinja2

from beltrepro.base import seal
from beltrepro.base.atomic import replacing
from beltrepro.model import ChainParameters
from beltrepro.model.spring import SECTION_POSITION
from beltrepro.model.units import TIME_S
from beltrepro.replication.report import sections
from beltrepro.replication.report.findings import typeset
from beltrepro.replication.report.material import ROOM, WORDS, Material
from beltrepro.replication.verdicts.criteria import QUESTIONS, VERDICTS, range_in_words
from beltrepro.replication.verdicts.ledger import read_yaml

SYMBOLS = dict(zip(VERDICTS, "✓◐✗?○", strict=True))
_STYLES = ("report.css", "live/live.css")
_CHAIN = ChainParameters(5, 17.0)  # the paper's; its velocity plays no part
_LAW = ("rest_length", "linear_limit", "compression_rate", "extension_rate", "static_friction")
_BLOCK = 28.6  # length of a block, 4 cm


def render(output: Path, material: Material) -> None:
    """Write the report of one run as one HTML file."""
    html = _page().render(
        run=material,
        words=WORDS,
        style="".join(resources.files(ROOM).joinpath(name).read_text("utf-8") for name in _STYLES),
        live=live_chain(),
        summary=sections.summary(material),
        studies=list(sections.studies(material)),
        made=sections.environment(material) | {"rules": sections.times(material)},
    )
    with replacing(output) as unfinished:
        unfinished.write_text(html, encoding="utf-8")
        seal.put(unfinished)


@functools.cache
def _page() -> jinja2.Template:
    """The page, whose parts have its filters, the questions and verdicts, and the macros."""
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
        "in_short": _length,
        "sentence": _sentence,
        "time": lambda seconds: timedelta(seconds=round(seconds)),
    }
    environment.globals |= {"questions": QUESTIONS, "verdicts": VERDICTS}
    macros = environment.get_template("templates/macros.html.j2").module
    environment.globals |= {name: made for name, made in vars(macros).items() if callable(made)}
    return environment.get_template("templates/page.html.j2")


def _sentence(text: str) -> str:
    """With a full stop, and a capital for words, not for symbols."""
    begin = text[0].upper() if re.match(r"[a-z]{3}", text) else text[:1]
    return begin + text[1:] + ("" if text.endswith((".", "?", "!", ".”")) or not text else ".")


def live_chain() -> dict[str, Any]:
    """Controls, constants and beginnings of the chain that moves in the page itself."""
    choices = read_yaml(ROOM, "live/presets.yaml")
    for preset in choices["presets"]:
        preset["settings"]["f"] = _CHAIN.friction_ratio
    law = {name: getattr(_CHAIN, name) for name in _LAW} | {"section": SECTION_POSITION}
    law["section_chain"] = {"blocks": _CHAIN.n_blocks, "ratio": _CHAIN.friction_ratio}
    settings = {"law": law, "second": TIME_S, "block": _BLOCK, "presets": choices["presets"]}
    return choices | {"second": f"{TIME_S:.4f}", "settings": settings}


def _length(value: float) -> str:
    """A duration as short text: 40000, 2e6."""
    return f"{value:.3g}".replace("e+0", "e").replace("e+", "e") if value >= 1e6 else f"{value:g}"

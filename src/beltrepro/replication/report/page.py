"""The page: its template, and in it one section after the other."""

from importlib import resources
from pathlib import Path

import jinja2
from markupsafe import Markup

from beltrepro.base import seal
from beltrepro.base.atomic import replacing
from beltrepro.replication.report.contents import MOTION, SECTIONS, SUMMARY, PageSection
from beltrepro.replication.report.material import Material
from beltrepro.replication.report.sentences import as_sentence, typeset
from beltrepro.replication.verdicts.criteria import QUESTIONS, VERDICTS, range_in_words

STYLES = ("report.css", *MOTION.styles)
SYMBOLS = dict(zip(VERDICTS, "✓◐✗?○", strict=True))
_ROOM = "beltrepro.replication.report"


def render(output: Path, material: Material) -> None:
    """Write the report of one run as one HTML file; a section whose files lack is left out."""
    shown = [section for section in SECTIONS if material.has(section.needs)]
    parts = [(section, _body(section, material)) for section in shown]
    about = {"preset": material.preset, "summary": _body(SUMMARY, material), "parts": parts}
    template = _environment().get_template("templates/page.html.j2")
    html = template.render(about, style="".join(map(_style, STYLES)))
    with replacing(output) as unfinished:
        unfinished.write_text(html, encoding="utf-8")
        seal.put(unfinished)


def part(section: PageSection, material: Material) -> str:
    """One section of the report as HTML, with its own style but not that of the page."""
    styles = [f"<style>{_style(name)}</style>" for name in section.styles]
    return "".join([*styles, _body(section, material)])


def _body(section: PageSection, material: Material) -> Markup:
    """The section as HTML: its own template with what it gathers."""
    template = _environment().get_template(f"templates/{section.template}.html.j2")
    return Markup(template.render(section.gather(material)))


def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(_ROOM, "."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"questions": QUESTIONS, "verdicts": VERDICTS}
    environment.filters |= {
        "slug": lambda verdict: verdict.replace(" ", "-"),
        "symbol": SYMBOLS.__getitem__,
        "minus": typeset,
        "range": range_in_words,
        "sentence": as_sentence,
        "lower_first": lambda text: text[:1].lower() + text[1:],
        "time": _time,
        "number": _number,
    }
    return environment


def _style(name: str) -> str:
    return resources.files(_ROOM).joinpath(name).read_text(encoding="utf-8")


def _number(value: float, form: str = ".3g") -> str:
    """A number in this form, and nothing for what is not known."""
    return "" if value != value else f"{value:{form}}"


def _time(seconds: float) -> str:
    """Seconds as 12.3 s, 4 min 05 s or 2 h 03 min."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"

"""A report from a made-up run, and its page taken apart."""

import base64
import html
import re

import made_up_results
from beltrepro.replication.plan import registry
from beltrepro.replication.report.findings import typeset
from beltrepro.replication.report.material import Material
from beltrepro.replication.report.page import render
from beltrepro.replication.verdicts.criteria import VERDICTS

# The smallest PNG there is: one pixel.
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)
SETTINGS = {
    "preset": "smoke",
    "seed": 1,
    "model": {"static_friction": 71.4, "friction_ratio": 0.45},
    "defaults": {"laminar_time": 213.0, "time_step": 0.001},
    "datasets": {"n5_replicates": {"duration": 40000.0}},
}
SYMBOLS = dict(zip(VERDICTS, "✓◐✗?○", strict=True))


def material(folder, *, verdicts=None, figures=None, settings=SETTINGS, **files):
    """Claims and figures of a made-up run; each picture has bytes of its own."""
    claims, estimates = made_up_results.write(folder, verdicts)
    images = [folder / f"{name}.png" for name in figures or registry.figures()]
    for path in images:
        path.write_bytes(PIXEL + path.stem.encode())
    usual = {"claims": [claims], "estimates": [estimates], "figures": images}
    return Material("smoke", settings, usual | files, folder / "benchmarks")


def written(folder, run):
    """The text of the page of a run."""
    render(folder / "report.html", run)
    return (folder / "report.html").read_text(encoding="utf-8")


def part(text, anchor):
    """A section of the page."""
    (section,) = re.findall(rf'<section id="{anchor}".*?>(.*?)</section>', text, re.S)
    return section


def cards(text):
    """Markup of each claim by its name."""
    articles = re.findall(r'<article class="claim [a-z-]+" id="(.*?)"(.*?)</article>', text, re.S)
    return {name: f"<article{markup}" for name, markup in articles}


def picture(text, name):
    """Markup of a figure."""
    (figure,) = re.findall(rf'<figure class="figure group" id="{name}">(.*?)</figure>', text, re.S)
    return figure


def cells(text):
    """Rows of tables as the words in their cells."""
    rows = re.findall(r"<tr[^>]*>(.*?)</tr>", text, re.S)
    return [[words(cell) for cell in re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row, re.S)]
            for row in rows]  # fmt: skip


def words(markup):
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", markup)).split())


def plain(text):
    """Words of a text, with minus signs as the page has them."""
    return typeset(" ".join(text.split()))


def badge(verdict, question=""):
    return f"{SYMBOLS[verdict]} {f'{question}: ' if question else ''}{verdict}"


def badges(result):
    """Both verdicts of a claim, as its card has them; one where it is counted apart."""
    if not result.claim.finding:
        return badge(result.verdicts["replicated"], result.claim.kind)
    if not result.claim.testable:
        return badge("not testable")
    return " ".join(badge(verdict, question) for question, verdict in result.verdicts.items())

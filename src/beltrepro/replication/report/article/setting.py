"""Setting of the article: its content in a template, as PDF."""

from __future__ import annotations

import json
import shutil
import tempfile
from importlib import resources
from pathlib import Path

import typst

from beltrepro.base.atomic import replacing
from beltrepro.replication.report.article.contents import Material, content

TEMPLATE = "article.typ"


def write(output: Path, material: Material) -> None:
    """Set the article, as PDF/UA: tagged, so that a screen reader can read it.

    The file has no date, and its fonts come with the typesetter, so the same content gives the same
    bits.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _lay_out(folder, material)
        pdf = typst.compile(
            folder / TEMPLATE, root=folder, ignore_system_fonts=True, pdf_standards=["ua-1"]
        )
    with replacing(output) as unfinished:
        unfinished.write_bytes(pdf)


def _lay_out(folder: Path, material: Material) -> None:
    """Template, content and figures in one folder, which is all that the typesetter sees."""
    text = (
        resources.files("beltrepro.replication.report.article")
        .joinpath(TEMPLATE)
        .read_text(encoding="utf-8")
    )
    (folder / TEMPLATE).write_text(text, encoding="utf-8")
    told = content(material)
    (folder / "content.json").write_text(json.dumps(told), encoding="utf-8")
    for each in told["findings"]:
        if each["figure"]:
            file = Path(each["figure"]["file"])
            shutil.copyfile(material.figures[file.stem], folder / file)

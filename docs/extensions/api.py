"""The reference of the Python functions: a page for each name of the package, from docstrings."""

import inspect
import re
from pathlib import Path

from sphinx.application import Sphinx

import beltrepro
from extensions import markdown

_MARKS = re.compile(r"\|(?=\S)|\*|(?<=\w)_(?=\W|$)")
_ITEM = re.compile(r"\s*- ")


def write_pages(app: Sphinx) -> None:
    """A page of reStructuredText for each public name, in reference/api."""
    folder = Path(app.srcdir) / "reference" / "api"
    folder.mkdir(parents=True, exist_ok=True)
    pages = {f"{name}.rst": _page(name) for name in beltrepro.__all__}
    for path in folder.iterdir():
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:  # else it is made anew
            path.write_text(text, encoding="utf-8")


def _page(name: str) -> str:
    lines = [name, "=" * len(name), "", ".. currentmodule:: beltrepro", ""]
    if inspect.isclass(getattr(beltrepro, name)):
        return "\n".join([*lines, f".. autoclass:: {name}", "   :members:", ""])
    return "\n".join([*lines, f".. autofunction:: {name}", ""])


def public_names() -> str:
    """What `from beltrepro import ...` gives, with the first sentence of each."""
    rows = []
    for name in beltrepro.__all__:
        first = (getattr(beltrepro, name).__doc__ or "").strip().splitlines()[0]
        rows.append([f"{{py:obj}}`{name} <beltrepro.{name}>`", markdown.plain(first)])
    return markdown.table(["name", "what it is or does"], rows)


def as_written(app, what, name, item, options, lines: list[str]) -> None:
    """Stars, bars and final underscores are letters in our docstrings, and marks in
    reStructuredText; and it wants an empty line before a list."""
    written: list[str] = []
    for line in lines:
        outside = line.split("`")
        outside[::2] = [_MARKS.sub(r"\\\g<0>", text) for text in outside[::2]]
        if _ITEM.match(line) and written and written[-1].strip().endswith(":"):
            written.append("")
        written.append("`".join(outside))
    lines[:] = written


def setup(app: Sphinx) -> dict:
    """Called by Sphinx."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", as_written, priority=400)
    app.add_directive("public-names", markdown.directive(public_names, beltrepro))
    return {"parallel_read_safe": True}

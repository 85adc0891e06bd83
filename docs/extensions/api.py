"""The reference of the Python functions: a page for each name of the package, from docstrings."""

import inspect
import re
from pathlib import Path

import beltrepro
from extensions import plain, table, write

_HEAD = """# Python

This is what `import beltrepro` offers. All quantities are in model units: time 0.0765 s, length
1.4 mm, velocity 0.0183 m/s, force 0.0277 N. Arrays of samples are (T, N), with T samples of N
blocks. Most functions take one chain, a sequence of chains that advance together, or a `Grid`.
Whatever is not listed here can change from version to version.
"""
_TOC = "```{toctree}\n:hidden:\n:glob:\n\napi/*\n```\n"
_MARKS = re.compile(r"\|(?=\S)|\*|(?<=\w)_(?=\W|$)")


def write_pages(app) -> None:
    """The list of all public names, and a page of reStructuredText for each."""
    folder = Path(app.srcdir) / "reference"
    write(folder, {"python.md": f"{_HEAD}\n{_names()}\n\n{_TOC}"})
    write(folder / "api", {f"{name}.rst": _page(name) for name in beltrepro.__all__})
    for path in folder.glob("api/*"):
        if path.stem not in beltrepro.__all__:
            path.unlink()


def _names() -> str:
    rows = []
    for name in beltrepro.__all__:
        first = (getattr(beltrepro, name).__doc__ or "").strip().splitlines()[0]
        rows.append([f"{{py:obj}}`{name} <beltrepro.{name}>`", plain(first)])
    return table(["name", "what it is or does"], rows)


def _page(name: str) -> str:
    is_class = inspect.isclass(getattr(beltrepro, name))
    shown = (
        [f".. autoclass:: {name}", "   :members:", "   :inherited-members: dict, ndarray"]
        if is_class
        else [f".. autofunction:: {name}"]
    )
    return "\n".join([name, "=" * len(name), "", ".. currentmodule:: beltrepro", "", *shown, ""])


def as_written(app, what, name, item, options, lines: list[str]) -> None:
    """Stars, bars and final underscores are letters in our docstrings, and marks in
    reStructuredText; and it wants an empty line before a list."""
    written: list[str] = []
    for line in lines:
        outside = line.split("`")
        outside[::2] = [_MARKS.sub(r"\\\g<0>", text) for text in outside[::2]]
        if line.lstrip().startswith("- ") and written and written[-1].rstrip().endswith(":"):
            written.append("")
        written.append("`".join(outside))
    lines[:] = written


def setup(app) -> dict:
    """Called by Sphinx."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", as_written, priority=400)
    return {"parallel_read_safe": True}

"""The reference of the Python functions: a page for each part of the package, from docstrings."""

import ast
import re
import tomllib
from importlib import import_module
from pathlib import Path

from sphinx.application import Sphinx

import beltrepro
from extensions import markdown

ROOT = Path(__file__).parents[2]
PACKAGE = Path(beltrepro.__file__).parent


def modules() -> dict[str, list[str]]:
    """Modules with public docstrings by part: those whose docstrings `make lint` checks."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    excluded = re.compile("|".join(settings["tool"]["numpydoc_validation"]["exclude_files"]))
    found: dict[str, list[str]] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        inside = path.relative_to(PACKAGE)
        if excluded.search(f"src/beltrepro/{inside.as_posix()}") or not _public(path):
            continue
        part = inside.parts[0] if len(inside.parts) > 1 else ""
        name = ".".join(("beltrepro", *inside.with_suffix("").parts))
        found.setdefault(part, []).append(name.removesuffix(".__init__"))
    return found


def _public(path: Path) -> list[str]:
    """Names of the public functions and classes that a module defines."""
    tree = ast.parse(path.read_text(encoding="utf-8"), str(path))
    kinds = (ast.FunctionDef, ast.ClassDef)
    names = [node.name for node in tree.body if isinstance(node, kinds)]
    return [name for name in names if not name.startswith("_")]


def write_pages(app: Sphinx) -> None:
    """A page of reStructuredText for each part, in reference/api; unchanged pages are left."""
    folder = Path(app.srcdir) / "reference" / "api"
    folder.mkdir(parents=True, exist_ok=True)
    pages = {
        f"{part or 'files_and_runs'}.rst": _page(part, names) for part, names in modules().items()
    }
    for path in folder.iterdir():
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def _page(part: str, names: list[str]) -> str:
    title = f"beltrepro.{part}" if part else "Files, runs and small parts"
    lines = [title, "=" * len(title), ""]
    if part:
        lines += [f".. automodule:: beltrepro.{part}", "   :no-index:", ""]
    else:
        lines += [line for name in elsewhere() for line in (*_of_class(name), "")]
    for name in names:
        short = name.removeprefix("beltrepro.").removeprefix(f"{part}.")
        options = ["   :members:", "   :ignore-module-all:", ""]  # each where it is defined
        lines += [short, "-" * len(short), "", f".. automodule:: {name}", *options]
    return "\n".join(lines)


def elsewhere() -> list[str]:
    """Classes that `beltrepro` offers and that no module of the reference defines."""
    known = {name for names in modules().values() for name in names}
    return [name for name in beltrepro.__all__ if getattr(beltrepro, name).__module__ not in known]


def _of_class(name: str) -> list[str]:
    return [f".. autoclass:: beltrepro.{name}", "   :members:"]


def public_names() -> str:
    """What `from beltrepro import ...` gives, with the first sentence of each."""
    rows, strangers = [], elsewhere()
    for name in beltrepro.__all__:
        item = getattr(beltrepro, name)
        first = (item.__doc__ or "").strip().splitlines()[0]
        home = f"beltrepro.{name}" if name in strangers else f"{item.__module__}.{name}"
        rows.append([f"{{py:obj}}`{name} <{home}>`", markdown.plain(first)])
    return markdown.table(["name", "what it is or does"], rows)


def parts() -> str:
    """The parts of the package, with the first sentence of each."""
    rows = []
    for part in modules():
        if part:
            first = (import_module(f"beltrepro.{part}").__doc__ or "").strip().splitlines()[0]
            rows.append([f"[beltrepro.{part}](api/{part}.rst)", markdown.plain(first)])
    return markdown.table(["part", "subject"], rows)


_MARKS = re.compile(r"\|(?=\S)|\*|(?<=\w)_(?=\W|$)")
_ITEM = re.compile(r"\s*- ")


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
    app.add_directive("parts", markdown.directive(parts))
    return {"parallel_read_safe": True}

"""The code behind a job: the modules of its functions and all that these import.

Snakemake sees no imports, and of a script only its time, by which a checkout would make everything
anew. Docstrings and comments do not count, as they change no result.
"""

import ast
import functools
import hashlib
import re
from itertools import product
from pathlib import Path

import grimp

from beltrepro.base.provenance import PACKAGE, ROOT

# Whoever simulates imports all of these, and a batch of points uses those of its methods.
INTEGRATORS = {
    "event": f"{PACKAGE}.engine.event_integrator",
    "verlet": f"{PACKAGE}.engine.verlet_integrator",
}
DRAWING = {f"{PACKAGE}.simulation.{name}" for name in ("artists", "picture", "plots")}
WORDS = "words.yaml"  # captions: only the report prints them, others are told theirs as parameters
_NO_DATA = (".md", ".py", ".pyc", ".nbi", ".nbc")  # pages, sources, caches of Python and Numba


@functools.cache
def code_hash(
    *functions: str, script: Path, methods: tuple[str, ...] = (), words: bool = False
) -> str:
    """Hash of the code behind functions, named as "module:function", and of a script.

    methods : of the points of a batch, whose code is that of these integrators. words : whether the
    captions of figures and tables count.
    """
    graph = _graph(methods)
    named = {function.partition(":")[0] for function in functions}
    modules = named.union(*map(graph.find_upstream_modules, named))
    digest = hashlib.sha256(_content(script))
    for path in sorted({path for module in modules for path in _files(module)}):
        if path.name != WORDS or words:
            digest.update(f"{path.relative_to(ROOT)}\0".encode() + _content(path))
    return digest.hexdigest()[:16]


@functools.cache
def _graph(methods: tuple[str, ...]) -> grimp.ImportGraph:
    """Who imports whom; for methods, as if simulations knew only their integrators.

    What follows tangents (`beltrepro.chaos`) imports the exact dynamics whatever the method is. No
    job draws a result by its methods.
    """
    graph = grimp.build_graph(PACKAGE, cache_dir=None, exclude_type_checking_imports=True)
    simulation = {one for one in graph.modules if one.startswith(f"{PACKAGE}.simulation")}
    others = {module for name, module in INTEGRATORS.items() if name not in methods}
    cut = product(simulation, others) if methods else ()
    library = {one for one in graph.modules if not one.startswith(f"{PACKAGE}.replication")}
    for importer, imported in (*cut, *product(library - DRAWING, DRAWING)):
        if graph.direct_import_exists(importer=importer, imported=imported):
            graph.remove_import(importer=importer, imported=imported)
    return graph


@functools.cache
def _files(module: str) -> list[Path]:
    """A module, and the data of its package and of packages that it names, if it reads files."""
    place = ROOT.parent.joinpath(*module.split("."))
    path = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
    code = _content(path).decode()
    if not re.search(r"\b(__file__|resources)\b", code):
        return [path]
    named = re.findall(rf"'({PACKAGE}[.\w]+)'", code)
    folders = {path.parent, *(ROOT.parent.joinpath(*name.split(".")) for name in named)}
    data = (file for folder in folders for file in folder.rglob("*.*"))
    return [path, *(file for file in data if file.suffix not in _NO_DATA)]


@functools.cache
def _content(path: Path) -> bytes:
    """What a file holds, of Python without what changes no result."""
    if path.suffix != ".py":
        return path.read_bytes()
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        match node:
            case ast.Module() | ast.ClassDef() | ast.FunctionDef() | ast.AsyncFunctionDef():
                if ast.get_docstring(node, clean=False) is not None:
                    node.body = node.body[1:] or [ast.Pass()]
    return ast.unparse(tree).encode()

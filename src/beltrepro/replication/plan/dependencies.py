"""The code behind a job: the modules of its functions and all that these import.

Snakemake sees no imports, and of a script only its time, by which a checkout would make everything
anew. Docstrings and comments do not count, as they change no result.
"""

import ast
import functools
import hashlib
import re
from collections.abc import Iterator
from pathlib import Path

import grimp

from beltrepro.base.provenance import PACKAGE, ROOT

# Whoever simulates imports all of these, and a batch of points uses the one of its method.
INTEGRATORS = {
    "event": f"{PACKAGE}.engine.event_integrator",
    "verlet": f"{PACKAGE}.engine.verlet_integrators",
}
WORDS = "words.yaml"  # captions: only the report prints them, others are told theirs as parameters
_NO_DATA = (".md", ".py", ".pyc", ".nbi", ".nbc")  # pages, sources, caches of Python and Numba


@functools.cache
def code_hash(*functions: str, script: Path, method: str = "", words: bool = False) -> str:
    """Hash of the code behind functions, named as "module:function", and of a script.

    method : of the points of a batch, whose code is that of one integrator. words : whether the
    captions of figures and tables count.
    """
    graph = _graph(method)
    modules = {function.partition(":")[0] for function in functions}
    modules = modules.union(*map(graph.find_upstream_modules, modules))
    digest = hashlib.sha256(_code(script).encode())
    for path in sorted({path for module in modules for path in _files(module)}):
        if path.name != WORDS or words:
            content = _code(path).encode() if path.suffix == ".py" else path.read_bytes()
            digest.update(f"{path.relative_to(ROOT)}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()[:16]


@functools.cache
def _graph(method: str) -> grimp.ImportGraph:
    """Who imports whom; for a method, as if simulations knew only its integrator.

    What follows tangents (`beltrepro.chaos`) imports the exact dynamics whatever the method is.
    """
    graph = grimp.build_graph(PACKAGE, cache_dir=None, exclude_type_checking_imports=True)
    for integrator in [one for name, one in INTEGRATORS.items() if method not in ("", name)]:
        for importer in graph.find_modules_that_directly_import(integrator):
            if importer.startswith(f"{PACKAGE}.simulation."):
                graph.remove_import(importer=importer, imported=integrator)
    return graph


def _files(module: str) -> Iterator[Path]:
    """A module, and the data of its package and of packages that it names, if it reads files."""
    place = ROOT.parent.joinpath(*module.split("."))
    path = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
    yield path
    if re.search(r"\b(__file__|resources)\b", _code(path)):
        named = re.findall(rf"'({PACKAGE}[.\w]+)'", _code(path))
        for folder in (path.parent, *(ROOT.parent.joinpath(*name.split(".")) for name in named)):
            for data in folder.rglob("*"):
                is_hidden = re.search(r"/(\.|__)", f"/{data.relative_to(folder).as_posix()}")
                if data.is_file() and not is_hidden and data.suffix not in _NO_DATA:
                    yield data


@functools.cache
def _code(path: Path) -> str:
    """The text of a file of Python without what changes no result."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            match node.body:
                case [ast.Expr(value=ast.Constant(value=str())), *rest]:
                    node.body = rest or [ast.Pass()]
    return ast.unparse(tree)

"""Where a result comes from: version, commit, libraries, machine; and hashes of code.

Two different things on purpose. `origin` says what made a file and is stored in it. `code_hash`
decides whether a file must be made again; it knows the text of the modules a job depends on and
nothing of commits, so that a commit alone reruns nothing.
"""

import ast
import functools
import hashlib
import json
import os
import platform
import re
import subprocess
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path

PACKAGE = "beltrepro"
ROOT = Path(__file__).parent.parent
LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "h5py")
COMMIT_FILE = ".git_archival.txt"  # says the commit where git does not: `git archive` fills it in
DERIVED = (".pyc", ".nbi", ".nbc")  # caches of Python and Numba


def origin() -> dict[str, str]:
    """Attributes of every result on what made it: code, libraries, machine, and units."""
    return {"code_version": code_version(), **machine(), "units": "model units"}


def machine() -> dict[str, str]:
    """What makes the same code give the same bits: libraries, processor, its instructions."""
    return {
        "library_versions": json.dumps(library_versions()),
        "processor": processor(),
        "instructions": instructions(),
    }


def of_all(parts: Iterable[dict]) -> dict[str, str]:
    """The origin of what was made in parts."""
    parts = list(parts)
    values = {name: dict.fromkeys(part[name] for part in parts) for name in origin()}
    return {name: ", ".join(found) for name, found in values.items()}


@functools.cache
def code_version() -> str:
    """Version of the package, with its commit where that is known, and "dirty" after changes."""
    number = version(PACKAGE)
    found = commit(_tree())
    if not found:
        return number
    changed = _git(_tree(), "status", "--porcelain", "--untracked-files=no")
    return f"{number}+g{found[:12]}{'.dirty' if changed else ''}"


def commit(tree: Path) -> str:
    """The commit of a source tree, from git or from the file of an archive."""
    if found := _git(tree, "rev-parse", "HEAD"):
        return found
    try:
        text = (tree / COMMIT_FILE).read_text(encoding="utf-8")
    except OSError:
        return ""
    node = re.search(r"^node: ([0-9a-f]{40})$", text, re.M)
    return node[1] if node else ""


@functools.cache
def library_versions() -> dict[str, str]:
    """Versions of Python and of the libraries that numbers depend on."""
    return {"python": platform.python_version()} | {name: version(name) for name in LIBRARIES}


@functools.cache
def processor() -> str:
    """Name of the processor, as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


@functools.cache
def instructions() -> str:
    """Instructions for which kernels are compiled: LLVM's name of a processor, hash of features.

    The variables NUMBA_CPU_NAME and NUMBA_CPU_FEATURES stand over what the processor has.
    """
    from llvmlite import binding  # a job without kernels waits for it once, to say so

    name = os.environ.get("NUMBA_CPU_NAME") or binding.get_host_cpu_name()
    features = os.environ.get("NUMBA_CPU_FEATURES")
    if features is None:
        features = "" if name == "generic" else binding.get_host_cpu_features().flatten()
    digest = hashlib.sha256(features.encode()).hexdigest()[:8]
    return f"{name} {digest}, LLVM {'.'.join(map(str, binding.llvm_version_info))}"


def code_hash(
    *modules: str, script: Path | None = None, without: tuple[str, ...] = (), root: Path = ROOT
) -> str:
    """Hash of the modules of this package that the given ones need, found by their imports.

    Imports inside the package are followed, also those within functions; a package counts with its
    data files (templates, styles). A module that is missing counts by its name: the job that needs
    it will say so.
    """
    digest = hashlib.sha256()
    for name in sorted(module_closure(*modules, without=without, root=root)):
        digest.update(f"{name}\0".encode())
        for path in _files(root, name):
            digest.update(f"{path.relative_to(root).as_posix()}\0".encode())
            digest.update(path.read_bytes())
    if script is not None:
        digest.update(f"{script.name}\0".encode())
        digest.update(script.read_bytes())
    return digest.hexdigest()[:16]


def module_closure(
    *modules: str, without: tuple[str, ...] = (), root: Path = ROOT
) -> frozenset[str]:
    """Names of the modules that `code_hash` covers."""
    found: set[str] = set()
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        if name in found or name in without:
            continue
        found.add(name)
        waiting += _parents(name)
        waiting += _imports(root, name)
    return frozenset(found)


def _tree() -> Path:
    """The folder of the project that this package lies in, as `src/beltrepro`."""
    return ROOT.parent.parent


def _git(tree: Path, *arguments: str) -> str:
    """Output of a git command on a source tree; empty if it is not a checkout of its own."""
    if not (tree / ".git").exists():
        return ""
    command = ["git", "--no-optional-locks", "-C", str(tree), *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def _files(root: Path, module: str) -> tuple[Path, ...]:
    """Source file of a module; for a package also its data files. Empty if there is none."""
    source = _source(root, module)
    if source is None:
        return ()
    if source.name != "__init__.py" or source.parent == root:
        return (source,)
    place = source.parent
    return (source, *sorted(path for path in place.rglob("*") if _is_data(path, place)))


def _source(root: Path, module: str) -> Path | None:
    """File with the text of a module, if there is one."""
    place = root.joinpath(*module.split(".")[1:])
    if (place / "__init__.py").is_file():
        return place / "__init__.py"
    source = place.with_suffix(".py")
    return source if place != root and source.is_file() else None


def _is_data(path: Path, package: Path) -> bool:
    """Whether a file is data of this package, and not of one inside it."""
    folders = path.relative_to(package).parents
    if any((package / folder / "__init__.py").is_file() for folder in list(folders)[:-1]):
        return False
    hidden = any(part.startswith((".", "__")) for part in path.relative_to(package).parts)
    return path.is_file() and not hidden and path.suffix not in (".py", *DERIVED)


def _parents(module: str) -> list[str]:
    """Packages around a module, but for the outermost: that only repeats names of others."""
    parts = module.split(".")
    return [".".join(parts[:length]) for length in range(2, len(parts))]


def _imports(root: Path, module: str) -> set[str]:
    """Modules of this package that a module imports anywhere in its text."""
    source = _source(root, module)
    if source is None:
        return set()
    package = module if source.name == "__init__.py" else module.rpartition(".")[0]
    found = _imports_in(source.read_text(encoding="utf-8"), package, str(source))
    return {_imported(root, origin, name) if name else origin for origin, name in found}


@functools.cache  # a workflow asks for the imports of a module again and again
def _imports_in(text: str, package: str, path: str) -> frozenset[tuple[str, str]]:
    """Modules of this package that a text imports, and what it takes from each, or ""."""
    found = set()
    for node in ast.walk(ast.parse(text, path)):
        if isinstance(node, ast.Import):
            found |= {(alias.name, "") for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            origin = node.module or ""
            if node.level:
                base = package.split(".")[: len(package.split(".")) - node.level + 1]
                origin = ".".join([*base, *filter(None, [node.module])])
            found |= {(origin, alias.name) for alias in node.names}
    return frozenset((origin, name) for origin, name in found if _inside(origin))


def _imported(root: Path, origin: str, name: str) -> str:
    """The module meant by `from origin import name`: a submodule, or else the origin itself."""
    submodule = f"{origin}.{name}"
    return submodule if _source(root, submodule) else origin


def _inside(module: str) -> bool:
    return module.partition(".")[0] == PACKAGE

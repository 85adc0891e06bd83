"""Where a result comes from: version, commit, libraries, machine; stored in every file."""

import functools
import hashlib
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

PACKAGE = "beltrepro"
VERSION = "2.0.0"  # of this code, whichever is installed
ROOT = Path(__file__).resolve().parent.parent  # not a link to it, which is of another repository
LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "h5py")
COMMIT_FILE = ".git_archival.txt"  # says the commit where git does not: `git archive` fills it in


def origin() -> dict[str, str]:
    """Attributes of every result on what made it: code, libraries, machine, and units."""
    return {"code_version": code_version(), **machine(), "units": "model units"}


@functools.cache
def machine() -> dict[str, str]:
    """What makes the same code give the same bits: libraries, processor, its instructions."""
    libraries = {"python": platform.python_version()} | {name: version(name) for name in LIBRARIES}
    return {
        "library_versions": json.dumps(libraries),
        "processor": _processor(),
        "instructions": _instructions(),
    }


def of_all(parts: Iterable[dict]) -> dict[str, str]:
    """The origin of what was made in parts."""
    parts = list(parts)
    texts = {name: "; ".join(part[name] for part in parts) for name in origin()}
    return {name: "; ".join(dict.fromkeys(text.split("; "))) for name, text in texts.items()}


def code_version() -> str:
    """Version of the package, with its commit where that is known, and "dirty" after changes.

    As of the first call; and changes of files from which a part of the code was loaded later.
    """
    code = _noted()
    for name in code.waiting.keys() & sys.modules.keys():
        path, time = code.waiting.pop(name)
        if _time_of(path) != time and "+" in code.version:
            code.version = code.version.removesuffix(".dirty") + ".dirty"
    return code.version


@dataclass
class _Code:
    """The code of this process."""

    version: str
    waiting: dict[str, tuple[Path, int]]  # files of modules not loaded yet, and their times then


@functools.cache
def _noted() -> _Code:
    waiting = {}
    for path in ROOT.rglob("*.py"):
        name = ".".join((PACKAGE, *path.relative_to(ROOT).with_suffix("").parts))
        if (name := name.removesuffix(".__init__")) not in sys.modules:
            waiting[name] = path, _time_of(path)
    return _Code(_version_and_commit(), waiting)


def _time_of(path: Path) -> int:
    return path.stat().st_mtime_ns if path.exists() else 0


def _version_and_commit() -> str:
    number, tree = VERSION, ROOT.parents[1]  # this package is src/beltrepro of the tree
    commit = _commit_of_git(tree) if (tree / ".git").exists() else _commit_of_archive(tree)
    return f"{number}+g{commit}" if commit else number


def _commit_of_git(tree: Path) -> str:
    """The commit that is checked out; empty if git is not there, or tracks something else."""
    tracked = ["ls-files", "--error-unmatch", _folders(tree)[0]]
    described = ["describe", "--always", "--exclude=*", "--abbrev=12", "--dirty=.dirty"]
    try:
        _, commit = (_git(tree, *words) for words in (tracked, described))
    except (OSError, subprocess.CalledProcessError):
        return ""
    is_edited = commit.endswith(".dirty") or _differs_from_commit(tree)
    return commit.removesuffix(".dirty") + ".dirty" * is_edited


def _differs_from_commit(tree: Path) -> bool:
    """Whether the files that make results are others than the commit has.

    They are read: git may have been told not to look at some, or to see them changed by a filter.
    """
    listed = ["ls-files", "-z", "--cached", "--others", "--exclude=__pycache__/", "--"]
    names = _git(tree, *listed, *_folders(tree)).rstrip("\0").split("\0")
    committed = _git(tree, "ls-tree", "-r", "-z", "HEAD", *_folders(tree)).rstrip("\0").split("\0")
    try:
        read = _git(tree, "hash-object", "--no-filters", "--stdin-paths", input="\n".join(names))
    except subprocess.CalledProcessError:  # one is gone
        return True
    pairs = (line.split("\t", 1) for line in committed)  # mode, kind and hash, then the name
    of_commit = {name: about.split()[2] for about, name in pairs}
    return dict(zip(names, read.split("\n"), strict=False)) != of_commit


def _folders(tree: Path) -> tuple[str, str]:
    """Of the files that make results."""
    return str(ROOT.relative_to(tree)), "workflow"


def _commit_of_archive(tree: Path) -> str:
    """The commit of `git archive`, and whether the files are still those whose hash it notes."""
    path = tree / COMMIT_FILE
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    if not (noted := re.fullmatch(r"node: ([0-9a-f]{40})\ntree: ([0-9a-f]{40})\n", text)):
        return ""
    try:
        # in the commit the file had places for the two
        template = text.replace(noted[1], "$Format:%H$").replace(noted[2], "$Format:%T$")
        mark = "" if _hash_of_files(tree, template) == noted[2] else ".dirty"
    except (OSError, subprocess.CalledProcessError):
        mark = ".unverified"  # without git
    return noted[1][:12] + mark


def _hash_of_files(tree: Path, template: str) -> str:
    """What git calls the tree of all files that it would not ignore; template : `COMMIT_FILE`."""
    with tempfile.TemporaryDirectory() as folder:
        ask = functools.partial(_git, tree, f"--git-dir={folder}", f"--work-tree={tree}")
        _git(tree, "init", "--quiet", "--bare", folder)
        add = ["update-index", "--add", "--info-only", "-z", "--stdin"]
        ask(*add, input=ask("ls-files", "-z", "--others", "--exclude-standard"))
        blob = ask("hash-object", "-w", "--stdin", input=template)
        ask("update-index", "--cacheinfo", f"100644,{blob},{COMMIT_FILE}")
        return ask("write-tree", "--missing-ok")


def _git(tree: Path, *words: str, input: str | None = None) -> str:
    # git asks whose the tree is before it reads settings in it; code of the tree runs here already
    settings = ["-c", "safe.directory=*", "-c", f"core.excludesFile={os.devnull}"]
    command = ["git", *settings, "--no-optional-locks", "--no-replace-objects"]
    command += ["-C", str(tree), *words]
    # hooks and `git rebase --exec` name their own repository and index in variables
    variables = {name: text for name, text in os.environ.items() if not name.startswith("GIT_")}
    how: dict = {"capture_output": True, "check": True, "errors": "surrogateescape"}
    return subprocess.run(command, input=input, env=variables, **how).stdout.strip()


def _processor() -> str:
    """Name of the processor, as far as the system tells."""
    path = Path("/proc/cpuinfo")
    named = re.search(r"^model name.*?:(.*)$", path.read_text() if path.is_file() else "", re.M)
    return named[1].strip() if named else platform.processor() or platform.machine()


def _instructions() -> str:
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

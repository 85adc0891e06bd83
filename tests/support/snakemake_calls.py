"""Calls of Snakemake that cost what the workflow costs: it is imported once, and forked for each.

A call is `python -m snakemake` in a process of its own, which knows nothing of the package but what
it finds in the tree that it is called on.
"""

import atexit
import functools
import json
import os
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path


def call(tree: Path, *arguments: str) -> subprocess.CompletedProcess:
    """The finished process of Snakemake on a copy of the project, with the package of that copy."""
    with tempfile.TemporaryDirectory() as folder:
        outputs = [f"{folder}/{name}" for name in ("stdout", "stderr")]
        server = _server()
        print(json.dumps([str(tree), outputs, arguments]), file=server.stdin, flush=True)
        code = int(server.stdout.readline())
        return subprocess.CompletedProcess(
            arguments, code, *(Path(path).read_text() for path in outputs)
        )


@functools.cache
def _server() -> subprocess.Popen:
    process = subprocess.Popen(
        [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    atexit.register(process.communicate)  # it ends with its input
    return process


def _serve() -> None:
    """Answer each line of the input with the exit status of that call."""
    for one in ("h5py", "jsonschema", "numpy", "snakemake.cli", "yte"):
        __import__(one)
    assert "beltrepro" not in sys.modules
    for line in iter(sys.stdin.readline, ""):
        child = os.fork()
        if child == 0:
            _become_snakemake(*json.loads(line))
            return
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


def _become_snakemake(tree: str, outputs: list[str], arguments: list[str]) -> None:
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for number, path in enumerate(outputs, start=1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), number)
    os.chdir(tree)
    source = f"{tree}/src"
    os.environ["PYTHONPATH"] = source
    sys.path[:1] = [source]  # in place of the folder of this file
    sys.dont_write_bytecode = False  # the tree is a copy
    sys.argv = ["snakemake", *arguments]
    runpy.run_module("snakemake", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    _serve()

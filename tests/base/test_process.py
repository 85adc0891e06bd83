"""What a process inherits does no harm: streams, variables, folders."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

TOLD = """
import json, os, sys
from beltrepro.base import process
process.set_right()
print("to whoever listens, \\u03c3")
print("to whoever listens, \\u03c3", file=sys.stderr)
with open(sys.argv[1], "w") as file:
    names = "HOME MPLBACKEND NUMBA_DISABLE_JIT NUMBA_NUM_THREADS PYTHONWARNINGS XDG_CACHE_HOME"
    names += " SOURCE_DATE_EPOCH"
    told = {name: os.environ[name] for name in names.split() if name in os.environ}
    if "XDG_CACHE_HOME" in told:
        open(told["XDG_CACHE_HOME"] + "/a", "w").close()
    json.dump(told | {"number": file.fileno()}, file)
"""


def told(tmp_path, redirected="", **variables) -> dict:
    """What is so after the call, of a process that was started with these variables."""
    output = tmp_path / "told.json"
    environment = {name: value for name, value in os.environ.items() if "PYTHON" in name}
    environment |= {"HOME": str(tmp_path)} | variables
    command = ["bash", "-c", f'"$@" {redirected}', "", sys.executable, "-c", TOLD, str(output)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(output.read_text())


@pytest.mark.parametrize("redirected", ["", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_no_file_has_the_number_of_a_stream_that_is_closed(tmp_path, redirected):
    assert told(tmp_path, redirected) == {"HOME": str(tmp_path), "number": 3}


@pytest.mark.parametrize(
    ("variables", "kept"),
    [
        ({"MPLBACKEND": "module://matplotlib_inline.backend_inline"}, False),
        ({"MPLBACKEND": "notebook"}, False),
        ({"MPLBACKEND": "QtAgg"}, True),
        ({"NUMBA_DISABLE_JIT": "1", "NUMBA_NUM_THREADS": "0", "PYTHONWARNINGS": "error"}, False),
        ({"NUMBA_NUM_THREADS": "2", "SOURCE_DATE_EPOCH": "1753430400"}, True),
        ({"SOURCE_DATE_EPOCH": "9" * 17}, False),
    ],
)
def test_variables_that_break_what_is_imported_are_not_passed_on(tmp_path, variables, kept):
    now = told(tmp_path, **variables)
    assert variables.items() <= now.items() if kept else not variables.keys() & now.keys()


@pytest.mark.parametrize(
    "variables", [{"HOME": "/dev/null"}, {"XDG_CACHE_HOME": "/dev/null/a"}, {"TMPDIR": "/none"}]
)
def test_there_is_a_folder_for_caches_and_it_is_gone_at_the_end(tmp_path, variables):
    cache = told(tmp_path, **variables).get("XDG_CACHE_HOME")
    assert ("TMPDIR" in variables) == (cache is None)
    assert cache is None or (cache not in variables.values() and not Path(cache).exists())


def test_a_letter_that_the_terminal_lacks_is_no_error(tmp_path):
    told(tmp_path, LC_ALL="C", PYTHONIOENCODING="ascii")

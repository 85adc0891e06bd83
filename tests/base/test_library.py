"""Who may import whom: the library needs what it installs; what needs more says so."""

import re
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions, requires
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
HIDE = """
import sys

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if any(f"{name}.".startswith(f"{one}.") for one in HIDDEN):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Hidden())
"""
LIBRARY = """
import numpy as np
import beltrepro
beltrepro.to_si
from beltrepro.base import provenance
assert provenance._noted.cache_info().currsize  # as the first of the code is loaded
from beltrepro import ChainParameters, Grid, Run, classify, scan, simulate
from beltrepro.base.errors import InputError

for name in beltrepro.__all__:
    assert getattr(beltrepro, name).__doc__, name
chain = ChainParameters(3, 10.0)
run = simulate(chain, duration=60.0, transient=20.0)
run.save("run.h5")
assert Run.load("run.h5") == run
measured = scan([chain], duration=60.0, transient=20.0)
assert np.isclose(measured["disorder_parameter"][0], run.disorder_parameter)
assert classify(chain, duration=2000.0, transient=500.0).state
table = scan(Grid(3, [5.0, 10.0]), duration=60.0)
table.save("points.h5")
for needy in (run.plot, table.plot, table.table):
    try:
        needy()
    except InputError as error:
        print(error)
"""
COMMAND = """
from beltrepro.cli import app

words = "--n-blocks 3 --belt-velocity 10 --duration 60".split()
assert app.main(["simulate", *words, "--method", "event", "--output", "run.h5"]) == 0
assert app.main(["scan", *words, "--method", "event", "--output", "grid.h5"]) == 0
for needy in (["plot", "run.h5"], ["scan", *words], ["claims"], ["watch", *words[:4]]):
    assert app.main(needy) == 2, needy
"""


# in a process of its own: it configures logging, and silences loggers that are there already
LINT = """
import sys
from importlinter.cli import lint_imports
sys.exit(lint_imports(config_filename="pyproject.toml", no_cache=True, no_logo=True))
"""


def test_type_checkers_are_told_that_there_are_hints():
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"][
        "package-data"
    ]
    assert {"py.typed", "*.pyi"} <= set(data["*"])
    assert (ROOT / "src" / "beltrepro" / "py.typed").exists()


def test_no_import_crosses_a_border():
    words = [sys.executable, "-c", LINT]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def strangers():
    """Modules of all that is installed and that the library does not ask for."""
    library = {name_of(line) for line in PROJECT["dependencies"]}
    assert len(library) <= 5
    library |= {name_of(line) for name in library for line in requires(name) or ()}
    owners = packages_distributions()
    modules = {name for name in owners if not set(map(str.lower, owners[name])) & library}
    modules.remove("beltrepro")
    assert {"pandas", "matplotlib", "snakemake", "yaml"} <= modules
    return modules


def name_of(requirement):
    """The distribution that a requirement names; what an extra asks for is none."""
    return "" if "extra ==" in requirement else re.match(r"[\w-]+", requirement)[0].lower()


def run_without(hidden, text, folder):
    words = [sys.executable, "-c", f"HIDDEN = {hidden!r}\n{HIDE}{text}"]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done


def test_the_library_stands_alone(strangers, tmp_path):
    above = {"beltrepro.replication", "beltrepro.extras"}
    said = run_without(strangers | above, LIBRARY, tmp_path).stdout.splitlines()
    assert said == [
        "a picture of a run needs matplotlib: pip install 'beltrepro[results]'",
        "a picture needs matplotlib: pip install 'beltrepro[results]'",
        "a table needs pandas: pip install 'beltrepro[results]'",
    ]
    in_extra = {name_of(line) for line in PROJECT["optional-dependencies"]["results"]}
    assert {"matplotlib", "pandas"} <= in_extra


def test_the_command_says_what_it_needs(strangers, tmp_path):
    said = run_without(strangers, COMMAND, tmp_path).stderr.splitlines()
    assert [line for line in said if not re.search(r" needs \w+: pip install 'belt", line)] == []
    assert said[-1] == "error: beltrepro watch needs matplotlib: pip install 'beltrepro[watch]'"
    assert len(said) == 4

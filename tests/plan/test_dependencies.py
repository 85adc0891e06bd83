"""The code behind a job: what an edit reruns, and what it does not."""

from pkgutil import resolve_name

import pytest

from beltrepro.replication.plan import dependencies, registry
from beltrepro.replication.plan.dependencies import Sources
from beltrepro.replication.plan.kinds import KINDS

FILES = {
    "__init__.py": "from beltrepro.simulation import simulate",
    "simulation.py": '''
"""Text of a module."""
from __future__ import annotations
from typing import TYPE_CHECKING
import numpy
from beltrepro import words
from beltrepro.engine.driver import INTEGRATORS
from beltrepro.law import LIMIT
if TYPE_CHECKING:
    from beltrepro.figures.style import Style

def simulate(points: Style) -> Style:
    """What it does."""
    # how it does so
    run = Run(points[0].method)
    return run.advance(LIMIT), words.of(run)

def unused():
    from beltrepro.figures import style
    return style

class Run:
    "A run."
    def __init__(self, method):
        self.step = INTEGRATORS[method]
    def advance(self, limit):
        return self.step(limit)
    def save(self, path):
        from beltrepro.files import write
        return write(path)
    @classmethod
    def load(cls, path):
        from beltrepro.files import read
        return read(path)
''',
    "words.py": "def of(run):\n    return 'run'\ndef other():\n    return 'other'\n",
    "files.py": "def write(path):\n    pass\ndef read(path):\n    pass\n",
    "engine/__init__.py": "",
    "engine/driver.py": '''
from . import fast
from .slow import step
from ..special import kick
INTEGRATORS = {"verlet": fast.step, "event": step, "kicked": kick}
''',
    "engine/fast.py": "def step(limit):\n    return builder.load(limit)\ndef other():\n    pass\n",
    "engine/slow.py": "from numba.extending import overload\nfrom beltrepro.law import force\n"
    "def step(limit):\n    return force(limit)\n"
    "@overload(abs)\ndef compiled_force(x):\n    return 7\n",
    "special.py": "def kick(limit):\n    return limit\n",
    "law.py": "LIMIT = 3  # of all\nOTHER = 4\ndef force(x):\n    return -x\n",
    "figures/__init__.py": "",
    "figures/style.py": '''
from pathlib import Path
SHEET = Path(__file__).with_name("paper.mplstyle")
class Style:
    pass
def save(figure):
    return SHEET
''',
    "figures/one.py": '''
import beltrepro.figures.style
from beltrepro.claims import judge
def draw(data):
    return beltrepro.figures.style.save(judge(data))
''',
    "figures/paper.mplstyle": "",
    "figures/templates/page.j2": "",
    "claims/__init__.py": "from beltrepro.claims import fall\n"
    "from beltrepro.claims.registry import KNOWN\n"
    "def judge(data):\n    return [each(data) for each in KNOWN.values()]\n",
    "claims/registry.py": "KNOWN = {}\ndef claim(name):\n    return KNOWN.setdefault(name)\n",
    "claims/fall.py": "from beltrepro.claims.registry import claim\n"
    "@claim('fall')\ndef fall(data):\n    return tell(data)\ndef tell(data):\n    return 1\n"
    "def unused():\n    return 2\n",
    "late.py": "NAME = 'beltrepro.special:kick'\ndef call():\n    return resolve(NAME)\n",
}  # fmt: skip
JOBS = {
    "verlet": ("beltrepro.simulation:simulate", ("verlet",)),
    "event": ("beltrepro.simulation:simulate", ("event",)),
    "kicked": ("beltrepro.simulation:simulate", ("event", "kicked")),
    "figure": ("beltrepro.figures.one:draw", ()),
    "late": ("beltrepro.late:call", ()),
}
SOURCES = Sources()
SIMULATIONS = {"verlet", "event", "kicked"}


@pytest.fixture
def package(tmp_path):
    root = tmp_path / "beltrepro"
    for name, text in FILES.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return root


def hashes(root):
    return {
        name: Sources(root).code_hash(function, choices=choices)
        for name, (function, choices) in JOBS.items()
    }


@pytest.mark.parametrize(
    ("file", "old", "new", "reruns"),
    [
        ("law.py", "LIMIT = 3", "LIMIT = 5", SIMULATIONS),
        ("law.py", "-x", "x", {"event", "kicked"}),
        ("law.py", "OTHER = 4", "OTHER = 5", set()),
        ("law.py", "# of all", "# of some", set()),
        ("engine/fast.py", "limit)\n", "limit + 1)\n", {"verlet"}),
        ("engine/fast.py", "pass", "return 1", set()),
        ("engine/slow.py", "return 7", "return 8", SIMULATIONS),  # done by the import
        ("special.py", "return limit", "return 2 * limit", {"kicked", "late"}),
        ("simulation.py", "points[0]", "points[1]", SIMULATIONS),
        ("simulation.py", '"A run."', '"One run."', set()),
        ("simulation.py", "What it does.", "What it makes.", set()),
        ("simulation.py", "    # how it does so\n", "\n", set()),
        ("simulation.py", "return style", "return None", set()),
        ("simulation.py", "self.step(limit)", "self.step(-limit)", SIMULATIONS),
        ("simulation.py", "return write(path)", "return write(path, 1)", set()),
        ("files.py", "write(path):\n    pass", "write(path):\n    return 1", set()),
        ("words.py", "'run'", "'one run'", SIMULATIONS),
        ("words.py", "'other'", "'another'", set()),
        ("figures/style.py", "return SHEET", "return str(SHEET)", {"figure"}),
        ("figures/paper.mplstyle", "", "font.size: 8", {"figure"}),
        ("figures/templates/page.j2", "", "page", {"figure"}),
        ("claims/fall.py", "return 1", "return 3", {"figure"}),
        ("claims/fall.py", "return 2", "return 3", set()),
        ("__init__.py", "simulate", "unused", set()),
    ],
)
def test_an_edit_reruns_what_depends_on_it_and_nothing_else(package, file, old, new, reruns):
    before = hashes(package)
    assert before == hashes(package)
    text = FILES[file]
    assert not old or text.count(old) == 1
    (package / file).write_text(text.replace(old, new) if old else new)
    after = hashes(package)
    assert {name for name in before if before[name] != after[name]} == reruns


@pytest.mark.parametrize(
    "text",
    [
        "import beltrepro.special\ndef f():\n    return beltrepro.special.kick(1)",
        "import beltrepro.special as s, json\ndef f():\n    return s.kick(1)",
        "from beltrepro import special\ndef f():\n    return special.kick(1)",
        "from beltrepro import special\ndef f():\n    return [special]",
        "from . import special\ndef f():\n    return special.kick(1)",
        "from .special import kick as k\ndef f():\n    return k(1)",
        "def f():\n    from beltrepro.special import kick\n    return kick(1)",
        "try:\n    from beltrepro.special import kick\nexcept ImportError:\n    kick = None\n"
        "def f():\n    return kick(1)",
        "from beltrepro.special import kick\nTABLE = {1: kick}\ndef f():\n    return TABLE[1](1)",
        "from beltrepro.special import kick\nclass A:\n    call = kick\ndef f():\n    return A()",
        "from beltrepro.special import kick\n@kick\ndef f():\n    return 1",
        "def f():\n    return import_module('beltrepro.special')",
    ],
)
def test_imports_of_every_form_are_followed(package, text):
    (package / "new.py").write_text(text)
    assert ("beltrepro.special", "kick") in Sources(package).definitions("beltrepro.new:f")


def test_what_is_missing_caches_and_scripts(package, tmp_path):
    missing = {Sources(package).code_hash(f"beltrepro.{name}") for name in ("a", "b", "c")}
    assert len(missing) == 3 and {len(one) for one in missing} == {16}
    before = hashes(package)
    for name in ("__pycache__/one.pyc", "kernel.nbi", ".hidden", ".cache/page.j2", "more.py"):
        path = package / "figures" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("")
    assert hashes(package) == before
    (package / "figures" / "paper.mplstyle").rename(package / "figures" / "other.mplstyle")
    assert hashes(package)["figure"] != before["figure"]
    script, result = tmp_path / "draw.py", set()
    for text in ("", "1", "1", "2"):
        script.write_text(text)
        result.add(Sources(package).code_hash("beltrepro.figures.one:draw", script=script))
    assert len(result) == 3


# --- of this package ------------------------------------------------------------------------------


def modules(function, *choices):
    texts = SOURCES.definitions(function, choices=choices)
    return {module.removeprefix("beltrepro.") for (module, _), text in texts.items() if text}


HOUSEKEEPING = ("cli", "base.store", "base.atomic", "base.provenance", "simulation.run_file")
HOUSEKEEPING += ("replication.report", "replication.drawing")


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_kind_depends_on_its_integrator_and_not_on_the_words_about_it(kind):
    assert callable(resolve_name(kind.record))
    verlet, event = (modules(kind.record, method) for method in ("verlet", "event"))
    assert "engine.leaps" in verlet - event and "engine.event" in event
    follows_tangents = kind.name in ("motion", "settling", "basins")
    assert ("engine.event" in verlet) == ("engine.tangent" in event) == follows_tangents
    assert not any(module.startswith(HOUSEKEEPING) for module in event | verlet)
    assert ("replication.camera.trials" in event) == (kind.name == "trial")
    # what Numba puts in place of a function is mentioned nowhere
    registered = ("beltrepro.engine.law", "_overload_braking")
    assert registered in SOURCES.definitions(kind.record, choices=["event"])


def test_the_files_behind_claims_and_figures():
    claims = modules("beltrepro.replication.studies.every_claim:measure")
    assert {f"replication.studies.{study}.claims" for study in ("transition", "laws")} <= claims
    assert not any(
        name.startswith(("engine", "simulation", "replication.report")) for name in claims
    )
    joined = modules("beltrepro.replication.plan.files:join")
    assert not any(
        name.startswith(("engine", "simulation", "replication.studies")) for name in joined
    )
    for name, figure in registry.figures().items():
        imported = modules(f"{figure.module}:{name}")
        assert figure.module.removeprefix("beltrepro.") in imported, name
        assert not any(module.startswith(("engine", "replication.report")) for module in imported)


def test_every_function_that_a_rule_names_is_there():
    text = "".join(
        path.read_text() for path in (registry.STUDIES.parents[3] / "workflow").rglob("*.smk")
    )
    named = {match[0] for match in dependencies._MODULE.finditer(text) if ":" in match[0]}
    assert len(named) >= 8
    assert all(callable(resolve_name(name)) for name in named)


def test_hashes_are_kept_until_a_source_changes(tmp_path):
    root, path = tmp_path / "package", tmp_path / "kept" / "hashes.json"
    (root / "inner").mkdir(parents=True)
    (root / "inner" / "a.py").write_text("x = 1")
    made = []

    def hash_of(key):
        hashes = dependencies.KeptHashes(path, root)
        return hashes.get(key, lambda: made.append(key) or f"hash {len(made)}")

    assert hash_of("one") == "hash 1" and not path.exists()  # there is no folder to keep it in
    path.parent.mkdir()
    assert [hash_of(key) for key in ("one", "two", "three", "two")] == [
        "hash 2", "hash 3", "hash 4", "hash 3",
    ]  # fmt: skip
    (root / "inner" / "table.yaml").write_text("data count too")
    assert hash_of("two") == "hash 5" and hash_of("two") == "hash 5"
    path.write_text('{"sources": 3}')
    assert hash_of("two") == "hash 6"

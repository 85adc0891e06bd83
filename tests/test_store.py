"""Files: what is written comes back, the same content gives the same bytes, never half a file."""

import json
import platform
import re
import subprocess

import h5py
import numpy as np
import pytest

from beltrepro import provenance, store
from beltrepro.errors import InputError

EVENT = np.dtype([("time", "f8"), ("block", "i8"), ("kind", "U5"), ("place", "f8", (3,))])
EVENTS = np.array([(0.5, 1, "slip", (1, 2, 3)), (0.7, 5, "stick", (4, 5, 6))], dtype=EVENT)
ARRAYS = {
    "velocity": np.array([[1.5, np.nan], [0.0, -2.0]], dtype="f4"),
    "count": np.arange(3),
    "long": np.linspace(0, 1, 40_000),
    "escaped": np.array([True, False]),
    "events": EVENTS,
    "empty": np.empty((0, 4)),
}
ATTRIBUTES = {"kind": "series", "n_blocks": 5, "noise": 2.2, "units": "model units"}


def test_what_is_written_comes_back(tmp_path):
    path = tmp_path / "deep" / "er" / "data.h5"
    store.write(path, ARRAYS, ATTRIBUTES)
    dataset = store.read(path)
    assert dataset.attributes == ATTRIBUTES
    assert {type(value) for value in dataset.attributes.values()} == {str, int, float}
    assert set(dataset.arrays) == set(ARRAYS)
    for name, array in ARRAYS.items():
        assert dataset.arrays[name].dtype == array.dtype
        np.testing.assert_array_equal(dataset.arrays[name], array)


def test_same_content_gives_same_bytes(tmp_path):
    store.write(tmp_path / "a.h5", ARRAYS, ATTRIBUTES)
    backwards = dict(reversed(ARRAYS.items())), dict(reversed(ATTRIBUTES.items()))
    store.write(tmp_path / "b.h5", *backwards)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_failed_write_leaves_the_old_file_and_no_litter(tmp_path):
    path = tmp_path / "data.h5"
    store.write(path, {"a": np.arange(3)}, {})
    before = path.read_bytes()
    with pytest.raises(TypeError):
        store.write(path, {"a": np.arange(4), "b": np.array([object()])}, {})
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_unreadable_file_is_one_line(tmp_path):
    text = tmp_path / "text.h5"
    text.write_text("no HDF5")
    for path in (text, tmp_path / "missing.h5"):
        with pytest.raises(InputError, match=re.escape(str(path))):
            store.read(path)


def test_join_keeps_order_and_names_every_code_version():
    parts = [
        store.Dataset({"u": np.array([1.0, 2.0])}, {"kind": "scan", "code_version": "1"}),
        store.Dataset({"u": np.array([3.0])}, {"kind": "scan", "code_version": "2"}),
    ]
    whole = store.join(parts)
    np.testing.assert_array_equal(whole.arrays["u"], [1, 2, 3])
    assert whole.attributes == {"kind": "scan", "code_version": "1, 2"}


# --- provenance ---


def test_attributes_say_what_made_the_file(tmp_path):
    settings = {
        "method": "verlet",
        "time_step": 0.001,
        "duration": 2.0,
        "transient": 1.0,
        "seed": 3,
        "points": [[5, 1.0, 0.0]],
    }
    attributes = provenance.attributes("scan", "smoke", settings)
    store.write(tmp_path / "data.h5", {}, attributes)
    assert store.read(tmp_path / "data.h5").attributes == attributes
    assert json.loads(attributes["config"]) == settings
    assert attributes["units"] == "model units"
    assert "numpy" in json.loads(attributes["library_versions"])


def test_attributes_hold_no_path_of_this_machine(tmp_path):
    settings = {"method": "verlet", "time_step": 0.001, "duration": 2.0, "seed": 3}
    attributes = provenance.attributes("ensemble", "smoke", settings)
    store.write(tmp_path / "data.h5", {"a": np.arange(3)}, attributes)
    content = (tmp_path / "data.h5").read_bytes()
    for place in (provenance.ROOT.parents[1], tmp_path):
        assert str(place).encode() not in content


def test_code_version_is_a_version():
    assert re.fullmatch(r"\d+\.\d+\.\d+\S*(\+g[0-9a-f]{12}(\.dirty)?)?", provenance.code_version())


@pytest.fixture
def package(tmp_path):
    """A package of the project's name: simulation -> engine -> two kernels; figures -> style."""
    root = tmp_path / "beltrepro"
    sources = {
        "__init__.py": "from beltrepro.simulation import simulate",
        "simulation.py": "from beltrepro.engine import driver\nimport numpy",
        "engine/__init__.py": "",
        "engine/driver.py": "def go():\n    from . import fast\n    from .slow import step",
        "engine/fast.py": "",
        "engine/slow.py": "from beltrepro.law import force",
        "law.py": "",
        "figures/__init__.py": "",
        "figures/style.py": "import beltrepro.law",
        "figures/one.py": "from beltrepro.figures.style import save",
        "figures/two.py": "from beltrepro.figures import style",
        "figures/paper.mplstyle": "",
    }
    for name, text in sources.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return root


def test_code_hash_follows_imports(package):
    closure = provenance.module_closure("beltrepro.simulation", root=package)
    names = ["engine", "engine.driver", "engine.fast", "engine.slow", "law", "simulation"]
    assert closure == {f"beltrepro.{name}" for name in names}


@pytest.mark.parametrize(
    ("touched", "reruns"),
    [
        ("engine/fast.py", {"simulation"}),
        ("engine/slow.py", {"simulation", "simulation without fast"}),
        ("law.py", {"simulation", "simulation without fast", "one", "two"}),
        ("figures/one.py", {"one"}),
        ("figures/paper.mplstyle", {"one", "two"}),
        ("__init__.py", set()),
    ],
)
def test_code_hash_changes_with_what_it_covers_and_nothing_else(package, touched, reruns):
    def hashes():
        code_hash = provenance.code_hash
        simulation, fast = "beltrepro.simulation", ("beltrepro.engine.fast",)
        return {
            "simulation": code_hash(simulation, root=package),
            "simulation without fast": code_hash(simulation, without=fast, root=package),
            "one": code_hash("beltrepro.figures.one", root=package),
            "two": code_hash("beltrepro.figures.two", root=package),
        }

    before = hashes()
    assert before == hashes()
    with (package / touched).open("a") as file:
        file.write("\n# touched\n")
    after = hashes()
    assert {name for name in before if before[name] != after[name]} == reruns


def test_caches_do_not_count_as_code(package):
    before = provenance.code_hash("beltrepro.figures.one", root=package)
    cache = package / "figures" / "__pycache__" / "one.pyc"
    cache.parent.mkdir()
    cache.write_text("")
    (package / "figures" / "kernel.nbi").write_text("")
    assert provenance.code_hash("beltrepro.figures.one", root=package) == before


def test_every_attribute_says_its_own_thing():
    settings = {
        "method": "event",
        "time_step": 0.002,
        "duration": 20.0,
        "transient": 5.0,
        "seed": 3,
        "b": [1, 2],
        "a": "x",
    }
    found = provenance.attributes("scan", "smoke", settings)
    expected = {"kind": "scan", "preset": "smoke", "method": "event", "time_step": 0.002}
    expected |= {"duration": 20.0, "transient": 5.0, "seed": 3}
    assert {name: found[name] for name in expected} == expected
    assert found["code_version"] == provenance.code_version()
    assert found["processor"] == provenance.processor() != ""
    assert list(json.loads(found["config"])) == sorted(settings)
    libraries = json.loads(found["library_versions"])
    assert libraries["python"] == platform.python_version()
    assert libraries["h5py"] == h5py.__version__ and libraries["numpy"] == np.__version__
    assert set(libraries) == {"python", "numpy", "scipy", "numba", "h5py"}
    del settings["transient"]
    assert provenance.attributes("scan", "smoke", settings)["transient"] == 0


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A git checkout with the package in src/beltrepro; functions that remember forget."""
    root = tmp_path / "src" / "beltrepro"
    root.mkdir(parents=True)
    (root / "a.py").write_text("")
    monkeypatch.setattr(provenance, "ROOT", root)
    monkeypatch.setattr(provenance, "version", lambda package: "1.2")
    provenance.code_version.cache_clear()
    yield root
    provenance.code_version.cache_clear()


def git(tree, *arguments):
    names = ["-c", "user.name=a", "-c", "user.email=a@b"]
    done = subprocess.run(
        ["git", "-C", str(tree), *names, *arguments], capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def test_code_version_names_the_commit_and_changes_to_it(checkout):
    tree = checkout.parents[1]
    assert provenance.code_version() == "1.2"  # no checkout
    git(tree, "init", "-q")
    git(tree, "add", ".")
    git(tree, "commit", "-qm", "first")
    commit = git(tree, "rev-parse", "HEAD")[:12]
    for text, ending in ((None, ""), ("new = 1\n", ".dirty")):
        if text:
            (checkout / "a.py").write_text(text)
        provenance.code_version.cache_clear()
        assert provenance.code_version() == f"1.2+g{commit}{ending}"
    git(tree, "commit", "-qam", "second")
    (tree / "notes.txt").write_text("files that git does not follow change nothing")
    provenance.code_version.cache_clear()
    assert provenance.code_version() == f"1.2+g{git(tree, 'rev-parse', 'HEAD')[:12]}"


def test_a_hash_knows_names_of_modules_and_of_files(package):
    """The same texts elsewhere are other code; a module that is not there counts by its name."""
    hashes = {provenance.code_hash("beltrepro.law", root=package)}
    hashes.add(provenance.code_hash("beltrepro.engine.fast", root=package))
    hashes.add(provenance.code_hash("beltrepro.missing", root=package))
    hashes.add(provenance.code_hash("beltrepro.missing2", root=package))
    assert len(hashes) == 4 and {len(each) for each in hashes} == {16}
    before = provenance.code_hash("beltrepro.figures.one", root=package)
    (package / "figures" / "paper.mplstyle").rename(package / "figures" / "other.mplstyle")
    assert provenance.code_hash("beltrepro.figures.one", root=package) != before


def test_imports_of_every_form_are_followed(package):
    forms = {
        "import beltrepro.law": {"law"},
        "import beltrepro.engine.fast as quick, json": {"engine", "engine.fast"},
        "from beltrepro.engine import fast, driver": {
            "engine", "engine.fast", "engine.driver", "engine.slow", "law"
        },
        "from .engine import slow": {"engine", "engine.slow", "law"},
        "from . import law": {"law"},
        "from .law import force": {"law"},
        "import numpy\nfrom scipy import stats\nfrom beltreprox import a": set(),
        "if True:\n    class A:\n        from beltrepro import law": {"law"},
    }  # fmt: skip
    for text, expected in forms.items():
        (package / "new.py").write_text(text)
        found = provenance.module_closure("beltrepro.new", root=package)
        names = {name.removeprefix("beltrepro.") for name in found} - {"new", "beltrepro"}
        assert names == expected, text
    deep = package / "engine" / "deep.py"
    deep.write_text("from ..law import force\nfrom .fast import step")
    found = provenance.module_closure("beltrepro.engine.deep", root=package)
    assert found == {f"beltrepro.{n}" for n in ("engine", "engine.deep", "engine.fast", "law")}


def test_data_of_a_package_count_wherever_they_lie(package):
    def touched(*parts):
        path = package.joinpath("figures", *parts)
        path.parent.mkdir(parents=True, exist_ok=True)
        before = provenance.code_hash("beltrepro.figures.one", root=package)
        path.write_text("text")
        return provenance.code_hash("beltrepro.figures.one", root=package) != before

    assert touched("templates", "page.j2") and touched("style.css")
    assert not any(touched(name) for name in (".hidden", "x.pyc", "x.nbc", "not_imported.py"))
    assert not touched(".cache", "page.j2") and not touched("__pycache__", "x.txt")

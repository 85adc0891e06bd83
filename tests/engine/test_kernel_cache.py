"""The cache of kernels: what one process saves, others load, whole or not at all."""

import itertools
import os
import subprocess
import sys
from pathlib import Path

import pytest

from beltrepro.engine import kernel_cache
from beltrepro.engine.kernel_cache import KernelCacheFile

KEY = ("float64", "x86_64", "some processor")
OTHER = ("float64", "x86_64", "another processor")


def cache(folder, stamp=("source", 1)):
    return KernelCacheFile(str(folder), "kernel", stamp)


def test_what_was_saved_is_loaded_by_key_and_whole_or_not_at_all(tmp_path):
    folder = tmp_path / "new"
    one = cache(folder)
    assert one.load(KEY) is None and one.load(KEY) is None  # a compilation that failed
    one.save(KEY, {"code": b"abc"})
    one.save(OTHER, {"code": b"xyz"})
    assert cache(folder).load(KEY) == {"code": b"abc"}
    assert cache(folder).load(OTHER) == {"code": b"xyz"}
    assert not list(folder.glob("*.tmp.*"))
    assert cache(folder, ("source", 2)).load(KEY) is None
    for path in folder.glob("*.nbc"):
        whole = path.read_bytes()
        for damaged in (whole[:-1], whole[:10], b"", whole[:-1] + bytes([whole[-1] ^ 1])):
            path.write_bytes(damaged)
            assert None in (cache(folder).load(KEY), cache(folder).load(OTHER))
        path.write_bytes(whole)
    assert cache(folder).load(KEY) == {"code": b"abc"}


def test_what_cannot_be_kept_is_compiled_anew(tmp_path, caplog):
    (tmp_path / "cache").write_text("")  # where the folder should be
    kernel_cache._announce.cache_clear()
    cache(tmp_path / "cache").save(KEY, "code")
    assert cache(tmp_path / "cache").load(KEY) is None
    assert "every process compiles anew" in caplog.text


@pytest.mark.parametrize(
    ("variable", "words"),
    [
        ({"NUMBA_DISABLE_JIT": "1"}, "NUMBA_DISABLE_JIT = 1: integrators run as machine code only"),
        ({"NUMBA_NUM_THREADS": "0"}, "numba: Number of threads specified must be > 0; look at the"),
    ],
)
def test_a_variable_that_numba_cannot_work_with_is_one_line(variable, words):
    # the shell drops such variables; whoever imports the library is told
    command = [sys.executable, "-c", "import beltrepro; beltrepro.simulate"]
    done = subprocess.run(
        command, env=os.environ | variable, capture_output=True, text=True, check=False
    )
    assert words in done.stderr.splitlines()[-1]


@pytest.mark.slow
@pytest.mark.timeout(3600)  # it compiles every kernel, on a machine that may be busy
def test_after_the_command_cache_nothing_is_compiled(tmp_path):
    path = str(Path(kernel_cache.__file__).parents[2])
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": path}

    def run(*words, module="beltrepro"):
        command = [sys.executable, "-m", module, *words]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        assert kernel_cache.COMPILING not in done.stderr, words
        return done

    assert len(run(module="beltrepro.extras.cache").stdout.splitlines()) == 2
    saved = sorted(path.name for path in (tmp_path / "cache").rglob("*.nbc"))
    chain = ["--n-blocks=3", "--duration=50", "--belt-velocity=5"]
    for noise, method in itertools.product(("0", "1"), ("verlet", "event")):
        for command in ("simulate", "scan"):
            run(command, *chain, f"--noise={noise}", f"--method={method}")
        run("classify", *chain, f"--noise={noise}", "--transient=10")
    assert sorted(path.name for path in (tmp_path / "cache").rglob("*.nbc")) == saved

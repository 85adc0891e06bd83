"""The cache of kernels: what one process saves, others load; one compiles while the others wait."""

import errno
import itertools
import os
import subprocess
import sys
import threading
import time
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


def test_the_second_waits_for_the_first(tmp_path):
    first, second = cache(tmp_path), cache(tmp_path)
    assert first.load(KEY) is None
    results = []
    waiting = threading.Thread(target=lambda: results.append(second.load(KEY)))
    waiting.start()
    time.sleep(0.5)
    assert waiting.is_alive()
    first.save(KEY, "code")
    waiting.join(10)
    assert results == ["code"]


def test_a_process_that_died_holds_nobody_up(tmp_path):
    words = (
        "import os, sys\n"
        "from beltrepro.engine.kernel_cache import KernelCacheFile\n"
        "KernelCacheFile(sys.argv[1], 'kernel', ('source', 1)).load(eval(sys.argv[2]))\n"
        "os._exit(9)\n"
    )
    done = subprocess.run([sys.executable, "-c", words, str(tmp_path), repr(KEY)], check=False)
    assert done.returncode == 9
    assert len(list(tmp_path.glob("*.lock"))) == 1
    began = time.monotonic()
    assert cache(tmp_path).load(KEY) is None
    assert time.monotonic() - began < 1


def test_without_a_folder_or_locks_each_compiles_for_itself(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    assert cache(tmp_path / "file" / "folder").load(KEY) is None
    monkeypatch.setattr(kernel_cache, "fcntl", None)
    assert all(cache(tmp_path).load(KEY) is None for _ in range(2))


@pytest.mark.parametrize("kind", ["pipe", "folder", "of somebody else", "on a full disk"])
def test_what_cannot_be_kept_or_trusted_is_compiled_anew(tmp_path, monkeypatch, caplog, kind):
    one = cache(tmp_path)
    assert one.load(KEY) is None
    one.save(KEY, "code")
    (path,) = tmp_path.glob("*.nbc")
    if kind == "of somebody else":
        status = path.stat()
        assert kernel_cache._is_trusted(status)
        of_another = os.stat_result([*status[:4], status.st_uid + 1, *status[5:]])
        assert not kernel_cache._is_trusted(of_another)  # what it holds would run
        monkeypatch.setattr(kernel_cache, "_is_trusted", lambda status: False)
        assert cache(tmp_path).load(KEY) is None
        return
    path.unlink()
    path.with_suffix(".lock").unlink()
    if kind == "pipe":
        os.mkfifo(path)
        os.mkfifo(path.with_suffix(".lock"))
    elif kind == "folder":
        (path / "within").mkdir(parents=True)
    else:
        monkeypatch.setattr(Path, "write_bytes", full_disk)
    again = cache(tmp_path)
    kernel_cache._announce.cache_clear()
    assert again.load(KEY) is None
    again.save(KEY, "code")
    lost = kind != "pipe"  # whose place the file takes
    assert cache(tmp_path).load(KEY) == (None if lost else "code")
    assert ("every process compiles anew" in caplog.text) == lost
    assert not list(tmp_path.glob("*.tmp.*"))


def full_disk(path, content):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_job_says_it_in_its_log(tmp_path):
    words = (
        "import sys, types\n"
        "from beltrepro.replication.plan import scripting\n"
        "from beltrepro.engine.kernel_cache import KernelCacheFile\n"
        "job = types.SimpleNamespace(log=[sys.argv[1] + '/job.log'], output=[], rule='simulate')\n"
        "cache = KernelCacheFile(sys.argv[1], 'kernel', ('source', 1))\n"
        "scripting.run(lambda job: cache.load(eval(sys.argv[2])), job)\n"
    )
    command = [sys.executable, "-c", words, str(tmp_path), repr(KEY)]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=True)
    assert done.stderr == ""
    assert kernel_cache.COMPILING in (tmp_path / "job.log").read_text()


@pytest.mark.slow
@pytest.mark.timeout(3600)  # it compiles every kernel, on a machine that may be busy
def test_after_the_command_cache_nothing_is_compiled(tmp_path):
    path = str(Path(kernel_cache.__file__).parents[2])
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": path}

    def run(*words):
        command = [sys.executable, "-m", "beltrepro", *words]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        assert kernel_cache.COMPILING not in done.stderr, words
        return done

    assert len(run("cache").stdout.splitlines()) == 8
    saved = sorted(path.name for path in (tmp_path / "cache").rglob("*.nbc"))
    chain = ["--n-blocks=3", "--duration=50", "--belt-velocity=5"]
    for noise, method in itertools.product(("0", "1"), ("verlet", "event")):
        for command in ("simulate", "scan"):
            run(command, *chain, f"--noise={noise}", f"--method={method}")
        run("classify", *chain, f"--noise={noise}", "--transient=10")
    assert sorted(path.name for path in (tmp_path / "cache").rglob("*.nbc")) == saved

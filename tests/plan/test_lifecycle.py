"""Runs that begin side by side, are stopped or are killed, and the jobs that they leave."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from beltrepro.base.errors import InputError
from beltrepro.replication.plan import lifecycle

HOLD = """
import sys, time
from pathlib import Path
from beltrepro.replication.plan import lifecycle
lifecycle.begin(Path(sys.argv[1]))
print("begun", flush=True)
time.sleep(60)
"""
# a run with a job, which is a shell with a process of its own
RUN = """
import os, subprocess, sys, time
from pathlib import Path
from beltrepro.replication.plan import lifecycle
results = Path(sys.argv[1])
lifecycle.begin(results)
lifecycle.stop_at_once(results)
os.environ[lifecycle.PARENT] = str(os.getpid())
job = "from beltrepro.replication.plan import lifecycle; import time; lifecycle.end_with_parent(); "
job += "print('job', flush=True); time.sleep(60)"
command = lifecycle.JOB_PREFIX + sys.executable + ' -c "' + job + '"; true'
subprocess.run(["bash", "-c", command])
"""
# Snakemake, which has taken SIGTERM, waits for jobs on a cluster
WAIT = """
import signal, time
from beltrepro.replication.plan import lifecycle
signal.signal(signal.SIGTERM, lambda *_: None)
lifecycle.cancel_at_stop()
try:
    print("begun", flush=True)
    time.sleep(60)
except KeyboardInterrupt:
    raise SystemExit(7)
"""


def as_from_a_terminal():
    """Heed signals that whoever runs the tests may ignore, as nohup and shells in scripts do."""
    for one in lifecycle.STOPPING:
        signal.signal(one, signal.SIG_DFL)


def started(code: str, results: Path) -> subprocess.Popen:
    """A process of its own group that has begun its work on results."""
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(results)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=as_from_a_terminal,
    )
    assert process.stdout.readline()
    return process


def ended(process: subprocess.Popen) -> str:
    """What it said last; waits until all that have its output are gone, its jobs too."""
    return process.communicate(timeout=30)[1]


def test_a_second_run_in_a_folder_is_refused_and_a_kill_frees_it(tmp_path):
    first = started(HOLD, tmp_path / "a")
    assert lifecycle.is_locked(tmp_path / "a")
    with pytest.raises(InputError, match="another run is at work there; wait for its end or give"):
        lifecycle.begin(tmp_path / "a")
    assert not lifecycle.is_locked(tmp_path / "b")
    other = started(HOLD, tmp_path / "b")  # side by side, and looking has locked nothing
    for process in (first, other):
        process.kill()
        ended(process)
    assert not lifecycle.is_locked(tmp_path / "a")
    other = started(HOLD, tmp_path / "a")
    other.kill()
    ended(other)


def test_a_folder_that_was_locked_at_first_or_is_none_is_refused(tmp_path):
    with pytest.raises(InputError, match="another run"):  # since then its files may have changed
        lifecycle.begin(tmp_path / "a", was_locked=True)
    (tmp_path / "b").touch()
    with pytest.raises(InputError, match=r"b: cannot be written \(File exists\)"):
        lifecycle.begin(tmp_path / "b")


@pytest.mark.parametrize("name", lifecycle.FOLDERS)
def test_a_file_in_place_of_a_folder_is_one_line(tmp_path, name, monkeypatch):
    (tmp_path / name).touch()
    with pytest.raises(InputError, match=rf"/{name}: cannot be written \(Not a directory\)"):
        lifecycle.begin(tmp_path)
    (tmp_path / name).unlink()
    (tmp_path / name).mkdir()
    monkeypatch.setattr("os.access", lambda path, mode: False)  # root may write everywhere
    with pytest.raises(InputError, match=rf"/{name}: cannot be written \(Permission denied\)"):
        lifecycle.begin(tmp_path)


def test_what_begins_clears_what_a_kill_has_left_and_no_file_stays_from_the_future(tmp_path):
    """As after a wrong clock: Snakemake would delete what it makes from them."""
    left, now = tmp_path / "datasets" / ".unfinished-1-x.h5", time.time()
    left.parent.mkdir()
    left.touch()
    for name, ahead in (("late", 72.0), ("near", 48.0), ("old", -1e6)):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (now + ahead, now + ahead))
    lifecycle.begin(tmp_path)
    times = {name: (tmp_path / name).stat().st_mtime - now for name in ("late", "near", "old")}
    assert 0 <= times["late"] <= time.time() - now + 1
    assert times["near"] == pytest.approx(48, abs=0.1)
    assert times["old"] == pytest.approx(-1e6, abs=0.1)
    assert not left.exists()


def test_looking_at_a_folder_that_cannot_be_locked_is_no_error(tmp_path):
    """A dry run may look where nothing can be written; `begin` says what is wrong."""
    (tmp_path / "file").touch()
    (tmp_path / "folder" / lifecycle.LOCK).mkdir(parents=True)
    for name in ("file", "folder", "n" * 300):
        assert not lifecycle.is_locked(tmp_path / name)
        with pytest.raises(InputError, match="cannot be written"):
            lifecycle.begin(tmp_path / name)


def test_a_file_system_without_locks_is_one_line(tmp_path, monkeypatch):
    def refuse(descriptor, operation):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    lifecycle.begin(tmp_path / "a")
    monkeypatch.setattr("fcntl.flock", refuse)
    assert not lifecycle.is_locked(tmp_path / "a")
    with pytest.raises(InputError, match=r"b: its file system has no locks \(No locks available\)"):
        lifecycle.begin(tmp_path / "b")


@pytest.mark.thorough
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_stop_ends_jobs_and_says_how_to_go_on(tmp_path, number):
    run = started(RUN, tmp_path / "a")
    (tmp_path / "a" / ".unfinished-1-x.h5").touch()
    if number == signal.SIGINT:
        os.killpg(run.pid, number)  # as a terminal does
    else:
        run.send_signal(number)
    said = ended(run).strip()
    assert run.returncode == 128 + number
    assert said == (
        f"stopped; what is finished is kept in {tmp_path / 'a'}: the same command goes on from here"
    )
    assert [path.name for path in (tmp_path / "a").iterdir()] == [lifecycle.LOCK]


@pytest.mark.parametrize("number", lifecycle.STOPPING)
def test_every_stop_lets_snakemake_cancel_its_jobs_on_a_cluster(tmp_path, number):
    run = started(WAIT, tmp_path)
    run.send_signal(number)
    ended(run)
    assert run.returncode == 7


def test_jobs_do_not_outlive_a_killed_run(tmp_path):
    run = started(RUN, tmp_path / "a")
    run.kill()
    begun = time.monotonic()
    ended(run)  # its output is open as long as the job lives
    assert time.monotonic() - begun < 20

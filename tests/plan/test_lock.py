"""Runs side by side, or killed, and the jobs that they leave."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

from beltrepro.base.errors import InputError
from beltrepro.replication.plan import lock

# a run with a job, which is a shell with a process of its own
RUN = """
import os, subprocess, sys
from pathlib import Path
from beltrepro.replication.plan import lock
lock.take(Path(sys.argv[1]))
os.environ[lock.RUN] = str(os.getpid())
job = "from beltrepro.replication.plan import lock; import time; lock.end_with_run(); "
job += "print('job', flush=True); time.sleep(60)"
subprocess.run(["bash", "-c", sys.executable + ' -c "' + job + '"; true'])
"""


def started(results: Path) -> subprocess.Popen:
    """A run that has begun its work on results."""
    process = subprocess.Popen(
        [sys.executable, "-c", RUN, str(results)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline()
    return process


def test_a_second_run_is_refused_and_a_kill_frees_the_folder_and_ends_the_jobs(tmp_path):
    run = started(tmp_path / "a")
    with pytest.raises(InputError, match="another run is at work there; wait for its end or give"):
        lock.take(tmp_path / "a")
    lock.take(tmp_path / "b")  # side by side
    left = tmp_path / "a" / "datasets" / ".unfinished-1-x.h5"
    left.parent.mkdir()
    left.touch()
    run.kill()
    begun = time.monotonic()
    run.communicate(timeout=60)  # its output is open as long as the job lives
    assert time.monotonic() - begun < 30
    lock.take(tmp_path / "a")
    assert not left.exists()

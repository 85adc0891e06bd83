"""The workflow through a real Slurm of one node gives the bits of a run without it."""

import os
import subprocess
import sys

import pytest
from cluster import Cluster, missing

from beltrepro.base import store
from interruptions import copy_of_project

# One machine has no slow file system, and this Slurm no database of jobs.
QUICK = (
    *("--slurm-init-seconds-before-status-checks", "5", "--slurm-status-command", "squeue"),
    *("--seconds-between-status-checks", "2", "--latency-wait", "15"),
)


def snakemake(place, run, environment, *options):
    """Run the smoke preset on a copy of the project, with the package of the copy."""
    command = [sys.executable, "-m", "snakemake", *options]
    command += ["--config", "preset=smoke", f"run={run}"]
    environment = environment | {"PYTHONPATH": str(place / "src")}
    done = subprocess.run(command, cwd=place, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return {
        path.stem: {name: values.tobytes() for name, values in store.read(path).arrays.items()}
        for path in (place / "results" / run / "datasets").glob("*.h5")
    }


@pytest.mark.slow
@pytest.mark.timeout(5400)
@pytest.mark.skipif(bool(missing()), reason=f"Slurm: {missing()}")
def test_smoke_through_slurm_has_the_bits_of_a_run_without_it(tmp_path):
    pytest.importorskip("snakemake_executor_plugin_slurm", reason="`make slurm` installs it")
    place = copy_of_project(tmp_path / "project")
    alone = snakemake(place, "alone", dict(os.environ), "--cores", "2")
    with Cluster(tmp_path / "cluster") as cluster:
        profile = ("--profile", "profiles/slurm")
        sent = snakemake(place, "sent", cluster.environment, *profile, *QUICK)
    assert alone and sent == alone

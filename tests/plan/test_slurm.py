"""What is refused in one line before jobs are sent to Slurm; its programs are stand-ins."""

from types import SimpleNamespace

import pytest

from beltrepro.base.errors import InputError
from beltrepro.replication.plan import slurm

DISABLED = "echo 'Slurm accounting storage is disabled' >&2; exit 1"


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Puts programs of Slurm on the PATH, and nothing else; by themselves they do nothing."""
    monkeypatch.setenv("PATH", str(tmp_path))

    def _install(**programs):
        for name in slurm.PROGRAMS:
            programs.setdefault(name, "exit 0")
        for name, script in programs.items():
            program = tmp_path / name
            program.write_text(f"#!/bin/sh\n{script}\n")
            program.chmod(0o755)

    return _install


def status_command(**resources) -> str:
    """The program that is asked which jobs have ended, for two jobs."""
    settings = SimpleNamespace(status_command="sacct")
    slurm.prepare(settings, [{}, resources])
    return settings.status_command


def refused(**resources) -> str:
    with pytest.raises(InputError) as caught:
        status_command(**resources)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_programs_that_are_not_there(install, tmp_path):
    assert "sbatch, squeue, scancel, sinfo, sacct not found on the PATH" in refused()
    install()
    assert status_command() == "sacct"
    (tmp_path / "sacct").unlink()
    assert refused().startswith("executor slurm: sacct not found on the PATH")


def test_a_partition_that_there_is_not(install):
    install(sinfo="echo long; echo short; echo long")
    for partition in ("short", "long,short", None, ""):
        assert status_command(slurm_partition=partition) == "sacct"
    assert status_command(slurm_partition="other", slurm_cluster="elsewhere") == "sacct"
    assert refused(slurm_partition="shrt") == (
        "slurm_partition=shrt: allowed are long, short; did you mean 'short'?"
    )
    assert refused(slurm_partition="long,7") == "slurm_partition=long,7: allowed are long, short"
    install(sinfo="echo 'sinfo: error: no controller' >&2; exit 1")
    assert refused(slurm_partition="long") == "executor slurm: sinfo: error: no controller"


def test_without_a_database_squeue_is_asked_if_slurm_remembers_jobs(install):
    install(sacct=DISABLED, scontrol="echo 'MinJobAge               = 216 sec'")
    assert status_command() == "squeue"
    why = "sacct: Slurm accounting storage is disabled"
    assert refused(slurm_account="physics") == f"slurm_account=physics: {why}; allowed is None"
    install(sacct=DISABLED, scontrol="echo 'MinJobAge               = 144 sec'")
    assert f"({why}), and Slurm forgets them after 144 s: MinJobAge above 180 s" in refused()
    install(sacct=DISABLED, scontrol="exit 1")
    assert "(MinJobAge is not known)" in refused()


def test_a_plugin_that_is_not_installed(monkeypatch):
    monkeypatch.setattr(slurm, "PLUGIN", "no_such_plugin")
    with pytest.raises(SystemExit, match="error: executor slurm: its plugin is not installed; typ"):
        slurm.end_if_not_installed()

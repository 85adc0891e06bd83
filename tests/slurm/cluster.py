"""A Slurm cluster of one node on this machine, for as long as a `with` block lasts.

It needs the programs of Slurm and MUNGE (Debian: `apt-get install slurmctld slurmd slurm-client
munge`) and root, because the node runs jobs as the user who sent them. Everything it writes is in
one folder of its own: keys, configuration, sockets, states, logs. It touches no configuration of
the machine and no Slurm that runs there.
"""

import contextlib
import os
import secrets
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

PROGRAMS = ("slurmctld", "slurmd", "slurmstepd", "sbatch", "srun", "squeue", "scontrol", "sacct")
PROGRAMS += ("munged",)
SECONDS_TO_START = 60

# Jobs of Snakemake drop all variables of Slurm before they call srun, also the place of its
# configuration: so srun is this.
SRUN = """\
#!/bin/sh
SLURM_CONF={folder}/slurm.conf exec {srun} "$@"
"""

SLURM_CONF = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control_port}
SlurmdPort={node_port}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
StateSaveLocation={folder}/control
SlurmdSpoolDir={folder}/node
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
MailProg={true}
ReturnToService=2
SlurmdTimeout=15
MinJobAge=86400
SchedulerParameters=sched_interval=2
SlurmdParameters=config_overrides
NodeName={host} NodeAddr=127.0.0.1 CPUs={slots} RealMemory={memory} State=UNKNOWN
PartitionName=test Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def missing():
    """What keeps a cluster from running here, in a line; empty if nothing does."""
    if os.geteuid() != 0:
        return "needs root: the node runs jobs as the user who sent them"
    absent = [name for name in PROGRAMS if shutil.which(name) is None]
    if absent:
        return f"needs {', '.join(absent)} (Debian: slurmctld slurmd slurm-client munge)"
    return ""


class Cluster:
    """Slurm with one node of this many job slots; the memory of a job is not enforced.

    `environment` is what a process needs to send jobs.
    """

    def __init__(self, folder, slots=4):
        self.folder = Path(folder)
        self.slots = slots
        self.environment = os.environ | {
            "SLURM_CONF": str(self.folder / "slurm.conf"),
            "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}",
        }
        self._daemons = []

    def __enter__(self):
        for name in ("munge", "control", "node", "bin"):
            (self.folder / name).mkdir(parents=True)
        self.folder.chmod(0o755)  # munged refuses a socket that others may replace
        key = self.folder / "munge" / "key"
        key.touch(mode=0o600)
        key.write_bytes(secrets.token_bytes(128))
        place = {"folder": self.folder, "host": socket.gethostname().partition(".")[0]}
        place |= {"slots": self.slots, "memory": 16000 * self.slots, "true": shutil.which("true")}
        ports = {"control_port": _free_port(), "node_port": _free_port()}
        (self.folder / "slurm.conf").write_text(SLURM_CONF.format(**place, **ports))
        srun = self.folder / "bin" / "srun"
        srun.write_text(SRUN.format(folder=self.folder, srun=shutil.which("srun")))
        srun.chmod(0o755)
        (self.folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\nCgroupAutomount=no\n")
        try:
            files = {"key-file": "key", "socket": "socket", "pid-file": "pid", "seed-file": "seed"}
            options = [f"--{name}={self.folder / 'munge' / file}" for name, file in files.items()]
            self._start("munged", "--foreground", "--force", *options)
            self._start("slurmctld", "-D")
            self._start("slurmd", "-D")
            self.wait_until_idle()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        with contextlib.suppress(subprocess.SubprocessError, OSError):
            self.ask("scancel", "--user=root", timeout=10)
        for daemon in reversed(self._daemons):
            daemon.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                daemon.wait(timeout=10)
            daemon.kill()
            daemon.wait()

    def ask(self, *command, timeout=60):
        """What a command of Slurm prints."""
        how = {"env": self.environment, "timeout": timeout, "text": True}
        return subprocess.check_output(command, stderr=subprocess.PIPE, **how)

    def wait_until_idle(self):
        end = time.monotonic() + SECONDS_TO_START
        while time.monotonic() < end:
            with contextlib.suppress(subprocess.SubprocessError):
                state = self.ask("sinfo", "--noheader", "--format=%t").strip()
                if state in ("idle", "mix", "alloc"):
                    return
            time.sleep(0.5)
        sys.exit(f"error: no node came up in {SECONDS_TO_START} s; see {self.folder}/*.log")

    def _start(self, name, *options):
        with (self.folder / f"{name}.out").open("ab") as out:
            how = {"env": self.environment, "stdout": out, "stderr": subprocess.STDOUT}
            self._daemons.append(subprocess.Popen([name, *options], **how, start_new_session=True))


def _free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]

"""Prove that the workflow gives the same bits through Slurm as on this machine alone.

    python tests/slurm/prove.py                     the smoke preset
    python tests/slurm/prove.py --targets fig08     less of it

It copies the project, runs it here, and then through a Slurm cluster of one node that it starts
itself (cluster.py says what that needs; it has no database of jobs, so sacct does not answer). What
cannot work must be refused in a line. On the way it cancels jobs, kills their processes, and kills
the daemon of the node with and without its jobs. It ends with status 0 if all arrays, tables and
pictures are the same, and leaves nothing behind.
"""

import argparse
import contextlib
import itertools
import os
import random
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import h5py
from cluster import Cluster, missing
from PIL import Image

ROOT = Path(__file__).parents[2]
# One machine has no slow file system.
QUICK = {
    "--slurm-init-seconds-before-status-checks": "5",
    "--seconds-between-status-checks": "2",
    "--latency-wait": "15",
}


def copy_project(place):
    """The project as it stands, without what git ignores."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.check_output(command, cwd=ROOT, text=True)
    for name in names.split("\0"):
        if (ROOT / name).is_file():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, place / name)


def snakemake(place, run, options, arguments, environment):
    """Status of Snakemake on the copy, with the package of the copy."""
    command = [sys.executable, "-m", "snakemake", *arguments.targets, *options, "--config"]
    command += [f"preset={arguments.preset}", f"run={run}"]
    if arguments.points_per_job:
        defaults = f'{{"points_per_job": {arguments.points_per_job}}}'
        command.append(f'presets={{"{arguments.preset}": {{"defaults": {defaults}}}}}')
    environment = environment | {
        "PYTHONPATH": f"{place / 'src'}:{os.environ.get('PYTHONPATH', '')}"
    }
    with (place / f"{run}.out").open("w") as out:
        command = ["nice", "-n", str(arguments.niceness), *command]
        how = {"cwd": place, "env": environment, "stdout": out, "stderr": subprocess.STDOUT}
        return subprocess.call(command, **how)


def check_refusals(place, options, arguments, environment):
    """End with an error unless a run that cannot work ends at once with a line that says why."""
    programs = place / "programs"  # Python and what Snakemake needs of the system, without Slurm
    programs.mkdir()
    for name in ("bash", "git", "nice", "which"):
        (programs / name).symlink_to(shutil.which(name))
    wrong = ["--default-resources", "slurm_partition=none", "slurm_account=None"]
    cases = {
        "error: slurm_partition=none: allowed are proof": (wrong, {}),
        "error: executor slurm: sbatch, squeue": ([], {"PATH": str(programs)}),
    }
    for line, (more, changed) in cases.items():
        status = snakemake(place, "refused", [*options, *more], arguments, environment | changed)
        said = (place / "refused.out").read_text()
        if not status or line not in said or (place / "results" / "refused" / "batches").exists():
            sys.exit(f"error: not refused with {line!r}: {tail(place / 'refused.out')}")
        print(f"refused: {line}", flush=True)


class Trouble(threading.Thread):
    """Does harm to a cluster, of one kind after the other, while jobs run."""

    def __init__(self, cluster, count, seed, pause):
        super().__init__(daemon=True)
        self.done = []
        self._cluster, self._count, self._pause = cluster, count, pause
        self._random = random.Random(seed)
        self._over = threading.Event()

    def run(self):
        kinds = [self.cancel_a_job, self.kill_a_job, self.lose_the_node, self.restart_the_daemon]
        while len(self.done) < self._count:
            if self._over.wait(self._random.uniform(0.5, 1.5) * self._pause):
                return
            harm = kinds[len(self.done) % len(kinds)]
            with contextlib.suppress(subprocess.SubprocessError):
                if self._cluster.running() and (what := harm()):
                    name = harm.__name__.replace("_", " ")
                    self.done.append((name, what))
                    print(f"  {time.strftime('%H:%M:%S')} {name}: {what}")

    def stop(self):
        self._over.set()
        self.join()

    def cancel_a_job(self):
        job = self._random.choice(self._cluster.running())
        self._cluster.ask("scancel", job)
        return f"job {job}"

    def kill_a_job(self):
        processes = self._cluster.job_processes()
        if not processes:
            return ""
        victim = self._random.choice(processes)
        with contextlib.suppress(ProcessLookupError):
            os.kill(victim, 9)
        return f"process {victim}"

    def lose_the_node(self):
        jobs = self._cluster.running()
        self._cluster.kill_node()
        time.sleep(20)  # longer than SlurmdTimeout: Slurm gives the node up
        self._cluster.start_node()
        return f"with {len(jobs)} jobs on it"

    def restart_the_daemon(self):
        jobs = self._cluster.running()
        self._cluster.restart_daemon()
        return f"{len(jobs)} jobs went on"


def contents(results):
    """Bytes of all arrays, tables and pictures of a run, by name."""
    contents = {}
    for path in sorted(results.glob("datasets/*.h5")):
        with h5py.File(path) as file:

            def keep(name, item, path=path):
                if isinstance(item, h5py.Dataset):
                    value = item[()]
                    contents[f"{path.name}:{name}"] = getattr(value, "tobytes", lambda v=value: v)()

            file.visititems(keep)
    for path in [*results.glob("*.csv"), *results.glob("experiment/*.csv")]:
        contents[str(path.relative_to(results))] = path.read_bytes()
    for path in sorted(results.glob("figures/*.png")):
        # its pixels: the words in a figure name the run, which is another
        with Image.open(path) as image:
            contents[str(path.relative_to(results))] = image.tobytes()
    return contents


def compare(one, other):
    """Names of what differs or is missing in one of both."""
    return sorted(name for name in one.keys() | other.keys() if one.get(name) != other.get(name))


def prove(folder, arguments):
    place = folder / "project"
    copy_project(place)
    shutil.rmtree(place / "results", ignore_errors=True)
    status = snakemake(place, "alone", [f"--cores={arguments.cores}"], arguments, dict(os.environ))
    if status:
        sys.exit(f"error: Snakemake failed without Slurm: {tail(place / 'alone.out')}")
    print("the run without Slurm is done", flush=True)
    began = time.monotonic()
    with Cluster(folder / "cluster", arguments.slots, arguments.niceness) as cluster:
        options = ["--profile", "profiles/slurm", *itertools.chain.from_iterable(QUICK.items())]
        check_refusals(place, options, arguments, cluster.environment)
        trouble = Trouble(cluster, arguments.harms, arguments.seed, arguments.pause)
        trouble.start()
        status = snakemake(place, "slurm", options, arguments, cluster.environment)
        trouble.stop()
        jobs = cluster.jobs_so_far()
    if status:
        sys.exit(f"error: Snakemake failed with Slurm: {tail(place / 'slurm.out')}")
    minutes = (time.monotonic() - began) / 60
    one, other = (contents(place / "results" / run) for run in ("alone", "slurm"))
    different = compare(one, other)
    print(f"{jobs} Slurm jobs in {minutes:.1f} min on {arguments.slots} slots")
    for kind in dict.fromkeys(kind for kind, _ in trouble.done):
        print(f"{sum(kind == each for each, _ in trouble.done)} times: {kind}")
    print(f"{len(one)} arrays, tables and pictures; {len(different)} differ")
    for name in different:
        print(f"  {name}")
    return 1 if different or not one else 0


def tail(path, count=30):
    return "\n".join(["", *path.read_text().splitlines()[-count:]])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--preset", default="smoke")
    parser.add_argument("--targets", nargs="*", default=[], help="of Snakemake; all if none")
    parser.add_argument("--points-per-job", type=int, help="fewer points make more jobs")
    parser.add_argument("--cores", type=int, default=2, help="of the run without Slurm")
    parser.add_argument("--slots", type=int, default=8, help="jobs that the node takes at once")
    parser.add_argument("--niceness", type=int, default=10)
    parser.add_argument("--harms", type=int, default=8, help="how often something is killed")
    parser.add_argument("--pause", type=float, default=20, help="mean seconds between them")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, help="to work in and keep; else nothing is kept")
    arguments = parser.parse_args()
    if reason := missing():
        sys.exit(f"error: {reason}")
    if arguments.folder:
        arguments.folder.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(arguments.folder / "cluster", ignore_errors=True)
        return prove(arguments.folder.resolve(), arguments)
    with tempfile.TemporaryDirectory(prefix="beltrepro-slurm-") as folder:
        return prove(Path(folder).resolve(), arguments)


if __name__ == "__main__":
    sys.exit(main())

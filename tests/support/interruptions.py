"""Kill the workflow again and again, run the same command, and compare the bits at the end.

    python tests/support/interruptions.py --kills 20 --seed 1                all of the preset smoke
    python tests/support/interruptions.py --kills 10 fig16 fig12              some targets

It works on a copy of the project. First the workflow runs undisturbed. Then it runs anew and is
killed at random instants, or as soon after as a file is half written: SIGKILL to a job, to
Snakemake or to all of them, SIGINT (Ctrl-C) to all, SIGTERM to Snakemake. After each the same
command goes on.
"""

import argparse
import contextlib
import os
import random
import re
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import psutil

ROOT = Path(__file__).parents[2]
RESULTS = Path("results/smoke")
PATIENCE = 30.0  # seconds for jobs to see that Snakemake is gone
KINDS = {  # signal, and whether to all processes
    "kill a job": (signal.SIGKILL, False),
    "kill Snakemake": (signal.SIGKILL, False),
    "kill all": (signal.SIGKILL, True),
    "Ctrl-C": (signal.SIGINT, True),
    "SIGTERM": (signal.SIGTERM, False),
}
# what differs between two undisturbed runs too
OWN = ("logs", "benchmarks", ".lock")
# the pages' times, and so their seals
TIMES = re.compile(r'<section id="times".*?</section>|<!-- beltrepro sha256 \w+ -->', re.S)


def copy_of_project(place: Path) -> Path:
    """The project without results."""
    litter = shutil.ignore_patterns("__pycache__", "*.egg-info")
    for name in ("src", "workflow", "profiles"):
        shutil.copytree(ROOT / name, place / name, ignore=litter)
    for name in ("Snakefile", "config.yaml", "CITATION.cff"):
        shutil.copy(ROOT / name, place / name)
    return place


class Workflow:
    """The command, in a group of processes of its own as in a terminal."""

    def __init__(self, tree: Path, targets: list[str], said: Path):
        command = [sys.executable, "-m", "snakemake", "--cores", "2", *targets]
        environment = os.environ | {"PYTHONPATH": str(tree / "src")}
        self.said = said
        with said.open("wb") as output:
            how = {"cwd": tree, "env": environment, "start_new_session": True}
            command += ["--config", "preset=smoke"]
            self.process = psutil.Popen(command, stdout=output, stderr=output, **how)

    def jobs(self) -> list[psutil.Process]:
        """Processes of the group but Snakemake."""
        group = []
        for process in psutil.process_iter():
            with contextlib.suppress(ProcessLookupError, psutil.NoSuchProcess):
                if os.getpgid(process.pid) == self.process.pid != process.pid:
                    group.append(process)
        return group

    def hit(self, kind: str) -> bool:
        """Do what the kind says; False if there is nothing to hit."""
        number, everything = KINDS[kind]
        if kind != "kill a job" and self.process.poll() is not None:
            return False
        try:
            target = self.jobs()[0] if kind == "kill a job" else self.process
            if everything:
                os.killpg(target.pid, number)
            else:
                target.send_signal(number)
        except (IndexError, ProcessLookupError, psutil.NoSuchProcess):
            return False
        return True


def wait(workflow: Workflow, seconds: float, unfinished_in: Path | None) -> None:
    """Wait so long, and then until a file is half written there; or for the end of the workflow."""
    until = time.monotonic() + seconds
    while time.monotonic() < until and workflow.process.poll() is None:
        time.sleep(0.01)
    while unfinished_in and workflow.process.poll() is None:
        if any(unfinished_in.rglob(".unfinished-*")):
            return
        time.sleep(0.001)


def differences(whole: Path, killed: Path) -> list[str]:
    """Files that are not the same, without what says how long something took."""

    def contents(folder):
        paths = {path.relative_to(folder): path for path in folder.rglob("*") if path.is_file()}
        files = {
            name: path.read_bytes() for name, path in paths.items() if name.parts[0] not in OWN
        }
        return {
            name: TIMES.sub("", content.decode()) if name.suffix in (".html", ".txt") else content
            for name, content in files.items()
        }

    one, other = contents(whole), contents(killed)
    return [f"{name} differs" for name in sorted(one | other) if one.get(name) != other.get(name)]


def undisturbed(tree: Path, targets: list[str]) -> tuple[float, float]:
    """Run the workflow; seconds until the first job, and until the end."""
    said = tree / "said.txt"
    begun = time.monotonic()
    workflow = Workflow(tree, targets, said)
    while workflow.process.poll() is None and not workflow.jobs():
        time.sleep(0.1)
    first = time.monotonic() - begun
    assert workflow.process.wait() == 0, said.read_text(errors="replace")
    return first, time.monotonic() - begun


def interrupt(
    tree: Path, targets: list[str], kills: int, seed: int, first: float, seconds: float
) -> tuple[Counter, list[str]]:
    """Kill and go on until that was done so many times; the workflow is finished then.

    first, seconds : until its first job, and its end, if undisturbed. Returns how often what was
    done, and what went wrong.
    """
    wrong = []
    stream = random.Random(seed)
    done: Counter = Counter()
    said = tree / "said.txt"
    kinds = [[*KINDS][number % len(KINDS)] for number in range(kills)]
    stream.shuffle(kinds)
    while kinds:
        kind, at_file = kinds[-1], stream.random() < 0.5
        workflow = Workflow(tree, targets, said)
        wait(workflow, first + stream.uniform(0, 2 * (seconds - first) / kills),
             tree / RESULTS if at_file else None)  # fmt: skip
        if workflow.hit(kind):
            kinds.pop()
            done[kind] += 1
        status = workflow.process.wait()
        _, left = psutil.wait_procs(workflow.jobs(), timeout=PATIENCE)
        words = said.read_text(errors="replace")
        print(f"{kind}{' at a file' if at_file else ''}: status {status}", flush=True)
        if left:
            wrong.append(f"{kind}: {left} left")
        for word in ("LockException", "--unlock", "Traceback", "Error in rule"):
            if word in words:
                wrong.append(f"{kind}: {word} in {words}")
        # one that comes while Python ends, after the last job, is answered by Python
        over = status == 0 or "(100%) done" in words
        if over:  # too early: again from the beginning
            shutil.rmtree(tree / RESULTS)
    assert Workflow(tree, targets, said).process.wait() == 0, said.read_text(errors="replace")
    return done, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("targets", nargs="*", help="all of them if not given")
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    # a shell makes what it starts in the background deaf to Ctrl-C, and that is inherited
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with tempfile.TemporaryDirectory() as folder:
        tree = copy_of_project(Path(folder, "project"))
        first, seconds = undisturbed(tree, options.targets)
        print(f"undisturbed: {seconds:.0f} s", flush=True)
        (tree / RESULTS).rename(tree / "whole")
        begun = time.monotonic()
        done, wrong = interrupt(tree, options.targets, options.kills, options.seed, first, seconds)
        print(f"with {options.kills} kills: {time.monotonic() - begun:.0f} s; {dict(done)}")
        wrong += differences(tree / "whole", tree / RESULTS)
        count = sum(path.is_file() for path in (tree / "whole").rglob("*"))
        print("\n".join(wrong) or f"nothing left, the same bits in all of {count} files")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())

"""A quick subset of the tests with each Python from 3.11 on that this machine has.

    python tests/pythons.py              all that are found: on the PATH and under pyenv
    python tests/pythons.py 3.12 3.13    these

Each gets an environment of its own from requirements.txt, which is removed again.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
OLDEST = (3, 11)
# model, files, plan, what files say of themselves; and a kernel of each integrator
SUBSET = (
    "test_model.py",
    "test_store.py",
    "test_jobs.py",
    "test_deposit.py",
    "test_event.py::test_one_block_follows_the_closed_form",
    "test_engine.py::test_energy_audit_closes_and_improves_with_the_step",
)


def found() -> dict[tuple[int, int], Path]:
    """An interpreter for each version."""
    folders = [Path(each) for each in os.environ["PATH"].split(os.pathsep)]
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    paths = [*pyenv.glob("versions/*/bin/python3.*")]
    paths += [path for folder in folders for path in folder.glob("python3.*")]
    versions: dict[tuple[int, int], Path] = {}
    for path in paths:
        if name := re.fullmatch(r"python3\.(\d+)", path.name):
            number = 3, int(name[1])
            if number >= OLDEST and works(path):
                versions.setdefault(number, path)
    return dict(sorted(versions.items()))


def works(python: Path) -> bool:
    return subprocess.run([python, "--version"], capture_output=True).returncode == 0


def test(python: Path) -> str:
    """The last line of pytest, or of what failed before it."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        own = place / "venv" / "bin" / "python"
        shutil.copy(ROOT / "requirements.txt", place)
        pip = [own, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        pinned = ["--require-hashes", "--only-binary", ":all:", "--no-binary", "connection-pool"]
        commands = [
            [python, "-m", "venv", place / "venv"],
            [*pip, *pinned, "-r", ROOT / "requirements.txt"],
            [*pip, "--no-deps", "--no-build-isolation", "-e", ROOT],
            [own, "-m", "pytest", "-q", *(f"tests/{name}" for name in SUBSET)],
        ]
        environment = os.environ | {"NUMBA_CACHE_DIR": str(place / "kernels")}
        for command in commands:
            done = subprocess.run(
                [str(part) for part in command],
                cwd=ROOT,
                env=environment,
                capture_output=True,
                text=True,
            )
            if done.returncode:
                break
        lines = (done.stdout + done.stderr).strip().splitlines()
        return f"{'failed' if done.returncode else 'passed'}: {lines[-1] if lines else ''}"


def main(asked: list[str]) -> int:
    versions = found()
    wanted = [tuple(map(int, each.split("."))) for each in asked] or list(versions)
    failed = False
    for number in wanted:
        words = test(versions[number]) if number in versions else "failed: not on this machine"
        failed |= words.startswith("failed")
        print(f"Python {number[0]}.{number[1]}: {words}", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""A quick subset of the tests with each Python from 3.11 on that the PATH or pyenv has.

    python tests/support/pythons.py 3.12 3.13    some of them; all if none is named

Each gets an environment of its own from requirements.txt, which is removed again.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
# model, files, plan, what files say of themselves; and a kernel of each integrator
SUBSET = ("test_model.py", "test_store.py", "test_jobs.py", "test_deposit.py", "test_engine.py")
PINNED = ("--require-hashes", "--only-binary", ":all:", "--no-binary", "connection-pool")


def interpreters() -> dict[str, Path]:
    """An interpreter for each version."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    paths = [*pyenv.glob("versions/*/bin/python3.*")]
    for folder in os.environ["PATH"].split(os.pathsep):
        paths += Path(folder).glob("python3.*")
    named = [path for path in paths if re.fullmatch(r"python3\.1[1-9]", path.name)]
    works = [path for path in named if not subprocess.call([path, "-c", ""])]
    return {path.name.removeprefix("python"): path for path in sorted(works)[::-1]}


def test(python: Path) -> bool:
    """Whether the subset passes."""
    with tempfile.TemporaryDirectory() as folder:
        fresh = Path(folder, "bin", "python")
        pip = [fresh, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        files = [path for name in SUBSET for path in ROOT.glob(f"tests/*/{name}")]
        commands = [
            [python, "-m", "venv", folder],
            [*pip, *PINNED, "-r", ROOT / "requirements.txt"],
            [*pip, "--no-deps", "--no-build-isolation", "-e", ROOT],
            [fresh, "-m", "pytest", "-q", *files],
        ]
        environment = os.environ | {"NUMBA_CACHE_DIR": str(Path(folder, "kernels"))}
        return not any(subprocess.call(words, cwd=ROOT, env=environment) for words in commands)


def main(asked: list[str]) -> int:
    versions = interpreters()
    passed = {name: name in versions and test(versions[name]) for name in asked or versions}
    print(", ".join(f"Python {name}: {['failed', 'passed'][passed[name]]}" for name in passed))
    return int(not all(passed.values()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

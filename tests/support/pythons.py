"""A quick subset of the tests with other Pythons: `python tests/support/pythons.py 3.12 3.13`.

Each is looked for on the PATH and gets an environment of its own from requirements.txt, which is
removed again.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
# model, files, plan, what files say of themselves; and a kernel of each integrator
SUBSET = ("test_model.py", "test_store.py", "test_jobs.py", "test_deposit.py", "test_engine.py")
PINNED = ("--require-hashes", "--only-binary", ":all:", "--no-binary", "connection-pool")


def test(version: str) -> bool:
    """Whether the subset passes."""
    with tempfile.TemporaryDirectory() as folder:
        fresh = Path(folder, "bin", "python")
        pip = [fresh, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        commands = [
            [
                shutil.which(f"python{version}") or sys.exit(f"no python{version}"),
                "-m",
                "venv",
                folder,
            ],
            [*pip, *PINNED, "-r", ROOT / "requirements.txt"],
            [*pip, "--no-deps", "--no-build-isolation", "-e", ROOT],
            [fresh, "-m", "pytest", "-q", *(next(ROOT.glob(f"tests/*/{name}")) for name in SUBSET)],
        ]
        environment = os.environ | {"NUMBA_CACHE_DIR": str(Path(folder, "kernels"))}
        return not any(subprocess.call(words, cwd=ROOT, env=environment) for words in commands)


if __name__ == "__main__":
    passed = {version: test(version) for version in sys.argv[1:] or ("3.11", "3.12", "3.13")}
    print(
        ", ".join(f"Python {name}: {['failed', 'passed'][done]}" for name, done in passed.items())
    )
    sys.exit(not all(passed.values()))

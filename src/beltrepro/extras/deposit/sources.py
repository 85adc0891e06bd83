"""The files of the project at its commit: what git tracks, or what an unpacked archive lists."""

import subprocess
from pathlib import Path

from beltrepro.base import seal
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import manifest


def source_files(top: Path) -> list[str]:
    """Files of the project."""
    if (top / ".git").exists():
        return sorted(_git(top, "ls-files", "-z").strip("\0").split("\0"))
    if found := manifest.sources(top):
        return sorted(found)
    raise InputError(
        f"{top.resolve()}: neither a git checkout nor an unpacked archive, so it is unknown which "
        "files belong to the project"
    )


def refuse_changes(top: Path) -> None:
    """Refuse files of the project that differ from its commit."""
    if (top / ".git").exists():
        changed = _git(top, "diff", "--name-only", "-z", "HEAD").strip("\0").split("\0")
    else:
        changed = [
            name
            for name, checksum in manifest.sources(top).items()
            if not (top / name).is_file() or seal.digest_of(top / name) != checksum
        ]
    if changed := [name for name in changed if name]:
        more = f" and {len(changed) - 3} more" if len(changed) > 3 else ""
        raise InputError(
            f"{', '.join(changed[:3])}{more}: not as committed; an archive has the sources of one "
            "commit, so commit or undo the changes first"
        )


def _git(top: Path, *arguments: str) -> str:
    command = ["git", "--no-optional-locks", "-C", str(top), *arguments]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout
    except FileNotFoundError:
        raise InputError("git is not there, and this is a git checkout") from None
    except subprocess.CalledProcessError as error:
        raise InputError(f"git {' '.join(arguments)}: {error.stderr.strip()}") from None

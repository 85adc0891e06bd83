"""One ZIP file for a data repository: sources of a commit, results of a run, crate and checksums.

Unpacked anywhere, it is a folder of the project in which the workflow draws all figures from the
datasets, without git and without a simulation.
"""

import subprocess
import zipfile
from collections.abc import Iterable
from pathlib import Path

from beltrepro.base import provenance, seal
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.extras.deposit.crate import WorkflowRun, describe
from beltrepro.replication.plan import manifest

LEFT_OUT = ("batches/", "logs/", "source/", ".")  # of the results
SOURCES = "source"  # folder of the results for the sources that the crate names


def write_crate(top: Path, run: WorkflowRun) -> None:
    """Make the folder of a run a crate: its metadata, and a copy of the sources."""
    results = top / run.folder
    for name in source_files(top):
        with replacing(results / SOURCES / name) as unfinished:
            unfinished.write_bytes((top / name).read_bytes())
    moved = {f"{run.folder}/": "", "": f"{SOURCES}/"}
    with replacing(results / manifest.CRATE) as unfinished:
        unfinished.write_text(describe(top, run, moved), encoding="utf-8")


def write(path: Path, top: Path, run: WorkflowRun) -> int:
    """Write the archive of a run."""
    refuse_changes(top)
    texts = {
        provenance.COMMIT_FILE: f"node: {provenance.commit(top)}\n",
        manifest.CRATE: describe(top, run, {}),
    }
    names = [*source_files(top), *_results(top, run)]
    lines = []
    with (
        replacing(path) as unfinished,
        zipfile.ZipFile(unfinished, "w", strict_timestamps=False) as file,
    ):
        for name in sorted({*names} - {*texts}):
            lines.append(manifest.line(seal.digest_of(top / name), name))
            file.write(top / name, f"{path.stem}/{name}", zipfile.ZIP_DEFLATED)
        for name, text in texts.items():
            lines.append(manifest.line(seal.digest(text.encode()), name))
            file.writestr(f"{path.stem}/{name}", text, zipfile.ZIP_DEFLATED)
        listed = "".join(sorted(lines, key=lambda line: line.split("  ", 1)[1]))
        file.writestr(f"{path.stem}/{manifest.NAME}", listed, zipfile.ZIP_DEFLATED)
    return len(lines) + 1


def _results(top: Path, run: WorkflowRun) -> Iterable[str]:
    folder = top / run.folder
    for path in sorted(folder.rglob("*")):
        below = path.relative_to(folder).as_posix()
        made_here = below == manifest.CRATE or path.suffix == ".zip"
        if path.is_file() and not below.startswith(LEFT_OUT) and not made_here:
            yield f"{run.folder}/{below}"


def source_files(top: Path) -> list[str]:
    """Files of the project."""
    if (top / ".git").exists():
        return sorted(_git(top, "ls-files", "-z").strip("\0").split("\0"))
    if listed := manifest.sources(top):
        return sorted(listed)
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

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

LEFT_OUT = ("batches/", "logs/", "source/", manifest.NAME, manifest.CRATE)  # of the results
MEASURED = "benchmarks/"  # Snakemake writes these times after the job: they have no checksum
SOURCES = "source"  # folder of the results for the sources that the crate names


def write_crate(top: Path, run: WorkflowRun) -> None:
    """Make the folder of a run a crate: its metadata, and a copy of the sources."""
    results = top / run.folder
    _check(top, run)
    for name in source_files(top):
        with replacing(results / SOURCES / name) as unfinished:
            unfinished.write_bytes((top / name).read_bytes())
    moved = {f"{run.folder}/": "", "": f"{SOURCES}/"}
    with replacing(results / manifest.CRATE) as unfinished:
        unfinished.write_text(describe(top, run, moved), encoding="utf-8")


def write(path: Path, top: Path, run: WorkflowRun) -> int:
    """Write the archive of a run."""
    refuse_changes(top)
    results = _check(top, run)
    texts = {
        provenance.COMMIT_FILE: f"node: {provenance.commit(top)}\n",
        manifest.CRATE: describe(top, run, {}),
        f"{run.folder}/{manifest.NAME}": manifest.text(results),
    }
    names = {*source_files(top), *(f"{run.folder}/{name}" for name in results)}
    listed = {name: seal.digest(text.encode()) for name, text in texts.items()}
    with (
        replacing(path) as unfinished,
        zipfile.ZipFile(unfinished, "w", strict_timestamps=False) as file,
    ):
        for name in sorted(names - {*texts}):
            listed[name] = seal.digest_of(top / name)
            file.write(top / name, f"{path.stem}/{name}", zipfile.ZIP_DEFLATED)
        texts[manifest.NAME] = manifest.text(listed)
        for name, text in texts.items():
            file.writestr(f"{path.stem}/{name}", text, zipfile.ZIP_DEFLATED)
    return len(listed) + 1


def _check(top: Path, run: WorkflowRun) -> dict[str, str]:
    """Checksums of the results by name, which must be what the run wrote."""
    folder = top / run.folder
    names = [*_results(folder)]
    made = [name for name in names if not name.startswith(MEASURED)]
    manifest.check(folder, made, {"preset": run.preset, "run": run.name})
    return {name: seal.digest_of(folder / name) for name in names}


def _results(folder: Path) -> Iterable[str]:
    for path in sorted(folder.rglob("*")):
        below = path.relative_to(folder)
        hidden = any(part.startswith(".") for part in below.parts)
        left_out = below.as_posix().startswith(LEFT_OUT) or path.suffix == ".zip"
        if path.is_file() and not hidden and not left_out:
            yield below.as_posix()


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

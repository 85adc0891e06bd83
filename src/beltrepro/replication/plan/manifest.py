"""The list of all files of an archive with their checksums, as `sha256sum --check` reads it.

It lies at the top of an unpacked archive. Datasets that it lists came with the archive, and as long
as they are there the workflow takes them as they are.
"""

from pathlib import Path, PurePosixPath

from beltrepro.base.errors import InputError

NAME = "manifest-sha256.txt"
CRATE = "ro-crate-metadata.json"  # a name that the format settles
_RESULTS = "results"


def line(checksum: str, name: str) -> str:
    """One line of the list."""
    return f"{checksum}  {name}\n"


def read(top: Path) -> dict[str, str]:
    """The list at the top of an unpacked archive."""
    path = top / NAME
    if not path.is_file():
        return {}
    try:
        pairs = [line.split("  ", 1) for line in path.read_text(encoding="utf-8").splitlines()]
        return {name: checksum for checksum, name in pairs}
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: not a readable list of checksums ({error})") from None


def sources(top: Path) -> dict[str, str]:
    """What the list says of the files of the project itself."""
    return {name: checksum for name, checksum in read(top).items() if not _is_made(name)}


def datasets(top: Path, run: str) -> set[str]:
    """Datasets of a run that came with an archive and are still there."""
    folder = PurePosixPath(_RESULTS, run, "datasets")
    listed = [PurePosixPath(name) for name in read(top)]
    return {path.stem for path in listed if path.parent == folder and (top / path).is_file()}


def _is_made(name: str) -> bool:
    """Whether a file is the crate or in the folder of a run; results/README.md is not."""
    parts = PurePosixPath(name).parts
    return name == CRATE or (parts[0] == _RESULTS and len(parts) > 2)

"""Lists of files with their checksums, as `sha256sum --check` reads them.

The list of a run lies in its folder: each job adds what it has written. By it `check` tells whether
a file still is what the run wrote. A published run has such a list too.
"""

import fcntl
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from beltrepro.base import seal
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError

NAME = "manifest-sha256.txt"
_LOCK = ".manifest.lock"
_LINE = re.compile(r"^([0-9a-f]{64})  (.+)$", re.M)


def text(listed: Mapping[str, str]) -> str:
    """The list of checksums by name."""
    return "".join(f"{listed[name]}  {name}\n" for name in sorted(listed))


def add(results: Path, paths: Iterable[Path]) -> None:
    """List what a job has written; batches are parts of datasets, and are not listed."""
    files = {path.relative_to(results).as_posix(): path for path in paths if path.is_file()}
    listed = {name: seal.digest_of(path) for name, path in files.items() if not _is_batch(name)}
    if not listed:
        return
    with (results / _LOCK).open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # jobs end at the same time
        write(results, of_run(results) | listed)


def write(folder: Path, listed: Mapping[str, str]) -> None:
    """Write the list of a folder."""
    with replacing(folder / NAME) as unfinished:
        unfinished.write_text(text(listed), encoding="utf-8")


def of_run(results: Path) -> dict[str, str]:
    """Checksums of the files of a run by name. A damaged line lists nothing."""
    try:
        content = (results / NAME).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return {}
    return {name: checksum for checksum, name in _LINE.findall(content)}


def check(results: Path, names: Iterable[str], run: dict[str, Any] | None = None) -> None:
    """Raise InputError for the first file of a folder of results that is not what the run wrote.

    A file that is not listed comes from an older version and must have a seal of its own.

    run : preset and name of the run, for the remedy; looked up in its datasets if not given.
    """
    listed = of_run(results)
    for name in names:
        path = results / name
        try:
            seal.check(path, strict=name not in listed)
            if name in listed and seal.digest_of(path) != listed[name]:
                raise InputError(f"{path}: damaged or changed: not what the run wrote")
        except InputError as error:
            raise InputError(f"{error}; {_remedy(path, results, run)}") from None


def _is_batch(name: str) -> bool:
    return name.startswith("batches/")


def _remedy(path: Path, results: Path, run: dict[str, Any] | None) -> str:
    """Words on how to make a file again."""
    from beltrepro.replication.plan import files  # only where something is wrong

    for dataset in sorted((results / "datasets").glob("*.h5")) if run is None else ():
        with suppress(InputError):
            run = files.read_any(dataset).attributes
            break
    return files.repair(path, run) if run else "copy or publish that run again"

"""The seal on a file of results: the SHA-256 of its bytes, which every reader compares.

It stands behind the end of a file whose format allows that (HDF5, PNG, PDF), as a marker and the
digest; of others (CSV, films) in NAME-metadata.json beside the file. HDF5 files need it most:
libhdf5 does not survive every flipped bit. One in the type of a text attribute is a segmentation
fault, after one in the heap of these texts it reads on and on (stopped after 40 s). So the bytes
are compared before it opens the file.

The seal is no part of the data: an HDF5 file has in its superblock "the absolute file address of
the first byte past the end of all HDF5 data" (HDF5 File Format Specification 3.0, II.A), a PNG ends
with IEND and a PDF with %%EOF, and readers look no further. A file opened for writing loses its
seal.
"""

import hashlib
from pathlib import Path

from beltrepro.base import reading
from beltrepro.base.errors import InputError

MARKER = b"\nbeltrepro sha256 "
LENGTH = len(MARKER) + 64
KEY = "beltrepro:checksum"  # in the metadata beside a file
_METADATA = "-metadata.json"


def digest(content: bytes) -> str:
    """SHA-256 of some bytes, as hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()


def digest_of(path: Path) -> str:
    """SHA-256 of the bytes of a file."""
    with reading.opened(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def put(path: Path) -> None:
    """Append the seal to a closed file."""
    with path.open("r+b") as file:
        file.seek(0, 2)
        file.write(MARKER + digest_of(path).encode())


def metadata_path(path: Path) -> Path:
    """Where it is said what a file is: beside it."""
    return path.with_name(f"{path.name}{_METADATA}")


def check(path: Path, *, strict: bool = False) -> None:
    """Compare a file with its seal, at some 500 MB/s.

    A file without a seal passes, unless `strict`: an older version made it, or a user.
    """
    agrees = _is_whole(path), _is_as_described(path)
    if False in agrees:
        raise InputError(f"{path}: damaged: its bytes do not have their checksum")
    if strict and True not in agrees:
        raise InputError(f"{path}: has no checksum: an older version made it, or another program")


def _is_whole(path: Path) -> bool | None:
    """Whether the bytes before the seal at the end of a file are as it says; None without one."""
    with reading.opened(path) as file:
        file.seek(max(0, file.seek(0, 2) - LENGTH))
        begin, end = file.tell(), file.read()
        place = end.find(MARKER)
        if place < 0:
            return None
        file.seek(0)
        content, left = hashlib.sha256(), begin + place
        while piece := file.read(min(1 << 20, left)):
            content.update(piece)
            left -= len(piece)
        return content.hexdigest().encode() == end[place + len(MARKER) :]


def _is_as_described(path: Path) -> bool | None:
    """Whether the bytes of a file are as its metadata say, which have the first of the digits.

    Of metadata: whether they are those of the file beside them. None if nothing is said.
    """
    if path.name.endswith(_METADATA):
        path = path.with_name(path.name.removesuffix(_METADATA))
        if not path.exists():
            return False
    if not (metadata := metadata_path(path)).exists():
        return None
    said = reading.json_object(metadata).get(KEY)
    return None if said is None else digest_of(path).startswith(str(said) or "-")

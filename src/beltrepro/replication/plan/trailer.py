"""A checksum behind the end of an HDF5 file, so that a damaged file never reaches libhdf5.

libhdf5 does not survive every flipped bit. One in the type of a text attribute is a segmentation
fault. After one in the heap of these texts it reads on and on (stopped after 40 s). So the bytes
are compared before it opens the file.

The trailer is a marker and the SHA-256 of all bytes before it. It is no part of the HDF5 data: the
superblock has their end, "the absolute file address of the first byte past the end of all HDF5
data" (HDF5 File Format Specification 3.0, II.A, End of File Address), and readers look no further.
A file that is opened for writing loses its trailer.
"""

import hashlib
from pathlib import Path
from typing import BinaryIO

from beltrepro.base.errors import InputError

MARKER = b"\nbeltrepro sha256 "
LENGTH = len(MARKER) + 64
_BLOCK = 1 << 20  # bytes


def put(path: Path) -> None:
    """Append the trailer to a closed file."""
    with path.open("r+b") as file:
        digest = _digest(file, path.stat().st_size)
        file.write(MARKER + digest)


def check(path: Path) -> None:
    """Compare a file with its trailer, at some 500 MB/s.

    A file without a trailer passes: an older version made it, or a user. So does one that lost its
    marker: what it holds has a checksum of its own (`store.read`).
    """
    try:
        with path.open("rb") as file:
            size = path.stat().st_size
            file.seek(max(0, size - LENGTH))
            begin, end = file.tell(), file.read()
            place = end.find(MARKER)
            if place < 0:
                return
            file.seek(0)
            found = _digest(file, begin + place)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    if found != end[place + len(MARKER) :]:
        raise InputError(f"{path}: damaged: its bytes do not have their checksum")


def _digest(file: BinaryIO, size: int) -> bytes:
    """SHA-256 of the next bytes, as hexadecimal digits; the file is read up to there."""
    digest = hashlib.sha256()
    while block := file.read(min(_BLOCK, size)):
        digest.update(block)
        size -= len(block)
    return digest.hexdigest().encode()

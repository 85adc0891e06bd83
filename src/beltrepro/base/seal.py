"""The seal on a file: the SHA-256 of all bytes before it, which stands behind the end of the data.

Readers of HDF5, PNG and PDF look no further than the end of their data: HDF5 has its address in the
superblock (File Format Specification 3.0, II.A), PNG ends with IEND and PDF with %%EOF. Elsewhere
the seal is in a remark, or in a box that players skip. A file that another program opens for
writing loses its seal.
"""

import hashlib
from pathlib import Path

from beltrepro.base import reading
from beltrepro.base.errors import InputError

MARKER = "beltrepro sha256 "
REMEDY = "delete it and make it again"
# What stands around it. A box of MP4 begins with its length (ISO/IEC 14496-12, 4.2).
_AROUND = {
    ".csv": ("# ", "\n"),
    ".html": ("<!-- ", " -->\n"),
    ".mp4": ("\0\0\0\x5afree\n", ""),
    ".svg": ("<!-- ", " -->\n"),
}


def put(path: Path) -> None:
    """Append the seal to a closed file."""
    with path.open("r+b") as file:
        digest = hashlib.file_digest(file, "sha256")
        file.write(_seal(path, digest.hexdigest()))


def check(path: Path) -> int:
    """Compare a file with its seal, at some 500 MB/s, and return how many bytes are before it."""
    with reading.opened(path) as file:
        size = file.seek(0, 2)
        end = file.seek(max(0, size - len(_seal(path, "0" * 64))))
        said = file.read()
        if MARKER.encode() not in said:
            whose = "another program made it or changed it; if it should be a result of beltrepro"
            raise InputError(f"{path}: has no seal: {whose}, {REMEDY}")
        file.seek(0)
        digest = hashlib.sha256()
        while piece := file.read(min(1 << 20, end - file.tell())):
            digest.update(piece)
    if said != _seal(path, digest.hexdigest()):
        reason = "damaged: its bytes are not those of its seal"
        raise InputError(f"{path}: {reason}: {REMEDY}")
    return end


def content(path: Path) -> str:
    """The text of a file before its seal, which is compared."""
    return path.read_bytes()[: check(path)].decode()


def _seal(path: Path, digest: str) -> bytes:
    before, after = _AROUND.get(path.suffix.lower(), ("\n", ""))
    return f"{before}{MARKER}{digest}{after}".encode()

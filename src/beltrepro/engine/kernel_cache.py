"""Machine code of a kernel on disk, for any number of processes and kinds of processors at once.

Numba numbers the files of its cache, and never finds again those of kernels that enclose functions.
Two processes that save at the same time can take the same number, and then one of them runs the
machine code of the other. Here a file is named by what it holds: kernel, types of arguments,
processor. Where nothing can be kept each process compiles for itself.
"""

import contextlib
import functools
import hashlib
import logging
import pickle
import uuid
from pathlib import Path

import numba
from numba.core.serialize import dumps

SEAL = 32  # bytes of a SHA-256
COMPILING = (
    "compiling for this processor, once: up to 20 s for each kind of run "
    "(`python -m beltrepro.extras.cache` compiles all kinds beforehand)"
)
NOT_KEPT = "machine code of kernels cannot be kept in {}: {}; every process compiles anew"

logger = logging.getLogger("beltrepro")


class KernelCacheFile:
    """Where Numba keeps machine code of one kernel, in place of its own IndexDataCacheFile."""

    def __init__(self, folder, name, stamp):
        self._folder = Path(folder)
        self._name = name
        self._stamp = stamp

    def load(self, key):
        """What was saved under this key, or None: then the caller compiles, and saves."""
        try:
            saved = self._path(key).read_bytes()
        except OSError:
            saved = b""
        seal, content = saved[:SEAL], saved[SEAL:]
        if seal == self._seal(key, content):
            return pickle.loads(content)
        _announce(COMPILING)
        return None

    def save(self, key, data):
        """Write a whole file or none."""
        path = self._path(key)
        # of its own, since other processes may write the same file at this moment
        draft = path.with_name(f"{path.name}.tmp.{uuid.uuid4().hex[:16]}")
        content = dumps(data)
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            draft.write_bytes(self._seal(key, content) + content)
            draft.replace(path)
        except OSError as error:
            _announce(NOT_KEPT.format(self._folder, error.strerror))
            with contextlib.suppress(OSError):
                draft.unlink()

    def _path(self, key):
        return self._folder / f"{self._name}.{digest(repr(key)).hex()[:16]}.nbc"

    def _seal(self, key, content):
        """First bytes of a file: what it should be, and that it is whole."""
        return digest(repr((numba.__version__, self._stamp, key)), content)


@functools.cache
def _announce(message):
    """Say once in a process why it takes so long: in the log of a job, otherwise on stderr."""
    logger.warning(message)


def digest(text, content=b""):
    return hashlib.sha256(text.encode() + content).digest()

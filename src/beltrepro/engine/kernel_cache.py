"""Machine code of a kernel on disk, for any number of processes and kinds of processors at once.

Numba numbers the files of its cache. Two processes that save at the same time can take the same
number, and then one of them runs the machine code of the other. Here a file is named by what it
holds: kernel, types of arguments, processor. The first process that misses a kernel locks it and
compiles, others wait for its file. A file is code that runs when it is loaded, so one that somebody
else owns is not looked at. Where nothing can be kept each process compiles for itself.
"""

import contextlib
import functools
import hashlib
import logging
import os
import pickle
import stat
import time
import uuid
from pathlib import Path

import numba
from numba.core.serialize import dumps

try:
    import fcntl
except ImportError:  # Windows: every process compiles for itself
    fcntl = None

PATIENCE = 900.0  # seconds to wait for another process; most kernels compile in less than 20
PAUSE = 0.2  # seconds between two looks
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
        self._locks = {}

    def load(self, key):
        """What was saved under this key, or None: then the caller compiles, and saves."""
        data = self._read(key)
        if data is None:
            _announce(COMPILING)
        if data is None and self._wait_for_lock(key):
            data = self._read(key)  # another process may have saved it meanwhile
            if data is not None:
                self._unlock(key)
        return data

    def save(self, key, data):
        """Write a whole file or none, and let those go on who wait for it."""
        path = self._path(key)
        draft = path.with_name(f"{path.name}.tmp.{uuid.uuid4().hex[:16]}")
        content = dumps(data)
        try:
            draft.write_bytes(self._seal(key, content) + content)
            draft.replace(path)
        except OSError as error:
            _announce(NOT_KEPT.format(self._folder, error.strerror))
        finally:
            with contextlib.suppress(OSError):
                draft.unlink(missing_ok=True)
            self._unlock(key)

    def flush(self):
        """Forget all that was saved of this kernel."""
        for path in self._folder.glob(f"{self._name}.*.nbc"):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)

    def _path(self, key):
        return self._folder / f"{self._name}.{_digest(repr(key)).hex()[:16]}.nbc"

    def _seal(self, key, content):
        """First bytes of a file: what it should be, and that it is whole."""
        return _digest(repr((numba.__version__, self._stamp, key)), content)

    def _read(self, key):
        try:
            with open(self._path(key), "rb", opener=_without_waiting) as file:
                saved = file.read() if _is_trusted(os.fstat(file.fileno())) else b""
        except OSError:
            return None
        seal, content = saved[:SEAL], saved[SEAL:]
        return pickle.loads(content) if seal == self._seal(key, content) else None

    def _wait_for_lock(self, key):
        """Whether the lock is ours after at most PATIENCE; False where files cannot be locked."""
        if key in self._locks:  # compiling failed before
            return True
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            lock = self._path(key).with_suffix(".lock")
            handle = open(lock, "ab", opener=_without_waiting)  # noqa: SIM115 (kept open)
        except OSError:
            return False
        if not _locked(handle):
            handle.close()
            return False
        self._locks[key] = handle
        return True

    def _unlock(self, key):
        if key in self._locks:
            self._locks.pop(key).close()


@functools.cache
def _announce(message):
    """Say once in a process why it takes so long: in the log of a job, otherwise on stderr."""
    logger.warning(message)


def _is_trusted(status):
    """Whether a file is one of our own, or of whoever owns this module, which runs anyway."""
    trusted = Path(__file__).stat().st_uid, getattr(os, "geteuid", int)()  # no users on Windows
    return stat.S_ISREG(status.st_mode) and status.st_uid in trusted


def _without_waiting(path, flags):
    """Open a pipe at once or not at all: the plain way waits for who opens its other end."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0), 0o666)


def _locked(handle):
    """Lock an open file; the system frees it when the process ends, however it ends."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            if time.monotonic() > end:
                return False
            time.sleep(PAUSE)
        except (AttributeError, OSError):
            return False


def _digest(text, content=b""):
    return hashlib.sha256(text.encode() + content).digest()

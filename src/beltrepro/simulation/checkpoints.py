"""Unfinished work kept in a file, so that a job that is killed goes on where it was.

The work of a job is a sequence of steps, and steps of steps: the groups of a batch, in each the
runs that it takes, in a run its chunks. Since a job does the same steps again when it is run again,
a step is known by its place in this order, and a step that is kept need not be done.
"""

import hashlib
import logging
import pickle
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, TypeVar

from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError

logger = logging.getLogger("beltrepro")

EVERY = 60.0  # seconds of the processor between two writes
_WORTH = 5.0  # seconds of the processor; shorter steps are done again
_SHARE = 20  # writing takes at most one in so many seconds
_HEADER = 2 * 32  # bytes: hash of what the work is, hash of what follows

Place = tuple[int, ...]
V = TypeVar("V")


class Checkpoint:
    """Values of steps, in memory and now and then in a file."""

    def __init__(self, path: Path, work: str, every: float = EVERY) -> None:
        self._path, self._every = path, every
        self._work = hashlib.sha256(work.encode()).digest()
        self._values: dict[Place, bytes] = _read(path, self._work)
        self._place: Place = ()
        self._begun = [0]  # steps begun at each depth of the place
        self._written, self._pause = time.process_time(), every

    @contextmanager
    def step(self) -> Iterator["Step"]:
        """The next step of the one that is open."""
        outer = self._place
        self._place = (*outer, self._begun[-1])
        self._begun[-1] += 1
        self._begun.append(0)
        try:
            yield Step(self, self._place)
        finally:
            self._begun.pop()
            self._place = outer

    def kept(self, place: Place) -> Any:
        """The value of a step, None if there is none."""
        value = self._values.get(place)
        return None if value is None else pickle.loads(value)

    def keep(self, place: Place, value: Any) -> None:
        """Keep the value of the step that is open; it stands for all steps in it so far."""
        for inner in [inner for inner in self._values if inner[: len(place)] == place]:
            del self._values[inner]
        self._begun[-1] = 0
        self._values[place] = pickle.dumps(value, protocol=5)  # as it is now
        if self.due:
            self._write()

    @property
    def due(self) -> bool:
        """Whether it is time to write."""
        return time.process_time() >= self._written + self._pause

    def remove(self) -> None:
        """Remove the file: the work is done."""
        self._path.unlink(missing_ok=True)

    def _write(self) -> None:
        begun = time.process_time()
        content = pickle.dumps(self._values, protocol=5)
        try:
            with replacing(self._path) as unfinished:
                unfinished.write_bytes(self._work + hashlib.sha256(content).digest() + content)
        except InputError as error:
            logger.warning("no checkpoint: %s", error)
        self._written = time.process_time()
        self._pause = max(self._every, _SHARE * (self._written - begun) if self._every else 0.0)


class Step:
    """One step of the work."""

    def __init__(self, checkpoint: Checkpoint | None, place: Place = ()) -> None:
        self._checkpoint, self._place = checkpoint, place
        self.kept = checkpoint.kept(place) if checkpoint else None
        self._begun = time.process_time()

    @property
    def due(self) -> bool:
        """Whether it is time to keep how far the step is."""
        return self._checkpoint is not None and self._checkpoint.due

    def keep(self, value: Any) -> None:
        """Keep how far the step is."""
        if self._checkpoint is not None:
            self._checkpoint.keep(self._place, value)

    def end(self, outcome: Callable[[], Any]) -> None:
        """Keep the outcome of the step if it took long."""
        if self.due or (self._checkpoint and time.process_time() - self._begun >= _WORTH):
            self.keep(outcome())


_current: ContextVar[Checkpoint | None] = ContextVar("checkpoint", default=None)


@contextmanager
def keeping(path: str | Path, work: str, every: float = EVERY) -> Iterator[None]:
    """Keep what is simulated in the block in a file, which is removed at the end of the block."""
    checkpoint = Checkpoint(Path(path), work, every)
    token = _current.set(checkpoint)
    try:
        yield
    finally:
        _current.reset(token)
    checkpoint.remove()


@contextmanager
def step(kept: bool = True) -> Iterator[Step]:
    """The next step of the work that is done."""
    checkpoint = _current.get()
    if checkpoint is None or not kept:
        yield Step(None)
        return
    with checkpoint.step() as begun:
        yield begun


def once(work: Callable[..., V], *arguments: Any) -> V:
    """The value of a function, which is not called if its value is kept."""
    with step() as begun:
        if begun.kept is not None:
            return begun.kept
        value = work(*arguments)
        begun.end(lambda: value)
    return value


def restore(observers: Sequence, kept: Sequence) -> None:
    """Give observers what others of their kind have seen."""
    for observer, seen in zip(observers, kept, strict=True):
        vars(observer).update(vars(seen))


def _read(path: Path, work: bytes) -> dict[Place, bytes]:
    """Values of the steps of this work in a file; none if it holds other work or is damaged."""
    try:
        content = path.read_bytes()
    except OSError:
        return {}
    work_of_file, checksum, content = content[:32], content[32:_HEADER], content[_HEADER:]
    if hashlib.sha256(content).digest() != checksum:
        logger.warning("%s: damaged, beginning anew", path)
        return {}
    if work_of_file != work:
        logger.info("%s: of other settings, code or machine, beginning anew", path)
        return {}
    logger.info("going on from %s", path)
    return pickle.loads(content)

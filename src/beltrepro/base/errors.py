"""Errors and warnings a user may see: each is one clear line."""

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager


class InputError(ValueError):
    """A value is not allowed; the message names the key, the value and what is allowed."""

    def __init__(self, text: object) -> None:
        super().__init__(" ".join(str(text).split()))  # a name in it may have a line break


class ModelStateError(RuntimeError):
    """A run left the range of the model (NaN, or blocks that pass through each other)."""


class NotEnoughDataError(ValueError):
    """Too few, or the wrong, data for this estimate; the message is one line with the reason."""


def require(condition: object, reason: str) -> None:
    """Say that the data do not carry a number, unless the condition holds."""
    if not condition:
        raise NotEnoughDataError(reason)


@contextmanager
def needing(purpose: str, extra: str = "results") -> Iterator[None]:
    """Say in one line which extra of the package brings what is imported within this block."""
    try:
        yield
    except ModuleNotFoundError as error:
        module = (error.name or "").partition(".")[0]
        raise InputError(f"{purpose} needs {module}: pip install 'beltrepro[{extra}]'") from None


def warn(text: str) -> None:
    """Warn at the line outside this package from which it was called."""
    frame, level = sys._getframe(), 1
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == "beltrepro":
        frame, level = frame.f_back, level + 1
    warnings.warn(text, stacklevel=level)

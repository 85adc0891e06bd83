"""The word of a periodic orbit: which block slips and sticks, in which order.

A symbol is a block and what happens to it: "-" it starts to slip backwards over the belt, "+" it
starts to slip forwards, "|" it sticks. A block that reverses does not stick in between.
"""

from itertools import zip_longest
from typing import NamedTuple

import numpy as np

_SAME = 0.05  # of a unit of time, by which the same event moves from one orbit to the next at most


class Symbol(NamedTuple):
    """What happens to a block, from 1, at a time."""

    time: float
    block: int
    kind: str

    def __str__(self) -> str:
        return f"{self.block}{self.kind}"


Word = list[Symbol]


def symbols(events: np.ndarray) -> Word:
    """Those of the events of a run, as `Run.events` has them."""
    slips = events["kind"] == "slip"
    instants = events[["time", "block"]]
    reverses = np.zeros(len(events), dtype=bool)
    reverses[:-1] = ~slips[:-1] & slips[1:] & (instants[:-1] == instants[1:])
    kinds = np.where(slips, np.where(events["force"] < 0, "-", "+"), "|")
    columns = (events["time"], events["block"], kinds)
    return [Symbol(*row) for row in zip(*(c[~reverses].tolist() for c in columns), strict=True)]


def kinds(word: Word) -> dict[int, str]:
    """What happens to each block, in order."""
    return {
        block: "".join(symbol.kind for symbol in part) for block, part in _by_block(word).items()
    }


def _by_block(word: Word) -> dict[int, Word]:
    return {
        block: [symbol for symbol in word if symbol.block == block]
        for block in dict.fromkeys(symbol.block for symbol in word)
    }


def slips_alike(one: Word, other: Word) -> bool:
    """Whether each block slips as often in both periods, in the same directions and order."""
    # The order of events of different blocks may change along a branch, and a stick may shrink to
    # nothing between two slips: the motion goes on smoothly.
    first, second = (
        {block: events.replace("|", "") for block, events in kinds(word).items()}
        for word in (one, other)
    )
    return first.keys() == second.keys() and all(
        len(slips) == len(second[block]) and slips in 2 * second[block]
        for block, slips in first.items()
    )


def sticks(word: Word) -> dict[int, int]:
    """How often each block sticks."""
    return {block: events.count("|") for block, events in kinds(word).items()}


def repeats(word: Word, period_time: float, within: float) -> int:
    """Into how many equal parts a period falls, to within a share of it; 1 if it does not."""
    times = np.array([symbol.time for symbol in word])
    names = [str(symbol) for symbol in word]
    for parts in (parts for parts in range(len(word), 1, -1) if len(word) % parts == 0):
        by = len(word) // parts
        apart = (np.roll(times, -by) - times) % period_time - period_time / parts
        if names == names[by:] + names[:by] and np.abs(apart).max() <= within * period_time:
            return parts
    return 1


class Difference(NamedTuple):
    """The first event of one motion that another one does not have."""

    symbol: Symbol
    appears: bool  # in the other motion, else it disappears there
    at_once: bool  # it is the stick, or the slip after it, of a stick of no length


def first_difference(inside: Word, outside: Word, unit: float) -> Difference | None:
    """Where two motions that begin side by side first differ, if they do; unit : of their time."""
    differences = []
    first, second = _by_block(inside), _by_block(outside)
    for block in first.keys() | second.keys():
        for old, new in zip_longest(first.get(block, []), second.get(block, [])):
            near = bool(old and new) and abs(new.time - old.time) < _SAME * unit
            if not (near and old.kind == new.kind):
                appears = old is None or (new is not None and new.time < old.time)
                differences.append(Difference(new if appears else old, appears, near))
                break
    return min(differences, default=None)

"""The word of a periodic orbit: which block slips and sticks, in which order.

A symbol is a block and what happens to it: "-" it starts to slip backwards over the belt, "+" it
starts to slip forwards, "|" it sticks. A block that reverses does not stick in between.
"""

from collections.abc import Iterable
from itertools import zip_longest
from typing import NamedTuple

import numpy as np

SAME = 0.05  # model time: an event that moves less from one orbit to the next is the same one


class Symbol(NamedTuple):
    """What happens to a block, from 1, at a time."""

    time: float
    block: int
    kind: str

    def __str__(self) -> str:
        return f"{self.block}{self.kind}"


def symbols(events: np.ndarray) -> list[Symbol]:
    """Those of the events of a run, as `Run.events` has them."""
    if not len(events):
        return []
    slips = events["kind"] == "slip"
    instants = events[["time", "block"]]
    reverses = np.append(~slips[:-1] & slips[1:] & (instants[:-1] == instants[1:]), False)
    kinds = np.where(slips, np.where(events["force"] < 0, "-", "+"), "|")
    columns = (events["time"], events["block"], kinds)
    return [Symbol(*row) for row in zip(*(c[~reverses].tolist() for c in columns), strict=True)]


def kinds(word: Iterable[Symbol]) -> dict[int, str]:
    """What happens to each block, in order."""
    blocks: dict[int, str] = {}
    for symbol in word:
        blocks[symbol.block] = blocks.get(symbol.block, "") + symbol.kind
    return blocks


def slips_alike(one: Iterable[Symbol], other: Iterable[Symbol]) -> bool:
    """Whether each block slips as often in both periods, in the same directions and order.

    The order of events of different blocks may change along a branch, and a stick may shrink to
    nothing between two slips: the motion goes on smoothly.
    """
    first, second = (
        {block: word.replace("|", "") for block, word in kinds(both).items()}
        for both in (one, other)
    )
    return first.keys() == second.keys() and all(
        len(first[block]) == len(second[block]) and first[block] in 2 * second[block]
        for block in first
    )


def sticks(word: Iterable[Symbol]) -> dict[int, int]:
    """How often each block sticks."""
    return {block: what.count("|") for block, what in kinds(word).items()}


def repeats(word: list[Symbol], period_time: float, within: float) -> int:
    """Into how many equal parts a period falls, to within a share of it; 1 if it does not."""
    times = np.array([symbol.time for symbol in word])
    names = np.array([str(symbol) for symbol in word])
    for parts in range(len(word), 1, -1):
        if len(word) % parts == 0:
            by = len(word) // parts
            apart = (np.roll(times, -by) - times) % period_time - period_time / parts
            alike = np.array_equal(names, np.roll(names, -by))
            if alike and np.abs(apart).max() <= within * period_time:
                return parts
    return 1


class Difference(NamedTuple):
    """The first event of one motion that another one does not have."""

    symbol: Symbol
    appears: bool  # in the other motion, else it disappears there
    at_once: bool  # it is the stick, or the slip after it, of a stick of no length


def first_difference(inside: list[Symbol], outside: list[Symbol]) -> Difference | None:
    """Where two motions that begin side by side first differ, if they do."""
    differences = []
    first, second = _by_block(inside), _by_block(outside)
    for block in first.keys() | second.keys():
        for pair in zip_longest(first.get(block, []), second.get(block, [])):
            old, new = pair
            near = bool(old and new) and abs(new.time - old.time) < SAME
            if near and old.kind == new.kind:
                continue
            appears = old is None or (new is not None and new.time < old.time)
            differences.append(Difference(new if appears else old, appears, near))
            break
    return min(differences, default=None)


def _by_block(word: Iterable[Symbol]) -> dict[int, list[Symbol]]:
    blocks: dict[int, list[Symbol]] = {}
    for symbol in word:
        blocks.setdefault(symbol.block, []).append(symbol)
    return blocks

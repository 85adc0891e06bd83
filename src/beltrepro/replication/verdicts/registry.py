"""Claim functions by the id of their claim."""

from collections.abc import Callable

REGISTRY: dict[str, Callable] = {}


def claim(identifier: str):
    """Register a function `(evidence) -> Measurement`, or one that returns readings, for a claim.

    Readings of an open point are a dict of functions `() -> Measurement` by name; the first is the
    one that counts, the others are variants.
    """

    def register(function):
        if identifier in REGISTRY:
            raise ValueError(f"claim {identifier!r} has two functions")
        REGISTRY[identifier] = function
        return function

    return register

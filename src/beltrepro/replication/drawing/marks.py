"""Which artists of a figure show which estimates, so that a test can compare them."""

from typing import Any

SEPARATOR = " :: "


def shown(artist: Any, claim: str, *names: str, variant: str = "") -> Any:
    """Mark an artist as one that shows these estimates of a claim, in the order of its points.

    A line or errorbar shows them by its places along one axis, a span by its two ends, a text by
    the numbers in it. Containers are marked at their first line.
    """
    first = artist[0] if isinstance(artist, tuple | list) else artist
    key = f"{claim}: {variant}" if variant else claim
    first.set_gid(SEPARATOR.join((key, *names)))
    return artist


def marked(figure: Any) -> list[tuple[Any, str, tuple[str, ...]]]:
    """Artists of a figure that show estimates: artist, key of `Figure.shows`, names."""
    split = [(artist, *(artist.get_gid() or "").split(SEPARATOR)) for artist in figure.findobj()]
    return [(artist, key, tuple(names)) for artist, key, *names in split if names]

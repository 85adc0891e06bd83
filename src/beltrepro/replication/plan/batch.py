"""A batch simulated: from points to the function of their kind, and to the columns of a file.

It is part of the code behind each dataset, and so it imports no kind: a new one reruns nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from pkgutil import resolve_name

import numpy as np

from beltrepro.replication.plan.points import Point, chain, columns
from beltrepro.simulation.setup import Setup


def record(
    function: str,
    names: Collection[str],
    points: Sequence[Point],
    settings: dict,
    progress: Callable[[float], None] | None = None,
) -> dict[str, np.ndarray]:
    """Simulate points by the function of their kind, and keep the arrays that a file has of it."""
    of_setup = ("method", "time_step", "seed", "replicate", "initial_spread")
    numerics: dict = {name: [getattr(point, name) for point in points] for name in of_setup}
    setup = Setup([chain(point) for point in points], **numerics)
    simulate: Callable[..., dict[str, np.ndarray]] = resolve_name(function)
    measured = simulate(setup, **settings, progress=progress)
    # a scan has more than its file: the sum rule, which says of each number that it is N k
    return columns(points) | {name: measured[name] for name in measured if name in names}

"""A batch simulated: from points to the function of their kind, and to the columns of a file.

It is part of the code behind each dataset, and so it imports no kind: a new one reruns nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pkgutil import resolve_name
from typing import TYPE_CHECKING

import numpy as np

from beltrepro.replication.plan.points import Point, chain, columns
from beltrepro.simulation.setup import Setup

if TYPE_CHECKING:
    from beltrepro.replication.plan.kinds import Kind


def record(
    kind: Kind,
    points: Sequence[Point],
    settings: dict,
    progress: Callable[[float], None] | None = None,
) -> dict[str, np.ndarray]:
    """Simulate points and record what their kind says."""
    names = ("method", "time_step", "seed", "replicate", "initial_spread")
    numerics: dict = {name: [getattr(point, name) for point in points] for name in names}
    setup = Setup([chain(point) for point in points], **numerics)
    simulate: Callable[..., dict[str, np.ndarray]] = resolve_name(kind.record)
    measured = simulate(setup, **settings, progress=progress)
    # a scan has more than its file: the sum rule, which says of each number that it is N k
    kept = kind.recorded
    return columns(points) | {name: measured[name] for name in measured if name in kept}

"""Many chains that are kicked at each start of a slip (`beltrepro.engine.kicks`)."""

from collections.abc import Sequence

import numpy as np

from beltrepro.engine import kicks
from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.memory import aligned


class KickedIntegrator(EventIntegrator):
    """Chains integrated by `event`, with a random kick at each start of a slip.

    Parameters as for `EventIntegrator`, and sizes : standard deviation of the kicks of each of the
    W chains, model length. The deviates come from the streams of the chains, which their states
    carry: a run goes on where it has stopped.
    """

    _hooks = kicks.HOOKS

    def __init__(self, states, *, sizes: Sequence[float], **settings):
        super().__init__(states, **settings)
        self._companion = kicks.Kicks(aligned(np.asarray(sizes, dtype=float)[self._source]))

"""What is compared: each competitor advances one chain, or several together, by a span of time."""

import functools

import numpy as np

from beltrepro.engine.integrator import Sampling
from beltrepro.engine.state import ChainState
from beltrepro.engine.tangent import TangentIntegrator
from beltrepro.engine.verlet_integrators import SteppingVerlet
from beltrepro.extras.bench.plain import PlainChain, c_loop, numba_loop
from beltrepro.extras.bench.smooth import SolveIvpChain
from beltrepro.model import ChainParameters
from beltrepro.simulation import METHODS

BASE = "numba"  # the plain loop that the others are compared with
LABELS = {
    "numba": "plain loop, Numba",
    "c": "plain loop, C",
    "scipy": "solve_ivp",
    "steps": "verlet step by step",
    "verlet": "verlet",
    "event": "event",
    "tangent": "event with 1 vector",
}
_INTEGRATORS = {
    "steps": SteppingVerlet,  # verlet without leaps
    **METHODS,
    "tangent": functools.partial(TangentIntegrator, n_vectors=1),
}
TIME_STEP = 0.001
_SAMPLE_STRIDE = 100  # steps between samples of x_N, the same as in a scan


class GroupRunner:
    """Several chains, with starts 0.001 apart, advanced together by one of `_INTEGRATORS`."""

    def __init__(self, method: str, parameters: ChainParameters, chains: int):
        self.chains = chains
        random = np.random.default_rng(1)
        spread = 1e-3 * random.standard_normal((chains, parameters.n_blocks))
        starts = parameters.rest_positions + spread
        self._integrator = _INTEGRATORS[method](
            [ChainState.at_rest(parameters, start, replicate=k) for k, start in enumerate(starts)],
            time_step=TIME_STEP,
            sampling=Sampling(_SAMPLE_STRIDE, TIME_STEP),
            sampled_blocks=1,
        )
        self._time = 0.0

    def advance(self, span: float) -> None:
        """Advance all chains by `span` of model time."""
        self._time += span
        for _ in self._integrator.advance(self._time):
            pass


def competitor(name: str, parameters: ChainParameters, chains: int, warm_up: float):
    """One competitor with chains that are under way; None if it cannot run here or such a chain.

    Only the integrators of this package advance several chains together.
    """
    if name == "steps" and parameters.noise > 0:
        return None  # then `verlet` itself goes step by step
    if name not in ("numba", "c", "scipy"):
        runner = GroupRunner(name, parameters, chains)
        runner.advance(warm_up)
        return runner
    loop = c_loop() if name == "c" else numba_loop
    if loop is None or (name == "scipy" and parameters.noise > 0):
        return None
    plain = PlainChain(parameters, loop, time_step=TIME_STEP)
    plain.advance(warm_up)
    return SolveIvpChain(plain) if name == "scipy" else plain

"""What "the same noise" means for a second chain: by the time since a rest, or by the time.

`event` begins the noise anew with the slip that ends a rest of the whole chain. If the second chain
ends its rest later, its noise is later too: `TangentIntegrator` carries that delay. Here the noise
stays where it is in time, and only its begin is later (docs/tangent.md).
"""

from beltrepro.base import names
from beltrepro.engine import tangent
from beltrepro.engine.simd import load, select, store
from beltrepro.engine.tangent import TangentIntegrator
from beltrepro.engine.vector import inlined


@inlined
def _hold_noise(order, lane, active, sliding, group, scratch, deviations):
    """Hook: after a rest the second chain misses the noise until its own slip, and no more."""
    chains = group.chains
    begun = active & sliding
    for vector in range(deviations.delay.shape[0]):
        delay = select(begun, load(deviations.delay, (vector, lane)), 0.0)
        for block in range(chains.direction.shape[0]):
            slipping = load(chains.direction, (block, lane)) != 0.0
            force = select(slipping, load(chains.noise_force, (0, block, lane)), 0.0)
            place = (vector, block, lane)
            store(deviations.velocity, place, load(deviations.velocity, place) - force * delay)
        kept = select(begun, 0.0, load(deviations.delay, (vector, lane)))
        store(deviations.delay, (vector, lane), kept)


class LaboratoryIntegrator(TangentIntegrator):
    """Chains with deviations under noise that is the same at the same time."""

    _hooks = tangent.HOOKS._replace(series_made=_hold_noise)


REST, LABORATORY = "rest", "laboratory"
_INTEGRATORS = {REST: TangentIntegrator, LABORATORY: LaboratoryIntegrator}


def integrator_by(noise_clock: str) -> type[TangentIntegrator]:
    """The integrator for a clock of the noise."""
    return _INTEGRATORS[names.one_of("noise_clock", noise_clock, _INTEGRATORS)]

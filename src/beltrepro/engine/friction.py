"""The stick and slip rules of `beltrepro.model.friction` for kernels: one chain or a vector."""

from beltrepro.engine.simd import select
from beltrepro.engine.vector import inlined
from beltrepro.model.friction import next_direction_rule, slip_direction_rule

slip_direction = inlined(slip_direction_rule(select))
next_direction = inlined(next_direction_rule(select, slip_direction))


@inlined
def kinetic_friction(law):
    """Mean kinetic friction force."""
    return law.static_friction * law.friction_ratio

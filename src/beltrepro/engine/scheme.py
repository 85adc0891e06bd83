"""What both kernels of the scheme of the Appendix share."""

from beltrepro.engine.simd import fma
from beltrepro.engine.vector import inlined


@inlined
def scheme_velocity(slip_step, acceleration, before):
    """v_r dt after a step, from w after it, and a dt^2 at its start and one step before."""
    return fma(acceleration, 5.0 / 6.0, fma(before, -1.0 / 3.0, slip_step))

"""What one core can do at most: fused multiply-adds on vectors of doubles, nothing else."""

from beltrepro.engine.simd import WIDE_LANES, fma, load_wide, store
from beltrepro.engine.vector import kernel, separate_arrays

CHAINS = 6  # independent pairs of vectors: more than the latency of one times the units
OPERATIONS_PER_TURN = 2 * WIDE_LANES * CHAINS  # additions and multiplications


@kernel
def multiply_add(values, turns):
    """`turns` times a -> 0.999 a + 0.1 on the six vectors of sixteen in `values` (6, 16)."""
    separate_arrays()
    a = load_wide(values, (0, 0))
    b = load_wide(values, (1, 0))
    c = load_wide(values, (2, 0))
    d = load_wide(values, (3, 0))
    e = load_wide(values, (4, 0))
    f = load_wide(values, (5, 0))
    for _ in range(turns):
        a = fma(a, 0.999, 0.1)
        b = fma(b, 0.999, 0.1)
        c = fma(c, 0.999, 0.1)
        d = fma(d, 0.999, 0.1)
        e = fma(e, 0.999, 0.1)
        f = fma(f, 0.999, 0.1)
    store(values, (0, 0), a)
    store(values, (1, 0), b)
    store(values, (2, 0), c)
    store(values, (3, 0), d)
    store(values, (4, 0), e)
    store(values, (5, 0), f)

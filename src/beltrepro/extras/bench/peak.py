"""What one core can do at most: fused multiply-adds on vectors of doubles, nothing else."""

from beltrepro.engine.simd import LANES, fma, load, store
from beltrepro.engine.vector import kernel, separate_arrays

_CHAINS = 12  # independent chains of operations: more than the latency of one times the units
OPERATIONS_PER_TURN = 2 * LANES * _CHAINS  # additions and multiplications


@kernel
def multiply_add(values, turns):
    """`turns` times a -> 0.999 a + 0.1 on the twelve vectors of eight in `values` (12, 8)."""
    separate_arrays()
    a = load(values, (0, 0))
    b = load(values, (1, 0))
    c = load(values, (2, 0))
    d = load(values, (3, 0))
    e = load(values, (4, 0))
    f = load(values, (5, 0))
    g = load(values, (6, 0))
    h = load(values, (7, 0))
    i = load(values, (8, 0))
    j = load(values, (9, 0))
    k = load(values, (10, 0))
    m = load(values, (11, 0))
    for _ in range(turns):
        a = fma(a, 0.999, 0.1)
        b = fma(b, 0.999, 0.1)
        c = fma(c, 0.999, 0.1)
        d = fma(d, 0.999, 0.1)
        e = fma(e, 0.999, 0.1)
        f = fma(f, 0.999, 0.1)
        g = fma(g, 0.999, 0.1)
        h = fma(h, 0.999, 0.1)
        i = fma(i, 0.999, 0.1)
        j = fma(j, 0.999, 0.1)
        k = fma(k, 0.999, 0.1)
        m = fma(m, 0.999, 0.1)
    store(values, (0, 0), a)
    store(values, (1, 0), b)
    store(values, (2, 0), c)
    store(values, (3, 0), d)
    store(values, (4, 0), e)
    store(values, (5, 0), f)
    store(values, (6, 0), g)
    store(values, (7, 0), h)
    store(values, (8, 0), i)
    store(values, (9, 0), j)
    store(values, (10, 0), k)
    store(values, (11, 0), m)

"""How kernels are compiled, and the exponential they share.

A kernel works on vectors of eight chains (`beltrepro.engine.simd`). Two things stand between that
and full speed, and `separate_arrays` removes them: arrays that might overlap, and half-width
vectors. Functions here round the same way for one chain and for a vector of them.
"""

import functools
import hashlib
import inspect
import math
import pathlib

import numba
import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from beltrepro.engine.kernel_cache import KernelCacheFile, digest
from beltrepro.engine.simd import as_bits, fma, from_bits, select

_LINE = 64  # bytes of a cache line and of a vector of eight doubles


@functools.cache
def _engine_version():
    """Hash of the sources that kernels are made of: of this folder, and the law of friction."""
    here = pathlib.Path(__file__).parent
    sources = *sorted(here.glob("*.py")), here.parent / "model" / "friction.py"
    return hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()


def kernel(function):
    """Compile a kernel that is called from Python: cached, without the GIL, IEEE division."""
    dispatcher = numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    # it makes no arrays and keeps none: no references to count, which numba does by calls in loops
    dispatcher.targetoptions["_nrt"] = False
    cache = dispatcher._cache
    # a file for each set of what a kernel made by a function encloses
    enclosed = repr([_identity(cell.cell_contents) for cell in function.__closure__ or ()])
    name = f"{cache._impl.filename_base}-{digest(enclosed).hex()[:12]}"
    # numba does not see that a helper in another file has changed, so the stamp has a hash of all
    stamp = *cache._impl.locator.get_source_stamp(), _engine_version()
    cache._cache_file = KernelCacheFile(cache._cache_path, name, stamp)
    cache._index_key = lambda signature, codegen: (signature, codegen.magic_tuple())
    return dispatcher


def _identity(enclosed):
    """What tells a value that a kernel encloses from others, in every process."""
    function = getattr(enclosed, "py_func", None)
    if function is None:
        return enclosed
    return function.__module__, function.__qualname__, inspect.getsource(function)


def inlined(function):
    """Compile a helper that is always inlined into the kernel that calls it; it makes no arrays."""
    dispatcher = numba.njit(error_model="numpy", forceinline=True)(function)
    # nor can Python call it: half of the compile time would go into the code for that
    dispatcher.targetoptions.update(_nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True)
    return dispatcher


@intrinsic
def separate_arrays(typing_context):
    """Declare that no two arrays given to the calling kernel overlap, and ask for full vectors.

    LLVM checks overlaps at run time only for a handful of arrays and otherwise gives up. It also
    prefers 256-bit vectors on processors with AVX-512, where 512 bits are up to twice as fast.
    """

    def generate(context, builder, signature, arguments):
        for argument in builder.function.args:
            if isinstance(argument.type, ir.PointerType):
                argument.add_attribute("noalias")
        # llvmlite knows no string attributes; a set accepts the text as it must appear in the IR
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.void(), generate


def zeros(shape, dtype=np.float64) -> np.ndarray:
    """np.zeros that starts on a cache line, so that no vector lies across two of them."""
    shape = (shape,) if isinstance(shape, int) else tuple(shape)
    size = math.prod(shape) * np.dtype(dtype).itemsize
    buffer = np.zeros(size + _LINE, dtype=np.uint8)
    start = -buffer.__array_interface__["data"][0] % _LINE
    return buffer[start : start + size].view(dtype).reshape(shape)


def aligned(values) -> np.ndarray:
    """A copy of an array that starts on a cache line."""
    values = np.asarray(values)
    copy = zeros(values.shape, values.dtype)
    copy[...] = values
    return copy


@inlined
def minimum(a, b):
    """The smaller one, lane by lane for vectors; the second where one of them is NaN."""
    return select(a < b, a, b)


@inlined
def maximum(a, b):
    """The greater one; as `minimum`."""
    return select(a > b, a, b)


# 1.5 * 2^52: adding it leaves the nearest integer in the low bits of the sum.
ROUNDING = 6755399441055744.0
LOG2_E = 1.4426950408889634

# (2^r - 1)/r on |r| <= 1/2, Chebyshev interpolation of degree 10; error of 1 + r*q below 2e-17.
_Q0 = 0.6931471805599453
_Q1 = 0.24022650695910097
_Q2 = 0.0555041086648216
_Q3 = 0.009618129107606888
_Q4 = 0.0013333558146416936
_Q5 = 0.0001540353044173605
_Q6 = 1.525273382983612e-05
_Q7 = 1.321544258792169e-06
_Q8 = 1.0178062445845774e-07
_Q9 = 7.072585949269223e-09
_Q10 = 4.4549605981865186e-10


@inlined
def exp2(x, rate):
    """2**(x rate), float64 or vector, x rate > -1000: within 2 units in the last place.

    Infinite or NaN where it is beyond the numbers, and NaN of NaN. Without branches; the polynomial
    is summed by halves, which keeps the chain of operations short.
    """
    shifted = fma(x, rate, ROUNDING)
    # both limits hold from 2^1024.5 on: exponent and mantissa are then those of NaN
    shifted = select(shifted < ROUNDING + 1024.0, shifted, ROUNDING + 1024.0)
    r = fma(x, rate, ROUNDING - shifted)
    r = select(r < 0.5, r, 0.5)
    r2 = r * r
    r4 = r2 * r2
    q0 = fma(fma(_Q3, r, _Q2), r2, fma(_Q1, r, _Q0))
    q4 = fma(fma(_Q7, r, _Q6), r2, fma(_Q5, r, _Q4))
    q8 = fma(_Q10, r2, fma(_Q9, r, _Q8))
    q = fma(fma(q8, r4, q4), r4, q0)
    mantissa = fma(q, r, 1.0)
    return from_bits(as_bits(mantissa) + (as_bits(shifted) << 52))

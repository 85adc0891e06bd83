"""What the kernels need to become wide vector code.

The kernels advance many chains in lock step; their innermost loop runs over chains ("lanes") and
must compile to vector instructions. Three things stand in the way in plain numba, and this module
removes them: arrays that might overlap, half-width vectors, and library calls (exp) per element.
Every function here rounds the same way in vector and scalar code, so results do not depend on the
number of lanes.
"""

import numba
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

_DOUBLE = ir.DoubleType()
_INT64 = ir.IntType(64)


def kernel(function):
    """Compile a kernel that is called from Python: cached, without the GIL, IEEE division."""
    return numba.njit(cache=True, nogil=True, error_model="numpy")(function)


def inlined(function):
    """Compile a helper that is always inlined into the kernel that calls it."""
    return numba.njit(error_model="numpy", forceinline=True)(function)


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


@intrinsic
def fma(typing_context, a, b, c):
    """a*b + c with one rounding (float64), the same on every path of the compiled code."""

    def generate(context, builder, signature, arguments):
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), generate


@intrinsic
def copysign(typing_context, magnitude, sign):
    """|magnitude| with the sign of the second argument (float64), inline in vector code."""

    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(_DOUBLE, [_DOUBLE, _DOUBLE])
        call = builder.module.declare_intrinsic("llvm.copysign", [_DOUBLE], kind)
        return builder.call(call, arguments)

    return types.float64(types.float64, types.float64), generate


@intrinsic
def as_bits(typing_context, value):
    """The 64 bits of a float64 as int64."""

    def generate(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], _INT64)

    return types.int64(types.float64), generate


@intrinsic
def from_bits(typing_context, bits):
    """The float64 with the given 64 bits (int64)."""

    def generate(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], _DOUBLE)

    return types.float64(types.int64), generate


# 1.5 * 2^52: adding it leaves the nearest integer in the low bits of the sum.
_ROUNDING = 6755399441055744.0
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
def exp2(x):
    """2**x for |x| < 1000, within 2 units in the last place, without branches or calls."""
    shifted = x + _ROUNDING
    r = x - (shifted - _ROUNDING)
    q = fma(_Q10, r, _Q9)
    q = fma(q, r, _Q8)
    q = fma(q, r, _Q7)
    q = fma(q, r, _Q6)
    q = fma(q, r, _Q5)
    q = fma(q, r, _Q4)
    q = fma(q, r, _Q3)
    q = fma(q, r, _Q2)
    q = fma(q, r, _Q1)
    q = fma(q, r, _Q0)
    mantissa = fma(q, r, 1.0)
    return from_bits(as_bits(mantissa) + (as_bits(shifted) << 52))

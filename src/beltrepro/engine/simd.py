"""Vectors of eight or sixteen chains as values inside kernels.

`float64x8`, `int64x8` and `mask8` are numba types that compile to one vector register (or to two or
four on processors with narrower ones), those of sixteen to two: with every operation done on
two registers in turn, the processor has work while it waits for a result. They take the usual
operators, and scalars spread over all lanes, so a kernel reads like the formula for one chain.
Operations round lane by lane as IEEE arithmetic does: what a chain does cannot depend on its
neighbours.
"""

import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.core.typing import signature
from numba.core.typing.templates import ConcreteTemplate, infer_global
from numba.extending import intrinsic, models, register_model

LANES = 8
WIDE_LANES = 16


class _VectorType(types.Type):
    """Eight or sixteen values of one scalar type."""

    def __init__(self, scalar, element, lanes):
        self.element = element
        self.lanes = lanes
        super().__init__(name=f"{scalar}x{lanes}")


_DOUBLE, _INT64, _BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
_FLOATS, _INTEGERS, _MASKS = (
    {lanes: _VectorType(scalar, element, lanes) for lanes in (LANES, WIDE_LANES)}
    for scalar, element in (("float64", _DOUBLE), ("int64", _INT64), ("mask", _BIT))
)
float64x8, int64x8, mask8 = _FLOATS[LANES], _INTEGERS[LANES], _MASKS[LANES]


def _llvm(vector):
    return ir.VectorType(vector.element, vector.lanes)


def _is_float(kind):
    return isinstance(kind, _VectorType) and kind.element is _DOUBLE


def _is_integer(kind):
    return isinstance(kind, _VectorType) and kind.element is _INT64


@register_model(_VectorType)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager, fe_type):
        super().__init__(manager, fe_type, _llvm(fe_type))


# --- spreading scalars ---


def _spread(builder, scalar, vector):
    """A scalar in all lanes."""
    kind = _llvm(vector)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), scalar, ir.IntType(32)(0))
    return builder.shuffle_vector(
        first,
        ir.Constant(kind, ir.Undefined),
        ir.Constant(ir.VectorType(ir.IntType(32), vector.lanes), [0] * vector.lanes),
    )


def _as_vector(context, builder, value, kind, vector):
    if isinstance(kind, _VectorType):
        return value
    scalar = types.float64 if _is_float(vector) else types.int64
    return _spread(builder, context.cast(builder, value, kind, scalar), vector)


# --- operators ---


def _define(function, arguments, result, generate):
    """One more meaning of an operator: `generate(builder, *vectors)` for these argument types."""

    @infer_global(function)
    class Template(ConcreteTemplate):
        cases = (signature(result, *arguments),)

    vector = next(kind for kind in arguments if isinstance(kind, _VectorType))

    @lower_builtin(function, *arguments)
    def lower(context, builder, sig, values):
        spread = [
            _as_vector(context, builder, value, kind, vector)
            for value, kind in zip(values, sig.args, strict=True)
        ]
        return generate(builder, *spread)


def _define_binary(function, vector, scalar, result, generate):
    for pair in ((vector, vector), (vector, scalar), (scalar, vector)):
        _define(function, pair, result, generate)


def _method(name, *first):
    return lambda builder, *values: getattr(builder, name)(*first, *values)


def _define_operators(double, integer, mask):
    for function, name in (
        (operator.add, "fadd"),
        (operator.sub, "fsub"),
        (operator.mul, "fmul"),
        (operator.truediv, "fdiv"),
    ):
        _define_binary(function, double, types.float64, double, _method(name))
    for function, sign in (
        (operator.lt, "<"),
        (operator.le, "<="),
        (operator.gt, ">"),
        (operator.ge, ">="),
        (operator.eq, "=="),
    ):
        _define_binary(function, double, types.float64, mask, _method("fcmp_ordered", sign))
        _define_binary(function, integer, types.int64, mask, _method("icmp_signed", sign))
    _define_binary(operator.ne, double, types.float64, mask, _method("fcmp_unordered", "!="))
    _define_binary(operator.ne, integer, types.int64, mask, _method("icmp_signed", "!="))
    for function, name in (
        (operator.add, "add"),
        (operator.sub, "sub"),
        (operator.and_, "and_"),
        (operator.or_, "or_"),
        (operator.xor, "xor"),
        (operator.lshift, "shl"),
        (operator.rshift, "ashr"),
    ):
        _define_binary(function, integer, types.int64, integer, _method(name))
    for function, name in (
        (operator.and_, "and_"),
        (operator.or_, "or_"),
        (operator.xor, "xor"),
    ):
        _define(function, (mask, mask), mask, _method(name))
    _define(operator.neg, (double,), double, _method("fneg"))
    _define(operator.invert, (mask,), mask, _method("not_"))
    _define(abs, (double,), double, lambda builder, x: _call(builder, "fabs", [x]))


def _call(builder, name, values):
    """Call of an LLVM intrinsic on vectors or scalars of doubles, all of one type."""
    kind = values[0].type
    suffix = f"v{kind.count}f64" if isinstance(kind, ir.VectorType) else "f64"
    callee = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(kind, [kind] * len(values)), f"llvm.{name}.{suffix}"
    )
    return builder.call(callee, values)


for _lanes in (LANES, WIDE_LANES):
    _define_operators(_FLOATS[_lanes], _INTEGERS[_lanes], _MASKS[_lanes])


def _floating(name, n_arguments):
    """Intrinsic on floats or vectors of them, scalars spread where vectors are among them."""

    def generic(typing_context, *arguments):
        result = next(filter(_is_float, arguments), types.float64)

        def generate(context, builder, sig, values):
            if _is_float(result):
                values = [
                    _as_vector(context, builder, value, kind, result)
                    for value, kind in zip(values, sig.args, strict=True)
                ]
            else:
                values = [
                    context.cast(builder, value, kind, types.float64)
                    for value, kind in zip(values, sig.args, strict=True)
                ]
            return _call(builder, name, values)

        return signature(result, *arguments), generate

    generic.__name__ = name
    one = {
        1: lambda typing_context, a: generic(typing_context, a),
        2: lambda typing_context, a, b: generic(typing_context, a, b),
        3: lambda typing_context, a, b, c: generic(typing_context, a, b, c),
    }[n_arguments]
    one.__name__ = name
    return intrinsic(one)


fma = _floating("fma", 3)  # a*b + c with one rounding
copysign = _floating("copysign", 2)
square_root = _floating("sqrt", 1)


def _floating_choice(name, sign):
    """Intrinsic that gives one of two vectors, the second where one of them is NaN."""

    def generic(typing_context, a, b):
        vector = next(filter(_is_float, (a, b)))

        def generate(context, builder, sig, values):
            a, b = (
                _as_vector(context, builder, value, kind, vector)
                for value, kind in zip(values, sig.args, strict=True)
            )
            return builder.select(builder.fcmp_ordered(sign, a, b), a, b)

        return vector(a, b), generate

    generic.__name__ = name
    return intrinsic(generic)


minimum = _floating_choice("minimum", "<")
maximum = _floating_choice("maximum", ">")


# --- lanes, masks, bits ---


@intrinsic
def spread(typing_context, value):
    """A scalar in all lanes: float64 or int64 to the vector type of the same kind."""
    vector = float64x8 if isinstance(value, types.Float) else int64x8

    def generate(context, builder, sig, values):
        return _as_vector(context, builder, values[0], sig.args[0], vector)

    return vector(value), generate


@intrinsic
def select(typing_context, mask, chosen, otherwise):
    """`chosen` where the mask is set, else `otherwise`; by lanes, or for one bool and scalars."""
    vectors = [kind for kind in (chosen, otherwise) if isinstance(kind, _VectorType)]
    if isinstance(mask, _VectorType):
        vector = vectors[0] if vectors else _FLOATS[mask.lanes]

        def spread_values(context, builder, value, kind):
            return _as_vector(context, builder, value, kind, vector)

    else:
        vector = chosen

        def spread_values(context, builder, value, kind):
            return context.cast(builder, value, kind, vector)

    def generate(context, builder, sig, values):
        a, b = (
            spread_values(context, builder, value, kind)
            for value, kind in zip(values[1:], sig.args[1:], strict=True)
        )
        condition = values[0] if isinstance(mask, _VectorType) else builder.trunc(values[0], _BIT)
        return builder.select(condition, a, b)

    return vector(mask, chosen, otherwise), generate


@intrinsic
def lane_numbers(typing_context):
    """0 to 7, as int64x8."""

    def generate(context, builder, sig, values):
        return ir.Constant(_llvm(int64x8), list(range(LANES)))

    return int64x8(), generate


@intrinsic
def extract(typing_context, value, lane):
    """One lane of a vector, by its number."""
    result = types.float64 if _is_float(value) else types.int64

    def generate(context, builder, sig, values):
        number = context.cast(builder, values[1], sig.args[1], types.int64)
        return builder.extract_element(values[0], number)

    return result(value, lane), generate


@intrinsic
def mask_bits(typing_context, mask):
    """The lanes of a mask as the low bits of an int64; 0 if no lane is set."""

    def generate(context, builder, sig, values):
        return builder.zext(builder.bitcast(values[0], ir.IntType(mask.lanes)), _INT64)

    return types.int64(mask), generate


@intrinsic
def lowest_lane(typing_context, bits):
    """Number of the lowest bit that is set in an int64, as from `mask_bits`; not for 0."""

    def generate(context, builder, sig, values):
        return builder.cttz(values[0], _BIT(1))

    return types.int64(bits), generate


@intrinsic
def as_bits(typing_context, value):
    """The 64 bits of a float64 as int64, lane by lane for vectors."""
    result = _INTEGERS[value.lanes] if _is_float(value) else types.int64
    kind = _llvm(result) if _is_float(value) else _INT64

    def generate(context, builder, sig, values):
        return builder.bitcast(values[0], kind)

    return result(value), generate


@intrinsic
def from_bits(typing_context, bits):
    """The float64 with the given 64 bits (int64), lane by lane for vectors."""
    result = _FLOATS[bits.lanes] if _is_integer(bits) else types.float64
    kind = _llvm(result) if _is_integer(bits) else _DOUBLE

    def generate(context, builder, sig, values):
        return builder.bitcast(values[0], kind)

    return result(bits), generate


@intrinsic
def to_float(typing_context, value):
    """int64 to the nearest float64, lane by lane for vectors."""
    result = _FLOATS[value.lanes] if _is_integer(value) else types.float64
    kind = _llvm(result) if _is_integer(value) else _DOUBLE

    def generate(context, builder, sig, values):
        return builder.sitofp(values[0], kind)

    return result(value), generate


@intrinsic
def shift_right(typing_context, value, count):
    """Logical shift to the right of int64 or int64x8: zeros come in."""
    result = value if _is_integer(value) else types.int64

    def generate(context, builder, sig, values):
        if _is_integer(value):
            count = _as_vector(context, builder, values[1], sig.args[1], value)
        else:
            count = context.cast(builder, values[1], sig.args[1], types.int64)
        return builder.lshr(values[0], count)

    return result(value, count), generate


# --- memory ---


def _pointer(context, builder, array, value, indices, index_kinds):
    structure = context.make_array(array)(context, builder, value)
    numbers = cgutils.unpack_tuple(builder, indices)
    numbers = [
        context.cast(builder, number, kind, types.intp)
        for number, kind in zip(numbers, index_kinds, strict=True)
    ]
    return cgutils.get_item_pointer(
        context, builder, array, structure, numbers, wraparound=False, boundscheck=False
    )


def _vector_of(array, lanes):
    return (_FLOATS if array.dtype is types.float64 else _INTEGERS)[lanes]


def _loading(lanes):
    """Intrinsic that reads a vector from memory."""

    def load(typing_context, array, indices):
        vector = _vector_of(array, lanes)

        def generate(context, builder, sig, values):
            kind, index_kinds = sig.args[0], sig.args[1].types
            pointer = _pointer(context, builder, kind, values[0], values[1], index_kinds)
            return builder.load(
                builder.bitcast(pointer, _llvm(vector).as_pointer()), align=8, typ=_llvm(vector)
            )

        return vector(array, indices), generate

    return intrinsic(load)


# neighbours of a C-contiguous float64, int64 or uint64 array from the given indices on
load = _loading(LANES)
load_wide = _loading(WIDE_LANES)


@intrinsic
def store(typing_context, array, indices, value):
    """Write neighbours of a C-contiguous array from `indices` on; eight for a scalar value."""
    vector = value if isinstance(value, _VectorType) else _vector_of(array, LANES)

    def generate(context, builder, sig, values):
        kind, index_kinds = sig.args[0], sig.args[1].types
        pointer = _pointer(context, builder, kind, values[0], values[1], index_kinds)
        content = _as_vector(context, builder, values[2], sig.args[2], vector)
        builder.store(content, builder.bitcast(pointer, _llvm(vector).as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(array, indices, value), generate


@intrinsic
def store_where(typing_context, array, indices, value, mask):
    """Write the lanes of a mask to neighbours of a C-contiguous float64 array from `indices` on."""

    def generate(context, builder, sig, values):
        kind, index_kinds = sig.args[0], sig.args[1].types
        pointer = _pointer(context, builder, kind, values[0], values[1], index_kinds)
        vector = _llvm(value)
        callee = cgutils.get_or_insert_function(
            builder.module,
            ir.FunctionType(
                ir.VoidType(),
                [vector, vector.as_pointer(), ir.IntType(32), ir.VectorType(_BIT, LANES)],
            ),
            "llvm.masked.store.v8f64.p0",
        )
        place = builder.bitcast(pointer, vector.as_pointer())
        builder.call(callee, [values[2], place, ir.IntType(32)(8), values[3]])
        return context.get_dummy_value()

    return types.void(array, indices, value, mask), generate

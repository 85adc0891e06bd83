"""Vectors of eight chains as values inside kernels.

`float64x8`, `int64x8` and masks of eight compile to one vector register, or to narrower ones. They
take the usual operators, and scalars spread over all lanes, so a kernel reads like the formula for
one chain. Operations round lane by lane as IEEE arithmetic does: no chain depends on its
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


class _VectorType(types.Type):
    """Eight values of one scalar type."""

    def __init__(self, name, scalar, element):
        self.scalar = scalar
        self.llvm = ir.VectorType(element, LANES)
        super().__init__(name=f"{name}x{LANES}")


_INT64, _BIT = ir.IntType(64), ir.IntType(1)
float64x8 = _VectorType("float64", types.float64, ir.DoubleType())
int64x8 = _VectorType("int64", types.int64, _INT64)
_mask8 = _VectorType("mask", types.boolean, _BIT)


@register_model(_VectorType)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager, fe_type):
        super().__init__(manager, fe_type, fe_type.llvm)


# --- spreading scalars ---


def _as_vector(context, builder, value, kind, vector):
    """A value in all lanes, if it is none yet; or as the scalar that is asked for."""
    if isinstance(kind, _VectorType):
        return value
    if not isinstance(vector, _VectorType):
        return context.cast(builder, value, kind, vector)
    scalar = context.cast(builder, value, kind, vector.scalar)
    undefined = ir.Constant(vector.llvm, ir.Undefined)
    first = builder.insert_element(undefined, scalar, ir.IntType(32)(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(first, undefined, zeros)


def _as_vectors(context, builder, values, kinds, vector):
    return [
        _as_vector(context, builder, value, kind, vector)
        for value, kind in zip(values, kinds, strict=True)
    ]


# --- operators ---


def _define(function, arguments, result, generate):
    """One more meaning of an operator: `generate(builder, *vectors)` for these argument types."""

    @infer_global(function)
    class Template(ConcreteTemplate):
        cases = (signature(result, *arguments),)

    vector = next(kind for kind in arguments if isinstance(kind, _VectorType))

    @lower_builtin(function, *arguments)
    def lower(context, builder, sig, values):
        return generate(builder, *_as_vectors(context, builder, values, sig.args, vector))


def _define_binary(function, vector, result, generate):
    for pair in ((vector, vector), (vector, vector.scalar), (vector.scalar, vector)):
        _define(function, pair, result, generate)


def _method(name, *first):
    return lambda builder, *values: getattr(builder, name)(*first, *values)


def _define_operators():
    comparisons = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
    for sign, function in (comparisons | {"==": operator.eq}).items():
        _define_binary(function, float64x8, _mask8, _method("fcmp_ordered", sign))
        _define_binary(function, int64x8, _mask8, _method("icmp_signed", sign))
    _define_binary(operator.ne, float64x8, _mask8, _method("fcmp_unordered", "!="))
    _define_binary(operator.ne, int64x8, _mask8, _method("icmp_signed", "!="))
    bitwise = {operator.and_: "and_", operator.or_: "or_", operator.xor: "xor"}
    arithmetic = {operator.add: "add", operator.sub: "sub", operator.mul: "mul"}
    shifts = {operator.lshift: "shl", operator.rshift: "ashr"}
    for function, name in (arithmetic | {operator.truediv: "div"}).items():
        _define_binary(function, float64x8, float64x8, _method(f"f{name}"))
    for function, name in (arithmetic | bitwise | shifts).items():
        _define_binary(function, int64x8, int64x8, _method(name))
    for function, name in bitwise.items():
        _define(function, (_mask8, _mask8), _mask8, _method(name))
    _define(operator.neg, (float64x8,), float64x8, _method("fneg"))
    _define(operator.invert, (_mask8,), _mask8, _method("not_"))
    _define(abs, (float64x8,), float64x8, lambda builder, x: _call(builder, "fabs", [x]))


def _call(builder, name, values):
    """Call of an LLVM intrinsic on vectors or scalars of doubles, all of one type."""
    kind = values[0].type
    suffix = f"v{kind.count}f64" if isinstance(kind, ir.VectorType) else "f64"
    callee = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(kind, [kind] * len(values)), f"llvm.{name}.{suffix}"
    )
    return builder.call(callee, values)


_define_operators()


def _floating(name, n_arguments):
    """Intrinsic on floats or vectors of them, scalars spread where vectors are among them."""

    def generic(typing_context, *arguments):
        vectors = (kind for kind in arguments if isinstance(kind, _VectorType))
        result = next(vectors, types.float64)

        def generate(context, builder, sig, values):
            return _call(builder, name, _as_vectors(context, builder, values, sig.args, result))

        return signature(result, *arguments), generate

    # numba takes variadic ones for a tuple
    definition = {
        1: lambda typing_context, a: generic(typing_context, a),
        2: lambda typing_context, a, b: generic(typing_context, a, b),
        3: lambda typing_context, a, b, c: generic(typing_context, a, b, c),
    }[n_arguments]
    definition.__name__ = name
    return intrinsic(definition)


fma = _floating("fma", 3)  # a*b + c with one rounding
copysign = _floating("copysign", 2)
square_root = _floating("sqrt", 1)


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
    vector = chosen
    if isinstance(mask, _VectorType):
        vectors = [kind for kind in (chosen, otherwise) if isinstance(kind, _VectorType)]
        vector = vectors[0] if vectors else float64x8

    def generate(context, builder, sig, values):
        a, b = _as_vectors(context, builder, values[1:], sig.args[1:], vector)
        condition = values[0] if isinstance(mask, _VectorType) else builder.trunc(values[0], _BIT)
        return builder.select(condition, a, b)

    return vector(mask, chosen, otherwise), generate


@intrinsic
def lane_numbers(typing_context):
    """0 to 7, as int64x8."""

    def generate(context, builder, sig, values):
        return ir.Constant(int64x8.llvm, list(range(LANES)))

    return int64x8(), generate


@intrinsic
def extract(typing_context, value, lane):
    """One lane of a vector, by its number."""

    def generate(context, builder, sig, values):
        number = context.cast(builder, values[1], sig.args[1], types.int64)
        return builder.extract_element(values[0], number)

    return value.scalar(value, lane), generate


@intrinsic
def mask_bits(typing_context, mask):
    """The lanes of a mask as the low bits of an int64; 0 if no lane is set."""

    def generate(context, builder, sig, values):
        return builder.zext(builder.bitcast(values[0], ir.IntType(LANES)), _INT64)

    return types.int64(mask), generate


@intrinsic
def lowest_lane(typing_context, bits):
    """Number of the lowest bit that is set in an int64, as from `mask_bits`; not for 0."""

    def generate(context, builder, sig, values):
        return builder.cttz(values[0], _BIT(1))

    return types.int64(bits), generate


def _converting(method, vector):
    """Intrinsic that makes values of another type, lane by lane for vectors."""

    def generic(typing_context, value):
        result = vector if isinstance(value, _VectorType) else vector.scalar
        kind = vector.llvm if isinstance(value, _VectorType) else vector.llvm.element

        def generate(context, builder, sig, values):
            return getattr(builder, method)(values[0], kind)

        return result(value), generate

    return intrinsic(generic)


as_bits = _converting("bitcast", int64x8)  # the 64 bits of a float64
from_bits = _converting("bitcast", float64x8)  # and back
to_float = _converting("sitofp", float64x8)  # int64 to the nearest float64


@intrinsic
def shift_right(typing_context, value, count):
    """Logical shift to the right of int64 or int64x8: zeros come in."""
    result = value if isinstance(value, _VectorType) else types.int64

    def generate(context, builder, sig, values):
        count = _as_vector(context, builder, values[1], sig.args[1], result)
        return builder.lshr(values[0], count)

    return result(value, count), generate


# --- memory ---


def _pointer(context, builder, sig, values, vector):
    """Pointer to a vector in an array: the first two of the values are the array and indices."""
    array, indices = sig.args[:2]
    structure = context.make_array(array)(context, builder, values[0])
    numbers = [
        context.cast(builder, number, kind, types.intp)
        for number, kind in zip(cgutils.unpack_tuple(builder, values[1]), indices, strict=True)
    ]
    place = cgutils.get_item_pointer(
        context, builder, array, structure, numbers, wraparound=False, boundscheck=False
    )
    return builder.bitcast(place, vector.llvm.as_pointer())


def _vector_of(array):
    return float64x8 if array.dtype is types.float64 else int64x8


@intrinsic
def load(typing_context, array, indices):
    """Eight neighbours of a C-contiguous float64, int64 or uint64 array from `indices` on."""
    vector = _vector_of(array)

    def generate(context, builder, sig, values):
        pointer = _pointer(context, builder, sig, values, vector)
        return builder.load(pointer, align=8, typ=vector.llvm)

    return vector(array, indices), generate


@intrinsic
def store(typing_context, array, indices, value):
    """Write eight neighbours of a C-contiguous array from `indices` on."""
    vector = value if isinstance(value, _VectorType) else _vector_of(array)

    def generate(context, builder, sig, values):
        content = _as_vector(context, builder, values[2], sig.args[2], vector)
        builder.store(content, _pointer(context, builder, sig, values, vector), align=8)
        return context.get_dummy_value()

    return types.void(array, indices, value), generate


@intrinsic
def store_where(typing_context, array, indices, value, mask):
    """Write the lanes of a mask to neighbours of a C-contiguous float64 array from `indices` on."""

    def generate(context, builder, sig, values):
        pointer = _pointer(context, builder, sig, values, value)
        alignment = ir.IntType(32)(8)
        kinds = [value.llvm, pointer.type, alignment.type, mask.llvm]
        callee = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(ir.VoidType(), kinds), "llvm.masked.store.v8f64.p0"
        )
        builder.call(callee, [values[2], pointer, alignment, values[3]])
        return context.get_dummy_value()

    return types.void(array, indices, value, mask), generate

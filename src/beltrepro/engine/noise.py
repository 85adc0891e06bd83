"""Random numbers for many chains at once: one independent stream of normal deviates a chain.

A stream is keyed by the physics of its chain (seed, N, u, sigma, constants, replicate) through
NumPy's SeedSequence and advanced by xoshiro256++ (Blackman and Vigna, ACM TOMS 47, 36, 2021).
Normal deviates come from the Box-Muller transform with polynomial logarithm, sine and cosine
(absolute error below 1e-8). The functions take one lane or a vector of them.
"""

import hashlib
from collections.abc import Sequence

import numpy as np

from beltrepro.engine.simd import (
    LANES,
    as_bits,
    fma,
    from_bits,
    lane_numbers,
    load,
    select,
    shift_right,
    square_root,
    store,
    to_float,
)
from beltrepro.engine.vector import ROUNDING, inlined, kernel, separate_arrays
from beltrepro.model import ChainParameters

STATE_WORDS = 4


def stream_key(parameters: ChainParameters, seed: int, replicate: int, purpose: int = 0):
    """SeedSequence of one chain: the same physics, seed and replicate give the same numbers."""
    return np.random.SeedSequence(_keys([parameters], [seed], [replicate], purpose)[0].tolist())


def stream_states(chains: Sequence[ChainParameters], seeds, replicates, purpose=0) -> np.ndarray:
    """Initial states (4, W) uint64 of the streams of W chains: the words of their `stream_key`."""
    # by its halves, low ones first: SeedSequence drops a high one that is zero
    halves = _keys(chains, seeds, replicates, purpose).astype("<u8").view("<u4")
    kept = (halves != 0) | (np.arange(halves.shape[1]) % 2 == 0)
    sequences = (np.random.SeedSequence(row[used]) for row, used in zip(halves, kept, strict=True))
    states = [sequence.generate_state(STATE_WORDS, np.uint64) for sequence in sequences]
    return np.ascontiguousarray(np.transpose(states))


def _keys(chains, seeds, replicates, purpose) -> np.ndarray:
    """What the streams of W chains are keyed by (W, K)."""
    # by physics, never by order: a point has the same numbers in any company
    keys = np.empty((len(chains), 12), dtype=np.uint64)
    keys[:, 0], keys[:, 2], keys[:, 3] = seeds, np.fromiter(replicates, np.uint64), purpose
    keys[:, 1] = [chain.n_blocks for chain in chains]
    reals = np.array([(chain.belt_velocity, chain.noise, *_law_key(chain)) for chain in chains])
    keys[:, 4:] = (reals + 0.0).view(np.uint64)  # -0.0 + 0.0 is 0.0, which has other bits
    return keys


def _law_key(chain: ChainParameters) -> tuple[float, ...]:
    """Six numbers that stand for a law: those of the paper's, or a digest of any other."""
    if not chain.varied:
        return chain.law[:6]
    digest = hashlib.sha256(repr(chain.law).encode()).digest()
    return tuple(np.frombuffer(digest[:24], dtype="<u4").astype(float))


# ln(1+s)/s for 1+s between sqrt(1/2) and sqrt(2), Chebyshev interpolation, error 6e-9.
_L0 = 0.999999999383255
_L1 = -0.49999988496142866
_L2 = 0.33333345349807464
_L3 = -0.2500157909915946
_L4 = 0.20000939440373094
_L5 = -0.16608369414088409
_L6 = 0.14199650097916022
_L7 = -0.1326603136091708
_L8 = 0.12806610435006952
_L9 = -0.07451186226757509
# sin(2 pi f)/f and cos(2 pi f) as polynomials of f^2 for |f| <= 1/8, error 5e-11.
_S0 = 6.2831853071524
_S1 = -41.341702153394905
_S2 = 81.60520471104576
_S3 = -76.6978663502028
_S4 = 41.47283323950919
_C0 = 0.9999999999524894
_C1 = -19.739208650130596
_C2 = 64.93931613570905
_C3 = -85.44284467308167
_C4 = 59.2201689582961

_LN2 = 0.6931471805599453
_ONE_BITS = 0x3FF0000000000000
_SQRT_HALF_BITS = 0x3FE6A09E667F3BCD
_SIGN = np.int64(-(1 << 63))


@inlined
def logarithm(x):
    """ln(x) of a float64 or float64x8 > 0, absolute error below 1e-8."""
    bits = as_bits(x)
    exponent = (bits - _SQRT_HALF_BITS) >> 52
    s = from_bits(bits - (exponent << 52)) - 1.0
    p = fma(_L9, s, _L8)
    p = fma(p, s, _L7)
    p = fma(p, s, _L6)
    p = fma(p, s, _L5)
    p = fma(p, s, _L4)
    p = fma(p, s, _L3)
    p = fma(p, s, _L2)
    p = fma(p, s, _L1)
    p = fma(p, s, _L0)
    return fma(p, s, to_float(exponent) * _LN2)


@inlined
def _uniform_pair(bits):
    """Two uniform deviates from 64 random bits: radius in (0, 1] from the high 52, angle in [0, 1).

    The angle takes the low 36 bits. The 24 it shares with the radius weigh 2^-29 and less there,
    which moves a deviate by more than its rounding only beyond 6 standard deviations.
    """
    radius = 2.0 - from_bits(shift_right(bits, 12) | _ONE_BITS)
    angle = from_bits(shift_right(bits << 28, 12) | _ONE_BITS)
    return radius, angle - 1.0


@inlined
def _next(s0, s1, s2, s3):
    """One step of xoshiro256++: the word and the four words of the new state."""
    total = s0 + s3
    word = ((total << 23) | shift_right(total, 41)) + s0
    shifted = s1 << 17
    s2 = s2 ^ s0
    s3 = s3 ^ s1
    s1 = s1 ^ s2
    s0 = s0 ^ s3
    s2 = s2 ^ shifted
    return word, s0, s1, s2, (s3 << 45) | shift_right(s3, 19)


@inlined
def _box_muller(word):
    radius, angle = _uniform_pair(word)
    length = square_root(-2.0 * logarithm(radius))
    # four quadrants around the nearest multiple of a quarter turn, f in [-1/8, 1/8]
    shifted = fma(angle, 4.0, ROUNDING)
    quadrant = as_bits(shifted)
    f = fma(ROUNDING - shifted, 0.25, angle)
    f2 = f * f
    sine = fma(fma(fma(fma(_S4, f2, _S3), f2, _S2), f2, _S1), f2, _S0) * f
    cosine = fma(fma(fma(fma(_C4, f2, _C3), f2, _C2), f2, _C1), f2, _C0)
    swapped = (quadrant & 1) != 0
    a = select(swapped, sine, cosine)
    b = select(swapped, cosine, sine)
    # bit 1 of the number of the quadrant becomes the sign bit
    a = from_bits(as_bits(length * a) ^ (((quadrant + 1) << 62) & _SIGN))
    b = from_bits(as_bits(length * b) ^ ((quadrant << 62) & _SIGN))
    return a, b


@inlined
def normal_pairs_where(states, lane, mask):
    """Two standard normal deviates for each of the eight chains from a lane on.

    Streams of chains outside the mask stay where they are: no chain draws for another.
    """
    o0, o1, o2, o3 = (
        load(states, (0, lane)),
        load(states, (1, lane)),
        load(states, (2, lane)),
        load(states, (3, lane)),
    )
    word, s0, s1, s2, s3 = _next(o0, o1, o2, o3)
    store(states, (0, lane), select(mask, s0, o0))
    store(states, (1, lane), select(mask, s1, o1))
    store(states, (2, lane), select(mask, s2, o2))
    store(states, (3, lane), select(mask, s3, o3))
    return _box_muller(word)


@inlined
def normal_pair(states, lane):
    """Two standard normal deviates of one chain."""
    word, s0, s1, s2, s3 = _next(
        np.int64(states[0, lane]),
        np.int64(states[1, lane]),
        np.int64(states[2, lane]),
        np.int64(states[3, lane]),
    )
    states[0, lane] = s0
    states[1, lane] = s1
    states[2, lane] = s2
    states[3, lane] = s3
    return _box_muller(word)


@kernel
def normal_deviates(states, normals):
    """Fill `normals` (R, W), R even, W a multiple of 8, from the streams `states` (4, W) uint64."""
    separate_arrays()
    everyone = lane_numbers() >= 0
    for lane in range(0, normals.shape[1], LANES):
        for row in range(0, normals.shape[0], 2):
            first, second = normal_pairs_where(states, lane, everyone)
            store(normals, (row, lane), first)
            store(normals, (row + 1, lane), second)

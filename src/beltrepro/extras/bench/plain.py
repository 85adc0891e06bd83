"""One chain by the scheme of the Appendix, as one would write it first: Numba, or C.

The integrators of this package are compared with it. It uses no vectors and no frame of the belt,
and branches where the paper has an "if". It measures only what the disorder parameter needs.
"""

import ctypes
import functools
import math
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np

from beltrepro.engine.noise import stream_key
from beltrepro.model import ChainParameters

# the paper's law, which naive_loop.c has as well
STATIC_FRICTION = ChainParameters.static_friction
FRICTION_RATIO = ChainParameters.friction_ratio
REST_LENGTH = ChainParameters.rest_length
LINEAR_LIMIT = ChainParameters.linear_limit
COMPRESSION_RATE = ChainParameters.compression_rate
EXTENSION_RATE = ChainParameters.extension_rate

POSITION, POSITION_BEFORE, VELOCITY, ACCELERATION_BEFORE, THRESHOLD, DIRECTION = range(6)
_HAS_SPARE, _SPARE, SUM, SUM_OF_SQUARES = range(4)

SOURCE = Path(__file__).with_name("naive_loop.c")
FLAGS = ("-O3", "-march=native")

_jit = numba.njit(cache=True, error_model="numpy")


class PlainChain:
    """One chain with the paper's law, in the laboratory frame, advanced by one of the two loops."""

    chains = 1

    def __init__(self, parameters: ChainParameters, loop: Callable, time_step: float = 0.001):
        self.parameters = parameters
        self.time_step = time_step
        self._loop = loop
        random = np.random.default_rng(stream_key(parameters, 1, 0))
        self.state = np.zeros((6, parameters.n_blocks))
        self.state[POSITION] = parameters.rest_positions
        self.state[POSITION_BEFORE] = self.state[POSITION] - parameters.belt_velocity * time_step
        self.state[VELOCITY] = parameters.belt_velocity
        self.state[THRESHOLD] = STATIC_FRICTION + parameters.noise * random.standard_normal(
            parameters.n_blocks
        )
        self._stream = random.integers(2**64, size=4, dtype=np.uint64)
        self.carry = np.zeros(4)

    def advance(self, span: float) -> None:
        """Advance by `span` of model time, rounded to steps."""
        chain, steps = self.parameters, round(span / self.time_step)
        law = chain.n_blocks, chain.belt_velocity, chain.noise
        self._loop(*law, self.time_step, steps, self.state, self._stream, self.carry)


def _compiler() -> str | None:
    return shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


@functools.cache
def compiler() -> str | None:
    """The C compiler found on the path, with its version; None if there is none."""
    if (program := _compiler()) is None:
        return None
    done = subprocess.run([program, "--version"], capture_output=True, text=True)
    return done.stdout.partition("\n")[0].strip() or None


@functools.cache
def c_loop(flags: tuple[str, ...] = FLAGS) -> Callable | None:
    """The loop in C, compiled now into a temporary folder; None without a compiler that can."""
    if (program := _compiler()) is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        library = str(Path(folder) / "naive_loop.so")
        call = [program, *flags, "-std=c99", "-shared", "-fPIC", "-o", library, str(SOURCE), "-lm"]
        try:
            subprocess.run(call, capture_output=True, check=True)
            function = ctypes.CDLL(library).advance_chain
        except (OSError, subprocess.CalledProcessError):
            return None
    function.restype = None
    function.argtypes = [
        ctypes.c_int64,
        *[ctypes.c_double] * 3,
        ctypes.c_int64,
        np.ctypeslib.ndpointer(np.float64, ndim=2, flags="C"),
        np.ctypeslib.ndpointer(np.uint64, shape=(4,), flags="C"),
        np.ctypeslib.ndpointer(np.float64, shape=(4,), flags="C"),
    ]
    return function


@_jit
def spring_force(deformation):
    """Force of a spring on the block behind it."""
    beyond = abs(deformation) - LINEAR_LIMIT
    if beyond <= 0.0:
        return -deformation
    rate = COMPRESSION_RATE if deformation < 0.0 else EXTENSION_RATE
    return -math.copysign(LINEAR_LIMIT + (math.exp(rate * beyond) - 1.0) / rate, deformation)


@_jit
def _rotate(word, count):
    return (word << np.uint64(count)) | (word >> np.uint64(64 - count))


@_jit
def _uniform(stream):
    word = _rotate(stream[0] + stream[3], 23) + stream[0]
    shifted = stream[1] << np.uint64(17)
    stream[2] ^= stream[0]
    stream[3] ^= stream[1]
    stream[1] ^= stream[2]
    stream[0] ^= stream[3]
    stream[2] ^= shifted
    stream[3] = _rotate(stream[3], 45)
    return (float(word >> np.uint64(11)) + 0.5) * 2.0**-53


@_jit
def _normal(stream, carry):
    if carry[_HAS_SPARE] != 0.0:
        carry[_HAS_SPARE] = 0.0
        return carry[_SPARE]
    while True:
        a = 2.0 * _uniform(stream) - 1.0
        b = 2.0 * _uniform(stream) - 1.0
        square = a * a + b * b
        if 0.0 < square < 1.0:
            break
    factor = math.sqrt(-2.0 * math.log(square) / square)
    carry[_HAS_SPARE] = 1.0
    carry[_SPARE] = b * factor
    return a * factor


@_jit
def numba_loop(n_blocks, belt_velocity, noise, time_step, n_steps, state, stream, carry):
    """Advance one chain by n_steps steps: `advance_chain` of naive_loop.c, line by line.

    state (6, N) : x, x one step before, v, a one step before, F_st, direction of slip; model units,
    laboratory frame. stream (4,) uint64 : random numbers. carry (4,) : a spare normal deviate, and
    the sums of x_N and of its square over the steps done.
    """
    x, before, v = state[0], state[1], state[2]
    a_before, threshold, direction = state[3], state[4], state[5]
    springs = np.zeros(n_blocks + 1)
    for _ in range(n_steps):
        for i in range(n_blocks):
            springs[i] = spring_force(x[i] - (x[i - 1] if i > 0 else 0.0) - REST_LENGTH)
        for i in range(n_blocks):
            force = springs[i] - springs[i + 1]
            if noise > 0.0 and direction[i] != 0.0:
                threshold[i] = STATIC_FRICTION + noise * _normal(stream, carry)
            free = math.copysign(1.0, force) if abs(force) > threshold[i] else 0.0
            if direction[i] * (v[i] - belt_velocity) <= 0.0 and free != direction[i]:
                if direction[i] == 0.0 or free == 0.0:
                    before[i] = x[i] - belt_velocity * time_step
                    a_before[i] = 0.0
                direction[i] = free
            if direction[i] == 0.0:
                after = x[i] + belt_velocity * time_step
                v[i] = belt_velocity
            else:
                a = force - direction[i] * FRICTION_RATIO * threshold[i]
                after = 2.0 * x[i] - before[i] + a * time_step * time_step
                v[i] = (x[i] - before[i]) / time_step + time_step / 6.0 * (
                    11.0 * a - 2.0 * a_before[i]
                )
                a_before[i] = a
            before[i] = x[i]
            x[i] = after
        carry[SUM] += x[n_blocks - 1]
        carry[SUM_OF_SQUARES] += x[n_blocks - 1] * x[n_blocks - 1]

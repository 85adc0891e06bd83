"""Integrators of Eq. 1 for many chains at once.

Integrators: `integrator` (what they have in common, and the chunks they yield), `state`,
`event_integrator`, `verlet_integrator`. Their kernels: `event`, `leaps` (both on Taylor series:
`taylor`, `candidates`); what follows a chain that `event` advances: `tangent`.
The laws in kernels: `law`, `noise`. What kernels record: `records`. Vectors: `simd`, `vector`.
"""

from beltrepro.base.errors import InputError

# before anything is compiled: what a shell may hand on
try:
    import numba
except ValueError as error:
    reason = str(error).rstrip(".")
    raise InputError(f"numba: {reason}; look at the variables NUMBA_... of the shell") from None
if numba.config.DISABLE_JIT:
    raise InputError("NUMBA_DISABLE_JIT = 1: integrators run as machine code only; unset it")

"""Integrators of Eq. 1 for many chains at once.

Integrators: `integrator` (what they have in common, and the chunks they yield), `state`,
`event_integrator`, `verlet_integrator`. Their kernels: `event`, `leaps` (both on Taylor series:
`taylor`, `candidates`); what follows a chain that `event` advances: `tangent`.
The laws in kernels: `law`, `noise`. What kernels record: `records`. Vectors: `simd`, `vector`.
"""

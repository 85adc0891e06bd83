"""Integrators of Eq. 1 for many chains at once.

Integrators: `integrator` (what they have in common, and the chunks they yield), `state`,
`series_integrator`, `event_integrator`, `verlet_integrators`. Their kernels: `event`, `leaps`
(both on Taylor series: `taylor`, `candidates`, `roots`), `verlet`, `scheme`. The laws in kernels:
`law`, `friction`, `noise`. What kernels record: `records`. Vectors: `simd`, `vector`, `memory`.
"""

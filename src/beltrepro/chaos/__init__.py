"""Whether the motion is chaotic: Lyapunov exponents, and names for motions (docs/chaos.md).

What is here uses the functions of `beltrepro.simulation` and judges what comes out of them by
`beltrepro.stats`. Simulations do not depend on it, so that a criterion can change without them.
"""

"""How accurate the integrator `event` is: what it computes with, and what others say about it."""

# Order of the Taylor series of the positions, odd; with noise less will do.
ORDER = 19
NOISY_ORDER = 13
# Last terms of the series of F_ex allowed at the end of a step: the last, and the one before it.
TOLERANCE = 1e-10
# The same with noise, as a share of sqrt(q): its impulse in a time h has deviation sqrt(q h).
NOISE_SHARE = 1e-2
# Longest cell of the noise, model time.
NOISE_CELL = 0.5
# Largest noise of the force with which a slip begins, over its mean: see docs/validity.md.
START_NOISE = 0.3

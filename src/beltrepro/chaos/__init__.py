"""Whether the motion is chaotic: Lyapunov exponents, and names for motions (docs/chaos.md).

What is here uses the functions of `beltrepro.simulation` and judges what comes out of them by
`beltrepro.analysis`. Simulations do not depend on it, so that a criterion can change without them.
"""

from beltrepro.chaos.lyapunov import LyapunovSpectrum, exponents, lyapunov_spectrum
from beltrepro.chaos.naming import Motion, classify, motions
from beltrepro.chaos.orbits import PeriodicOrbit, close_orbit, periodic_orbit
from beltrepro.chaos.parting import separation
from beltrepro.chaos.transients import settling

__all__ = [
    "LyapunovSpectrum",
    "Motion",
    "PeriodicOrbit",
    "classify",
    "close_orbit",
    "exponents",
    "lyapunov_spectrum",
    "motions",
    "periodic_orbit",
    "separation",
    "settling",
]

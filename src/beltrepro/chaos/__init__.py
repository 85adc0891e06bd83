"""Whether the motion is chaotic: Lyapunov exponents, and names for motions (docs/chaos.md).

What is here uses the functions of `beltrepro.simulation` and judges what comes out of them by
`beltrepro.stats`. Simulations do not depend on it, so that a criterion can change without them.
"""

from beltrepro.chaos.basins import Basins, basins
from beltrepro.chaos.continuation import OrbitBranch, orbit_branch
from beltrepro.chaos.irregular import time_to_orbit
from beltrepro.chaos.lyapunov import LyapunovSpectrum, lyapunov_spectrum
from beltrepro.chaos.naming import Motion, classify
from beltrepro.chaos.periodic_orbits import PeriodicOrbit, periodic_orbit

__all__ = [
    "Basins",
    "LyapunovSpectrum",
    "Motion",
    "OrbitBranch",
    "PeriodicOrbit",
    "basins",
    "classify",
    "lyapunov_spectrum",
    "orbit_branch",
    "periodic_orbit",
    "time_to_orbit",
]

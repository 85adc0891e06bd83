"""What `beltrepro` gives, for editors and mypy."""

from beltrepro.base.progress import Progress as Progress
from beltrepro.chaos.basins import Basins as Basins
from beltrepro.chaos.basins import basins as basins
from beltrepro.chaos.continuation import OrbitBranch as OrbitBranch
from beltrepro.chaos.continuation import orbit_branch as orbit_branch
from beltrepro.chaos.irregular import time_to_orbit as time_to_orbit
from beltrepro.chaos.lyapunov import LyapunovSpectrum as LyapunovSpectrum
from beltrepro.chaos.lyapunov import lyapunov_spectrum as lyapunov_spectrum
from beltrepro.chaos.margin import margin as margin
from beltrepro.chaos.naming import Motion as Motion
from beltrepro.chaos.naming import classify as classify
from beltrepro.chaos.periodic_orbits import PeriodicOrbit as PeriodicOrbit
from beltrepro.chaos.periodic_orbits import periodic_orbit as periodic_orbit
from beltrepro.engine.state import ChainState as ChainState
from beltrepro.model.energy import mode_energies as mode_energies
from beltrepro.model.energy import sliding_energy as sliding_energy
from beltrepro.model.parameters import ChainParameters as ChainParameters
from beltrepro.model.units import from_si as from_si
from beltrepro.model.units import to_si as to_si
from beltrepro.simulation.catalogues import Catalogue as Catalogue
from beltrepro.simulation.catalogues import catalogue as catalogue
from beltrepro.simulation.grid import Grid as Grid
from beltrepro.simulation.observables import PowerSpectrum as PowerSpectrum
from beltrepro.simulation.observables import SectionPoints as SectionPoints
from beltrepro.simulation.observables import avalanche_energies as avalanche_energies
from beltrepro.simulation.observables import section as section
from beltrepro.simulation.observables import slip_sizes as slip_sizes
from beltrepro.simulation.observables import spectrum as spectrum
from beltrepro.simulation.results import Results as Results
from beltrepro.simulation.run import Run as Run
from beltrepro.simulation.scans import scan as scan
from beltrepro.simulation.scans import time_to_continuous_slip as time_to_continuous_slip
from beltrepro.simulation.setup import Setup as Setup
from beltrepro.simulation.starts import slipping_state as slipping_state
from beltrepro.simulation.sweeps import sweep as sweep
from beltrepro.simulation.trajectories import simulate as simulate
from beltrepro.stats.densities import ChainValues as ChainValues
from beltrepro.stats.densities import Density as Density
from beltrepro.stats.densities import density as density
from beltrepro.stats.densities import power_law as power_law
from beltrepro.stats.estimates import Estimate as Estimate
from beltrepro.stats.power_law import PowerLaw as PowerLaw

__version__: str

"""The claims of all studies: importing these registers the functions that measure them."""

from beltrepro.replication.studies.avalanches import claims as avalanches
from beltrepro.replication.studies.chaos import claims as chaos
from beltrepro.replication.studies.experiment import claims as experiment
from beltrepro.replication.studies.fall import claims as fall
from beltrepro.replication.studies.integrators import claims as integrators
from beltrepro.replication.studies.laws import claims as laws
from beltrepro.replication.studies.noise import claims as noise
from beltrepro.replication.studies.sizes import claims as sizes
from beltrepro.replication.studies.transition import claims as transition
from beltrepro.replication.verdicts.measured import measure

STUDIES = (avalanches, chaos, experiment, fall, integrators, laws, noise, sizes, transition)
__all__ = ["STUDIES", "measure"]

"""The physics of Sec. III: parameters, units, spring law, friction law, Poincare section."""

from beltrepro.model.parameters import ChainParameters
from beltrepro.model.section import section_position

__all__ = ["ChainParameters", "section_position"]

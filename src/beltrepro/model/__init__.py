"""The physics of Sec. III: parameters, units, spring law, friction law, energy."""

from beltrepro.model.parameters import ChainParameters
from beltrepro.model.spring import section_position

__all__ = ["ChainParameters", "section_position"]

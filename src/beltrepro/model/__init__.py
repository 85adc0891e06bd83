"""The physics of Sec. III: parameters, units, spring law and friction law."""

from beltrepro.model.parameters import ChainParameters

__all__ = ["ChainParameters"]

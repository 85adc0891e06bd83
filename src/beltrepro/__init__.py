"""A replication of "Chaos on the conveyor belt"."""

from importlib.metadata import version

__version__ = version("beltrepro")

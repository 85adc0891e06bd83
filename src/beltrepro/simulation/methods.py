"""The numerical methods by name, and what accuracy each takes unless told otherwise."""

from inspect import signature

from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.verlet_integrators import verlet_integrator

METHODS = {"verlet": verlet_integrator, "event": EventIntegrator}
KICKED = "event"  # the method whose starts of slips can be kicked
# Tolerance of a step that a method takes unless told otherwise, for those that have one.
TOLERANCES: dict[str, float] = {
    name: signature(integrator).parameters["tolerance"].default
    for name, integrator in METHODS.items()
    if "tolerance" in signature(integrator).parameters
}
TOLERANCE_RANGE = (1e-16, 1.0)  # unit of force; forces are some tens, and rounding 1e-16 of them

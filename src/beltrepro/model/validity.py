"""Where the method "event" has the noise of the paper's scheme (docs/validity.md)."""

from beltrepro.model.accuracy import START_NOISE
from beltrepro.model.friction import start_noise
from beltrepro.model.parameters import ChainParameters


def noise_beyond_event(parameters: ChainParameters) -> str:
    """What is wrong with the noise of a chain that "event" is to integrate."""
    share = start_noise(parameters)
    if share <= START_NOISE:
        return ""
    return (
        f"= {parameters.noise:g}: with friction_ratio = {parameters.friction_ratio:g} and "
        f"static_friction = {parameters.static_friction:g}, method 'event' is checked up to "
        f"{parameters.noise * START_NOISE / share:.3g}; beyond that take 'verlet'"
    )

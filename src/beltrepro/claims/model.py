"""Claims on the model and its units (Sec. III)."""

import numpy as np

from beltrepro.analysis.errors import require
from beltrepro.claims.criteria import Measurement
from beltrepro.claims.evidence import last_block_events
from beltrepro.claims.registry import claim
from beltrepro.model import ChainParameters, spring, units

_STUCK = 1e-9


@claim("units")
def unit_system(evidence):
    """Time, velocity and force units from the three base units."""
    return Measurement(
        {
            "time_s": units.TIME_S,
            "velocity_m_s": units.VELOCITY_M_S,
            "force_N": units.FORCE_N,
        }
    )


@claim("friction-constants")
def friction_constants(evidence):
    """The measured friction forces in model units, and whether the runs used the printed ones."""
    used = evidence.settings["model"]
    paper = evidence.claim.paper
    return Measurement(
        {
            "static_friction": float(units.from_si(units.STATIC_FRICTION_N, "force")),
            "friction_ratio": units.KINETIC_FRICTION_N / units.STATIC_FRICTION_N,
        },
        checks={
            f"the runs used {name} = {value:g}": used[name] == value
            for name, value in paper.items()
        },
    )


@claim("spring-law")
def spring_law(evidence):
    """The printed spring law, tested on the function that the kernels are tested against."""
    chain = _chain(evidence)
    limit, tiny = chain.linear_limit, 1e-6
    inside = np.linspace(-limit, limit, 201)
    checks = {"linear inside": np.allclose(spring.spring_force(inside, chain), -inside)}
    for name, side, rate in (
        ("compressed", -1.0, chain.compression_rate),
        ("stretched", 1.0, chain.extension_rate),
    ):
        outside = side * (limit + np.linspace(1.0, 40.0, 40))
        growth = np.diff(np.log(_slope(outside, chain)))
        checks[f"exponential, {name}"] = np.allclose(growth, rate, rtol=1e-4)
        inner, join, outer = spring.spring_force(side * (limit + tiny * np.arange(-1, 2)), chain)
        checks[f"continuous, {name}"] = abs(outer - inner) < 3 * tiny
        checks[f"continuous slope, {name}"] = abs((outer - join) - (join - inner)) < 1e-6 * tiny
    return Measurement(checks={name: bool(passed) for name, passed in checks.items()})


@claim("friction-law")
def friction_law(evidence):
    """Statistics of the friction force while blocks are stuck and while they slip."""
    series = evidence.dataset("friction_event")
    chain = _chain(evidence, n_blocks=int(series.attributes["n_blocks"]))
    friction = series.arrays["friction"]
    relative = series.arrays["velocities"] - series.attributes["belt_velocity"]
    external = spring.external_force(series.arrays["positions"], chain)
    stuck = np.abs(relative) <= _STUCK
    inner = stuck[:-1] & stuck[1:]
    balance = np.abs(friction + external)[:-1][inner]
    slipping = ~stuck[:-1] & ~stuck[1:] & (np.sign(relative[:-1]) == np.sign(relative[1:]))
    require(slipping.sum() >= 1000 and inner.sum() >= 1000, "too few samples of stick and of slip")
    kinetic = np.abs(friction[:-1][slipping])
    following = np.abs(friction[1:][slipping])
    sigma = series.attributes["noise"] * chain.friction_ratio
    mean, target = kinetic.mean(), chain.friction_ratio * chain.static_friction
    error = kinetic.std() / np.sqrt(kinetic.size)
    memory = np.corrcoef(kinetic, following)[0, 1] if kinetic.std() > 0 else 1.0
    slips, _ = last_block_events(series)
    before = np.abs(slips["force"]).mean() if slips.size else chain.static_friction
    return Measurement(
        {
            "mean kinetic friction": mean,
            "standard deviation": kinetic.std(),
            "friction before slip": before,
        },
        {"mean kinetic friction": error},
        int(kinetic.size),
        checks={
            "stuck: friction cancels the external force": bool(
                np.quantile(balance, 0.99) < 0.01 * chain.static_friction
            ),
            "slip: mean is f_s*F_st0": bool(abs(mean - target) < 4 * error + 0.01 * target),
            "slip: fluctuates with f_s*sigma": bool(abs(kinetic.std() / sigma - 1) < 0.15),
            "slip: no memory between steps": bool(abs(memory) < 0.1),
            "jump at the start of slip": bool(mean < 2 / 3 * before),
        },
    )


@claim("chain-length")
def chain_length(evidence):
    """Mean chain length at the belt speeds of the experiment, in metres."""
    row = evidence.row(5, 1.0)
    lengths = {}
    for speed in evidence.claim.parameters["belt_velocity_m_s"]:
        at = np.abs(row.belt_velocity - units.from_si(speed, "velocity")) <= 1.0
        require(at.any(), f"no point within 1 of u = {speed} m/s")
        lengths[f"{speed} m/s"] = float(
            units.to_si(np.median(row.points["mean_length"][at]), "length")
        )
    return Measurement(lengths, note="in metres, from the fixed point to the last block")


@claim("setup")
def setup(evidence):
    """The springs of the scheme, read off the forces of the model."""
    chain = _chain(evidence, n_blocks=5)
    rest = chain.rest_positions
    couplings = np.array([_response(chain, rest, block) for block in range(chain.n_blocks)])
    neighbours = np.eye(5, k=1) + np.eye(5, k=-1) - 2 * np.eye(5)
    neighbours[-1, -1] = -1
    return Measurement(
        checks={
            "no force with undeformed springs": bool(
                np.allclose(spring.external_force(rest, chain), 0)
            ),
            "first block tied to the fixed point, last one free": bool(
                np.allclose(np.diag(couplings), np.diag(neighbours), atol=1e-6)
            ),
            "only neighbours act": bool(np.allclose(couplings, neighbours, atol=1e-6)),
        }
    )


def _chain(evidence, n_blocks=1):
    return ChainParameters(n_blocks=n_blocks, belt_velocity=1.0, **evidence.settings["model"])


def _slope(deformation, chain, step=1e-5):
    force = spring.spring_force(np.array([deformation - step, deformation + step]), chain)
    return (force[0] - force[1]) / (2 * step)


def _response(chain, rest, block):
    shift = np.zeros(chain.n_blocks)
    shift[block] = 1e-3
    return spring.external_force(rest + shift, chain) / 1e-3

"""Claims on the model, its units and its numerical scheme (Sec. III, Appendix)."""

import numpy as np

from beltrepro.base.errors import require
from beltrepro.model import ChainParameters, spring, units
from beltrepro.replication.studies.laws import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats.estimates import all_sure, mean, share, sure


@claim("units")
def unit_system(evidence):
    velocity, force = units.VELOCITY_M_S, units.FORCE_N
    return _sure({"time_s": units.TIME_S, "velocity_m_s": velocity, "force_N": force})


@claim("friction-constants")
def friction_constants(evidence):
    """The measured friction forces in model units, and whether the runs used the printed ones."""
    used, paper = evidence.settings["model"], evidence.claim.paper
    force = units.from_si(units.STATIC_FRICTION_N, "force")
    ratio = units.KINETIC_FRICTION_N / units.STATIC_FRICTION_N
    checks = {
        f"the runs used {name} = {value:g}": used[name] == value for name, value in paper.items()
    }
    return _sure({"static_friction": force, "friction_ratio": ratio} | checks)


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
    return _sure(checks)


@claim("friction-law")
def friction_law(evidence):
    """Statistics of the friction force while blocks are stuck and while they slip."""
    series = evidence.dataset("friction_event")
    chain = _chain(evidence, n_blocks=int(series.attributes["n_blocks"]))
    numbers, count = measure.friction_numbers(series, chain)
    return Measurement(numbers, note=f"{count} samples in slip, in {measure.STRETCHES} stretches")


@claim("chain-length")
def chain_length(evidence):
    """Mean chain length near the belt speeds of the experiment, in metres."""
    runs = evidence.row("n5_replicates", 5, evidence.claim.parameters["noise"])
    lengths = {}
    for speed in evidence.claim.parameters["belt_velocity_m_s"]:
        distance = np.abs(runs.belt_velocity - units.from_si(speed, "velocity"))
        require(distance.min() <= 1.0, f"no run within 1 of u = {speed} m/s")
        at = np.isclose(distance, distance.min())
        lengths[f"{speed} m/s"] = mean(units.to_si(runs.points["mean_length"][at], "length"))
    return Measurement(also=lengths, note="in metres, from the fixed point to the last block")


@claim("setup")
def setup(evidence):
    """The springs of the scheme, read off the forces of the model."""
    chain = _chain(evidence, n_blocks=5)
    rest, shift = chain.rest_positions, 1e-3
    shifted = [spring.external_force(rest + moved, chain) for moved in shift * np.eye(5)]
    couplings = np.array(shifted) / shift
    neighbours = np.eye(5, k=1) + np.eye(5, k=-1) - 2 * np.eye(5)
    neighbours[-1, -1] = -1
    tied = np.allclose(np.diag(couplings), np.diag(neighbours), atol=1e-6)
    return _sure(
        {
            "no force with undeformed springs": np.allclose(spring.external_force(rest, chain), 0),
            "first block tied to the fixed point, last one free": tied,
            "only neighbours act": np.allclose(couplings, neighbours, atol=1e-6),
        }
    )


# --- what the springs and the scheme do -----------------------------------------------------------


@claim("no-collisions", {"faces, the paper's scheme": "verlet"})
def closest(evidence, method):
    """Whether blocks collide in sampled runs by a method."""
    runs = {name: evidence.dataset(name) for name in evidence.claim.needs if evidence.has(name)}
    gaps = {
        name: np.diff(run.arrays["positions"], axis=1).min()
        for name, run in runs.items()
        if run.attributes["kind"] == "series" and run.attributes["method"] == method
    }
    require(gaps, f"no sampled run by {method} with positions")
    nearest = min(gaps, key=gaps.__getitem__)
    return Measurement(
        {"collision": sure(gaps[nearest] < 0)},
        {"smallest gap": sure(gaps[nearest]), "runs": sure(len(gaps))},
        f"the smallest gap is in {nearest}",
    )


@claim("no-collisions", "faces, exact dynamics")
def collisions(evidence):
    """Share of runs with noise as long as the paper's in which blocks collide.

    The integrator stops where a spring has no length, and with it the workflow: the scans that are
    there hold no collision. Runs without noise repeat themselves, and tell nothing of what is rare.
    """
    scans = [evidence.dataset(name) for name in evidence.claim.parameters["scans"]]
    noisy = [int(np.count_nonzero(scan.arrays["noise"])) for scan in scans]
    durations = [scan.attributes["duration"] for scan in scans]
    runs, time = sum(noisy), float(np.dot(noisy, durations))
    lengths = int(time / evidence.claim.parameters["duration"])
    sampled = closest(evidence, "event")
    also = sampled.also | {"runs": sure(runs), "lengths": sure(lengths)}
    return Measurement(sampled.judged | {"collisions": share(0, lengths)}, also, sampled.note)


@claim(
    "scheme-order", {"the formula, in a step and per time": True, "the formula, in a run": False}
)
def order_of_formula(evidence, in_one_step):
    """Order in the time step of the formula of the scheme."""
    return _sure({"order": measure.order_of_formula(in_one_step=in_one_step)})


@claim("scheme-order", "after 5 slips and sticks")
def order_of_runs(evidence):
    """Errors against the exact dynamics from the same states; starts are drawn anew."""
    sides = [evidence.dataset(f"pairs_paths_{method}").arrays for method in ("verlet", "event")]
    place = (
        evidence.claim.parameters[key] for key in ("n_blocks", "belt_velocity", "after_events")
    )
    steps, errors = measure.errors_of_runs(*sides, *place)
    first, *_, last = measure.root_mean_square(errors)
    words = (
        f"root mean square error {first:.2g} at dt = {steps[0]:g}, {last:.2g} at dt = {steps[-1]:g}"
    )
    return Measurement({"order": measure.order_of_runs(steps, errors)}, note=words)


def _chain(evidence, n_blocks=1):
    return ChainParameters(n_blocks=n_blocks, belt_velocity=1.0, **evidence.settings["model"])


def _slope(deformation, chain, step=1e-5):
    force = spring.spring_force(np.array([deformation - step, deformation + step]), chain)
    return (force[0] - force[1]) / (2 * step)


def _sure(values):
    return Measurement(all_sure(values))

"""Claims on the model, its units and its numerical scheme (Sec. III, Appendix)."""

from functools import partial

import numpy as np

from beltrepro.model import ChainParameters, spring, units
from beltrepro.replication.studies.integrators import divergence
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats.errors import require
from beltrepro.stats.estimates import bootstrap, mean, ratio, smallest, sure

STRETCHES = 20
_STUCK = 1e-9


@claim("units")
def unit_system(evidence):
    """Time, velocity and force units from the three base units."""
    return Measurement(
        {
            "time_s": sure(units.TIME_S),
            "velocity_m_s": sure(units.VELOCITY_M_S),
            "force_N": sure(units.FORCE_N),
        }
    )


@claim("friction-constants")
def friction_constants(evidence):
    """The measured friction forces in model units, and whether the runs used the printed ones."""
    used, paper = evidence.settings["model"], evidence.claim.paper
    force = units.from_si(units.STATIC_FRICTION_N, "force")
    own = {
        "static_friction": sure(force),
        "friction_ratio": sure(units.KINETIC_FRICTION_N / units.STATIC_FRICTION_N),
    }
    checks = {
        f"the runs used {name} = {value:g}": used[name] == value for name, value in paper.items()
    }
    return Measurement(own | {name: sure(passes) for name, passes in checks.items()})


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
    return Measurement({name: sure(bool(passed)) for name, passed in checks.items()})


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
    balance = np.abs(friction + external)[:-1][inner] / chain.static_friction
    slipping = ~stuck[:-1] & ~stuck[1:] & (np.sign(relative[:-1]) == np.sign(relative[1:]))
    require(slipping.sum() >= 1000 and inner.sum() >= 1000, "too few samples of stick and of slip")
    kinetic = np.abs(friction[:-1][slipping])
    following = np.abs(friction[1:][slipping])
    events = series.arrays["events"]
    before = np.abs(events["force"][events["kind"] == "slip"])
    require(before.size >= 2, f"{before.size} slips, not 2")
    target = chain.friction_ratio * chain.static_friction
    spread = chain.friction_ratio * series.attributes["noise"]
    in_slip = _over_stretches(np.mean, kinetic)
    return Measurement(
        {
            "stuck: |F_f + F_ex| / F_st0": _over_stretches(_nearly_all, balance),
            "slip: mean / (f_s F_st0)": _over_stretches(np.mean, kinetic / target),
            "slip: spread / (f_s sigma)": _over_stretches(np.std, kinetic / spread),
            "slip: correlation of steps": _over_stretches(_correlation, kinetic, following),
            "friction in slip / before": ratio(in_slip, mean(before)),
        },
        note=f"{kinetic.size} samples in slip, in {STRETCHES} stretches",
    )


def _over_stretches(statistic, *samples):
    parts = zip(*(np.array_split(each, STRETCHES) for each in samples), strict=True)
    return mean([statistic(*part) for part in parts])


def _nearly_all(values):
    return np.quantile(values, 0.99)


def _correlation(one, other):
    return np.corrcoef(one, other)[0, 1] if one.std() > 0 else 1.0


@claim("chain-length")
def chain_length(evidence):
    """Mean chain length near the belt speeds of the experiment, in metres."""
    runs = evidence.replicates(5, evidence.claim.parameters["noise"])
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
    rest = chain.rest_positions
    couplings = np.array([_response(chain, rest, block) for block in range(chain.n_blocks)])
    neighbours = np.eye(5, k=1) + np.eye(5, k=-1) - 2 * np.eye(5)
    neighbours[-1, -1] = -1
    tied = np.allclose(np.diag(couplings), np.diag(neighbours), atol=1e-6)
    return Measurement(
        {
            "no force with undeformed springs": sure(
                np.allclose(spring.external_force(rest, chain), 0)
            ),
            "first block tied to the fixed point, last one free": sure(tied),
            "only neighbours act": sure(np.allclose(couplings, neighbours, atol=1e-6)),
        }
    )


# --- what the springs and the scheme do -----------------------------------------------------------


@claim("no-collisions")
def no_collisions(evidence):
    """Smallest gap between neighbouring blocks in all sampled runs."""
    length = units.from_si(evidence.claim.parameters["block_length_m"], "length")
    return {
        "distance of centres": partial(_smallest_gap, evidence, length),
        "distance of faces": partial(_smallest_gap, evidence, 0.0),
    }


def _smallest_gap(evidence, contact):
    """Of the run that has it; its interval from stretches of that run."""
    names = [name for name in evidence.claim.needs if evidence.has(name)]
    require(names, "no sampled run with positions")
    gaps = {
        name: np.diff(evidence.dataset(name).arrays["positions"], axis=1).min(axis=1) - contact
        for name in names
    }
    name = min(gaps, key=lambda each: gaps[each].min())
    found = smallest([part.min() for part in np.array_split(gaps[name], STRETCHES)])
    of_experiment = [gaps[each].min() for each in names if each.startswith("belt")]
    at_speeds = (
        {"at the speeds of the experiment": sure(min(of_experiment))} if of_experiment else {}
    )
    return Measurement(
        {"smallest gap": found},
        at_speeds,
        note=f"of {len(names)} runs, in {name}; below zero for {np.mean(gaps[name] < 0):.2g} of "
        "its time",
    )


@claim("scheme-order")
def scheme_order(evidence):
    """Order of the scheme in the time step: of runs, and of its formula."""
    own = evidence.claim.parameters
    order = partial(_order_of_runs, evidence, own["n_blocks"], own["belt_velocity"])
    return {
        "after 5 slips and sticks": partial(order, own["after_events"]),
        "after 1": partial(order, 1),
        "after 20": partial(order, 20),
        "N = 2": partial(_order_of_runs, evidence, 2, own["belt_velocity"], own["after_events"]),
        "u = 3": partial(_order_of_runs, evidence, own["n_blocks"], 3.0, own["after_events"]),
        "the formula, in a run": partial(_order_of_formula, in_one_step=False),
        "the formula, in a step and per time": partial(_order_of_formula, in_one_step=True),
    }


def _order_of_runs(evidence, n_blocks, belt_velocity, after_events):
    """Errors against the exact dynamics from the same states; starts are drawn anew."""
    tested, reference = (
        evidence.dataset(f"pairs_paths_{method}").arrays for method in ("verlet", "event")
    )
    finest = divergence.equal(reference["time_step"], reference["time_step"].min())
    at = (tested["n_blocks"] == n_blocks) & np.isclose(tested["belt_velocity"], belt_velocity)
    require(at.any(), f"no paths with N = {n_blocks}, u = {belt_velocity:g}")
    steps = np.unique(tested["time_step"][at])
    errors = []
    for step in steps:
        rows = at & divergence.equal(tested["time_step"], step)
        found = divergence.pairs(tested, reference, rows=rows, reference_rows=finest)
        errors.append([pair.error_after(after_events) for pair in found[n_blocks, belt_velocity]])
    errors = np.array(errors).T
    errors = errors[np.isfinite(errors).all(axis=1)]
    require(len(errors) >= 4, f"{len(errors)} starts with so many events, 4 are needed")
    return Measurement(
        {"order": bootstrap(partial(_order, steps), [errors])},
        note="slips and sticks are found once in a step, late by up to dt; root mean square error "
        f"{_root_mean_square(errors)[0]:.2g} at dt = {steps[0]:g} and "
        f"{_root_mean_square(errors)[-1]:.2g} at {steps[-1]:g}",
    )


def _order(steps, errors):
    return divergence.convergence_order(steps, _root_mean_square(errors))[0]


def _root_mean_square(errors):
    return np.sqrt(np.mean(errors**2, axis=0))


def _order_of_formula(*, in_one_step):
    """x(t+dt) = 2x(t) - x(t-dt) + a(t) dt^2 for x'' = -x, of which cos t is a solution."""
    steps = 2.0 ** -np.arange(4, 9)
    errors = []
    for step in steps:
        before, now = np.cos(1 - step), np.cos(1.0)
        count = 1 if in_one_step else round(1 / step)
        for _ in range(count):
            before, now = now, 2 * now - before - now * step**2
        error = abs(now - np.cos(1 + count * step))
        errors.append(error / step if in_one_step else error)
    return Measurement({"order": sure(divergence.convergence_order(steps, errors)[0])})


def _chain(evidence, n_blocks=1):
    return ChainParameters(n_blocks=n_blocks, belt_velocity=1.0, **evidence.settings["model"])


def _slope(deformation, chain, step=1e-5):
    force = spring.spring_force(np.array([deformation - step, deformation + step]), chain)
    return (force[0] - force[1]) / (2 * step)


def _response(chain, rest, block):
    shift = np.zeros(chain.n_blocks)
    shift[block] = 1e-3
    return spring.external_force(rest + shift, chain) / 1e-3

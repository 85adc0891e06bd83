"""Whether a run obeys the law: audits of its samples that know nothing of the integrators.

The energy balance of a run tests the motion between events. It closes just as well with wrong
events, since friction takes whatever it takes. Three audits look at what it cannot see: the motion
is computed anew over some pieces, with its events (without noise); friction must brake every
block, and static friction must hold every stuck one; and noise must change momentum by as much as
it should. Model units, laboratory frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.engine.event import NOISE_CELL
from beltrepro.model import ChainParameters
from beltrepro.model.friction import kinetic_friction, next_direction
from beltrepro.model.spring import external_force
from beltrepro.simulation.tables import Tabled

if TYPE_CHECKING:
    from beltrepro.simulation import Run

_STEP = 5e-3  # of the motion computed anew, model time
_WINDOW = 4 * NOISE_CELL  # over which momentum is summed, model time
# Share of a cell of the noise that is missing at the ends of a window, see docs/validity.md.
_LOST = 2 / 15
# of an interval: where momentum follows from positions between the samples, by Gauss and Legendre
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(3)
_SAMPLES = 10**6  # at most, from the start of a run: memory and time
_LONGEST_INTERVAL = 0.25  # model time: the interpolation between samples must be better than noise


@dataclass(frozen=True)
class Audit(Tabled):
    """What the audits of a run have found; NaN where one does not apply.

    Attributes
    ----------
    energy_residual : float
        Share of the belt's work that the energy balance does not account for.
    wrong_way : float
        Greatest speed over the belt at which friction pushed a block on, model velocity. The scheme
        in steps finds the end of a slip up to one step late: up to |a| dt.
    overload : float
        Greatest external force on a stuck block over F_st0.
    windows : int
        Pieces of the run that were computed anew.
    deviation : float
        Greatest distance of a block at their ends from where it is in the run, model length.
    noise_ratio, noise_error : float
        Variance of what noise does to the momentum of blocks over what it should be, and the
        standard error of this ratio.
    """

    energy_residual: float
    wrong_way: float
    overload: float
    windows: int
    deviation: float
    noise_ratio: float
    noise_error: float


@names.checked
def audit(run: Run, windows: int = 20, length: float = 2.0) -> Audit:
    """Audit a run that has samples.

    Parameters
    ----------
    run : Run
        Of any method, from `simulate`; a sample interval of 0.1 will do.
    windows : int
        Pieces of a run without noise that are computed anew, evenly spaced.
    length : float
        Of a piece, model time; rounded to samples, at least one interval.

    Returns
    -------
    Audit
        With NaN for what does not apply to the run.

    Raises
    ------
    InputError
        A value is not allowed.
    """
    if isinstance(run, type) or not hasattr(run, "energy_residual"):
        raise InputError(f"run = {checks.shown(run)}: a Run is needed")
    windows, length = checks.key("windows", windows), checks.positive("length", length)
    chain, first = run.parameters, slice(0, _SAMPLES)
    sampled = run.time[first], run.positions[first], run.velocities[first]
    quiet = chain.noise == 0 and len(run.time) > 1
    pieces = replayed(*sampled, chain, windows=windows, length=length) if quiet else np.empty(0)
    ratio, error = noise_ratio(*sampled, chain, run.method, run.time_step)
    relative = run.velocities[first] - chain.belt_velocity
    pushed = np.abs(relative[run.friction[first] * relative > 0])
    forces = np.abs(external_force(run.positions[first], chain)) / np.asarray(chain.static_friction)
    forces = forces[relative == 0]
    return Audit(
        energy_residual=run.energy_residual,
        wrong_way=float(pushed.max(initial=0.0)) if relative.size else np.nan,
        overload=float(forces.max()) if forces.size else np.nan,
        windows=len(pieces),
        deviation=float(pieces.max()) if len(pieces) else np.nan,
        noise_ratio=ratio,
        noise_error=error,
    )


def replayed(
    time: np.ndarray,
    positions: np.ndarray,
    velocities: np.ndarray,
    parameters: ChainParameters,
    *,
    windows: int,
    length: float,
) -> np.ndarray:
    """Distance of a run without noise from its motion computed anew, at the ends of some pieces.

    Each piece begins in a sample and is computed by the Runge-Kutta method of fourth order, with
    the instants of slip and stick found in its steps.
    """
    samples = max(1, round(length / (time[1] - time[0])))
    starts = np.unique(np.linspace(0, len(time) - 1 - samples, windows).astype(int))
    distances = []
    for start in starts[starts >= 0]:
        end = start + samples
        place, _ = motion(
            positions[start], velocities[start], float(time[end] - time[start]), parameters
        )
        distances.append(np.abs(place - positions[end]).max())
    return np.array(distances)


def motion(
    positions: np.ndarray, velocities: np.ndarray, duration: float, parameters: ChainParameters
) -> tuple[np.ndarray, np.ndarray]:
    """The motion of a chain without noise, computed in a plain way."""
    direction = np.sign(velocities - parameters.belt_velocity)
    time = 0.0
    while time < duration:
        step = min(_STEP, duration - time)
        place, speed = _moved(positions, velocities, direction, step, parameters)
        overdue = np.flatnonzero(_margins(place, speed, direction, parameters) < 0)
        if len(overdue):
            state = positions, velocities, direction
            instants = [_instant(block, step, state, parameters) for block in overdue]
            step, block = min(instants), overdue[np.argmin(instants)]
            place, speed = _moved(positions, velocities, direction, step, parameters)
            direction = _turned(block, place, speed, direction, parameters)
        positions, velocities = place, speed
        time += step
    return positions, velocities


def noise_ratio(
    time: np.ndarray,
    positions: np.ndarray,
    velocities: np.ndarray,
    parameters: ChainParameters,
    method: str,
    time_step: float,
) -> tuple[float, float]:
    """Variance of what noise does to the momentum of slipping blocks, over what it should be.

    It is summed over windows in which a block slips one way. Its variance should be f_s^2 sigma^2
    dt for a unit of time; "event" lacks some at the ends of a window. NaN for another law.
    """
    if parameters.varied:
        return np.nan, np.nan
    power = (parameters.friction_ratio * parameters.noise) ** 2 * time_step
    if power == 0 or len(time) < 2 or time[1] - time[0] > _LONGEST_INTERVAL:
        return np.nan, np.nan
    interval = float(time[1] - time[0])
    count = round(_WINDOW / interval)
    direction = np.sign(velocities - parameters.belt_velocity)
    gained = np.diff(velocities, axis=0) - _impulses(positions, velocities, interval, parameters)
    kinetic = kinetic_friction(parameters, velocities[:-1] - parameters.belt_velocity)
    gained += direction[:-1] * kinetic * interval
    sums = [
        gained[first : first + count, block].sum()
        for block in range(parameters.n_blocks)
        for first in range(0, len(gained) - count + 1, count)
        if abs(direction[first : first + count + 1, block].sum()) == count + 1
    ]
    if not sums:
        return np.nan, np.nan
    lost = _LOST * NOISE_CELL if method == "event" else 0.0
    ratio = float(np.mean(np.square(sums)) / (power * (count * interval - lost)))
    return ratio, ratio * float(np.sqrt(2 / len(sums)))


def _impulses(positions, velocities, interval, parameters):
    """Integral of F_ex over each interval between samples (T-1, N), on Hermite's cubics."""
    total = np.zeros_like(positions[1:])
    rise = np.diff(positions, axis=0)
    before, after = velocities[:-1] * interval, velocities[1:] * interval
    for node, weight in zip((_NODES + 1) / 2, _WEIGHTS / 2, strict=True):
        rest = 1 - node
        place = positions[:-1] + rise * (node**2 * (3 - 2 * node))
        place += node * rest * (rest * before - node * after)
        total += weight * external_force(place, parameters)
    return total * interval


def _moved(positions, velocities, direction, step, parameters):
    """Positions and velocities after one step of the Runge-Kutta method; stuck blocks stay so."""
    slips = direction != 0

    def acceleration(place, velocity):
        braked = direction * kinetic_friction(parameters, velocity - parameters.belt_velocity)
        driven = (external_force(place, parameters) - braked) / np.asarray(parameters.mass)
        return np.where(slips, driven, 0.0)

    first = acceleration(positions, velocities)
    middle = positions + velocities * (step / 2)
    second = acceleration(middle, velocities + first * (step / 2))
    third = acceleration(middle + first * (step**2 / 4), velocities + second * (step / 2))
    fourth = acceleration(
        positions + velocities * step + second * (step**2 / 2), velocities + third * step
    )
    place = positions + velocities * step + (first + second + third) * (step**2 / 6)
    return place, velocities + (first + 2 * (second + third) + fourth) * (step / 6)


def _margins(positions, velocities, direction, parameters):
    """How far each block (N,) is from its next event; negative: it is overdue."""
    held = np.asarray(parameters.static_friction) - np.abs(external_force(positions, parameters))
    return np.where(direction == 0, held, direction * (velocities - parameters.belt_velocity))


def _instant(block, step, state, parameters):
    """When in a step the event of a block is due."""
    positions, velocities, direction = state

    def margin(since):
        place, speed = _moved(positions, velocities, direction, since, parameters)
        return _margins(place, speed, direction, parameters)[block]

    # a slip that has just begun has no margin at the start
    return scipy.optimize.brentq(margin, 0.0, step, xtol=1e-15) if margin(0.0) > 0 else 0.0


def _turned(block, positions, velocities, direction, parameters):
    """Directions after the event of a block, whose velocity becomes that of the belt."""
    force = external_force(positions, parameters)[block]
    # a stuck block stands at its threshold, up to rounding
    static = parameters.by_block("static_friction")[block]
    threshold = static if direction[block] != 0 else -1.0
    velocities[block] = parameters.belt_velocity
    turned = direction.copy()
    turned[block] = next_direction(direction[block], 0.0, force, threshold)
    return turned

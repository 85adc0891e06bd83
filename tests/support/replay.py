"""Runs computed anew in plain Python: whether their samples obey the law, with no kernel's help.

The energy balance of a run closes just as well with wrong events, since friction takes whatever it
takes. Here the motion is computed anew over some pieces, with its events (without noise); and
friction must brake every block, and hold every stuck one.
"""

import numpy as np
import scipy

from beltrepro.model.friction import kinetic_friction, next_direction
from beltrepro.model.spring import external_force

_STEP = 5e-3  # of the motion computed anew, model time
_LENGTH = 2.0  # of a piece


def wrong_way(run):
    """Greatest speed over the belt at which friction pushed a block on."""
    relative = run.velocities - run.parameters.belt_velocity
    return np.abs(relative[run.friction * relative > 0]).max(initial=0.0)


def overload(run):
    """Greatest external force on a stuck block over F_st0."""
    stuck = run.velocities == run.parameters.belt_velocity
    forces = np.abs(external_force(run.positions, run.parameters))
    return (forces / np.asarray(run.parameters.static_friction))[stuck].max()


def deviation(run, *, windows):
    """Greatest distance of a block of a run without noise from its motion computed anew.

    Each piece begins in a sample and is computed by the Runge-Kutta method of fourth order, with
    the instants of slip and stick found in its steps.
    """
    samples = round(_LENGTH / (run.time[1] - run.time[0]))
    distances = []
    for start in np.linspace(0, len(run.time) - 1 - samples, windows).astype(int):
        end = start + samples
        length = run.time[end] - run.time[start]
        place, _ = motion(run.positions[start], run.velocities[start], length, run.parameters)
        distances.append(np.abs(place - run.positions[end]).max())
    return max(distances)


def motion(positions, velocities, duration, parameters):
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

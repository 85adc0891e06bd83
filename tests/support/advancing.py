"""Integrators of the engine in a few words, and all that they record of each chain."""

from typing import NamedTuple

import numpy as np

from beltrepro import ChainState
from beltrepro.engine.integrator import Sampling, Section
from beltrepro.model.spring import spring_extension


class Record(NamedTuple):
    """What one chain has done: events (E, 6), crossings, samples (S, 3, B), and its end."""

    events: np.ndarray
    crossings: np.ndarray
    samples: np.ndarray  # displacement, relative velocity, kinetic friction
    audit: float
    positions: np.ndarray
    velocities: np.ndarray


def at_rest(chains, starts=None, replicates=None):
    """States of chains from given positions, all blocks stuck."""
    starts = [None] * len(chains) if starts is None else starts
    replicates = [0] * len(chains) if replicates is None else replicates
    members = zip(chains, starts, replicates, strict=True)
    return [ChainState.at_rest(chain, start, replicate=number) for chain, start, number in members]


def sliding(chain, displacements):
    """A state in which all blocks slip, for ever if they stay near where springs hold friction."""
    forces = chain.friction_ratio * chain.static_friction * np.arange(chain.n_blocks, 0, -1)
    balance = np.cumsum(spring_extension(forces, chain) + chain.rest_length)
    return ChainState.in_motion(chain, balance + displacements, np.zeros(chain.n_blocks))


def integrator(kind, states, *, time_step=0.001, stride=100, section=None, **settings):
    """Samples of all blocks every `stride` steps; section : a block and its place in all chains."""
    if section is not None:
        section = Section(section[0], np.full(len(states), section[1]))
    settings = {"sampled_blocks": states[0].parameters.n_blocks} | settings
    sampling = Sampling(stride, time_step)
    return kind(states, time_step=time_step, sampling=sampling, section=section, **settings)


def small_buffers(chains, events, crossings):
    """Leave an integrator room for a few records of each chain only."""
    for name, rows in (("_events", events), ("_crossings", crossings)):
        buffer = getattr(chains, name)
        setattr(chains, name, buffer._replace(rows=buffer.rows[:, :rows].copy()))


def recorded(chains, until):
    """The record of each chain, over one or more chunks."""
    lanes = [[] for _ in chains.parameters]
    for chunk in chains.advance(until):
        values = chunk.displacement, chunk.relative_velocity, chunk.kinetic_friction
        samples = np.stack(values, axis=1)
        for lane, parts in enumerate(lanes):
            events = chunk.events[lane, : chunk.event_count[lane]]
            crossings = chunk.crossings[lane, : chunk.crossing_count[lane]]
            parts.append([part.copy() for part in (events, crossings, samples[..., lane])])
    ends = chains.energy_residual(), chains.positions(), chains.velocities()
    return [
        Record(*map(np.concatenate, zip(*parts, strict=True)), *end)
        for parts, *end in zip(lanes, *ends, strict=True)
    ]


def assert_equal_bits(records, expected):
    for one, other in zip(records, expected, strict=True):
        for a, b in zip(one, other, strict=True):
            np.testing.assert_array_equal(a, b)

"""What a chain does depends on nothing but itself: not on its company, buffers or samples."""

from functools import partial

import numpy as np
import pytest

from advancing import assert_equal_bits, at_rest, integrator, recorded, small_buffers
from beltrepro import ChainParameters
from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.tangent import TangentIntegrator
from beltrepro.engine.verlet_integrator import VerletIntegrator

DISORDER = {"mass": (1.0, 2.0, 0.5), "friction_ratio": (0.3, 0.45, 0.4), "viscosity": 0.01}
MIXED = (0.0, 1.0, 0.3)
LITERAL = partial(VerletIntegrator, literal=True)
KINDS = {
    "event": (EventIntegrator, MIXED, {}),
    "event, other law": (EventIntegrator, MIXED, DISORDER),
    "tangent": (TangentIntegrator, MIXED, {}),
    "leaping": (partial(VerletIntegrator, literal=False), (0.0,), {}),
    "literal": (LITERAL, (0.0,), {}),
    "literal, noise": (LITERAL, (3.0, 0.0, 1.0), {}),
    "literal, other law": (LITERAL, MIXED, DISORDER),
}


def followed(name, numbers, rows=None):
    """Records of some of 37 chains, with room for `rows` of events and crossings."""
    kind, noises, law = KINDS[name]
    chains = [
        ChainParameters(3, 6.0 + 3 * (i % 7), noises[i % len(noises)], **law) for i in numbers
    ]
    starts = np.random.default_rng(5).uniform(-1, 1, (37, 3))[list(numbers)]
    settings: dict = {"time_step": 0.005, "stride": 7, "section": (3, 320.0)}
    if kind is TangentIntegrator:
        settings["n_vectors"] = 2
    states = at_rest(chains, chains[0].rest_positions + starts, numbers)
    group = integrator(kind, states, **settings)
    if kind is TangentIntegrator:
        deviations = np.random.default_rng(6).standard_normal((37, 7, 2))
        group.set_deviations(deviations[list(numbers), : 6 + any(c.noise for c in chains)])
    if rows:
        small_buffers(group, *rows)
    records = recorded(group, 60.0)
    if kind is TangentIntegrator:
        return [(*one, now[:6]) for one, now in zip(records, group.deviations(), strict=True)]
    return records


@pytest.mark.parametrize("name", KINDS)
def test_company_and_buffers_change_no_bit(name):
    expected = followed(name, range(37))
    assert min(len(events) for events, *_ in expected) > 4
    assert sum(len(crossings) for _, crossings, *_ in expected) > 10
    for first, width, *rows in ((0, 9, 30, 4), (9, 1, 30, 4), (10, 27)):
        part = range(first, first + width)
        assert_equal_bits(followed(name, part, rows), expected[first : first + width])


def test_the_stride_of_the_samples_changes_no_bit_of_the_scheme():
    # chains of all kinds: nearly always stuck, laminar, noisy, beyond the reach of the series
    kinds = [(0.3, 0.0), (12.0, 0.0), (30.0, 0.0), (45.0, 2.0), (20.0, 15.0), (90.0, 0.0), (8, 1.0)]
    chains = [ChainParameters(4, u, sigma) for u, sigma in kinds]
    starts = chains[0].rest_positions + np.random.default_rng(5).uniform(-1, 1, (7, 4))

    def sampled(stride):
        states = at_rest(chains, starts, range(7))
        settings = {"time_step": 0.004, "stride": stride, "section": (2, 190.0)}
        records = recorded(integrator(LITERAL, states, **settings), 56.0)
        # of the samples those at multiples of 700 steps
        every = slice(700 // stride - 1, None, 700 // stride)
        return [one._replace(samples=one.samples[every]) for one in records]

    expected = sampled(700)
    assert sum(len(one.events) for one in expected) > 50
    assert sum(len(one.crossings) for one in expected) > 5
    assert len(expected[0].samples) == 20
    for stride in (1, 7, 10, 100):
        assert_equal_bits(sampled(stride), expected)

"""Random numbers of a chain: what their key depends on, and the generator against a plain twin."""

import struct
from dataclasses import fields, replace

import numpy as np
import pytest

import naive
from beltrepro import ChainParameters
from beltrepro.engine.noise import normal_deviates, stream_key, stream_states

CHAIN = ChainParameters(5, 12.0, noise=1.0)
FIELDS = [field.name for field in fields(ChainParameters)]
OF_THE_PAPER = FIELDS[:9]  # the law of the paper is keyed by these numbers, any other by all


def words(chain, seed=1, replicate=0, purpose=0):
    return tuple(stream_key(chain, seed, replicate, purpose).generate_state(4))


@pytest.mark.parametrize("name", FIELDS)
def test_the_key_depends_on_every_parameter_of_the_chain(name):
    value = getattr(CHAIN, name)
    others = {"n_blocks": 6, "weakening_velocity": 1e9, "viscosity": 1e-9}
    near = others.get(name, np.nextafter(value, 0.0))
    assert words(replace(CHAIN, **{name: near})) != words(CHAIN)


def test_streams_have_the_documented_key():
    """Results are reproduced from parameters, seed and replicate: the key must never change."""
    random = np.random.default_rng(3)
    ends = [0, 1, 2**32 - 1, 2**32, 2**40, 2**63 - 1]  # of one word, or of two
    chains = [
        ChainParameters(3 + number % 2, random.uniform(1, 50), noise, friction_ratio=ratio)
        for number, (noise, ratio) in enumerate([(0.0, 0.45), (-0.0, 0.0), (1.0, 0.5)] * 12)
    ]
    seeds, replicates = ([int(one) for one in random.choice(ends, 36)] for _ in range(2))
    for purpose in (0, 1, 2**33):
        states = stream_states(chains, seeds, replicates, purpose)
        for chain, seed, replicate, state in zip(chains, seeds, replicates, states.T, strict=True):
            reals = [getattr(chain, name) + 0.0 for name in OF_THE_PAPER[1:]]
            bits = [struct.unpack("<Q", struct.pack("<d", value))[0] for value in reals]
            key = [seed, chain.n_blocks, replicate, purpose, *bits]
            expected = np.random.SeedSequence(key).generate_state(4, np.uint64)
            np.testing.assert_array_equal(state, expected)
            one = stream_key(chain, seed, replicate, purpose)
            np.testing.assert_array_equal(one.generate_state(4, np.uint64), expected)


def test_normal_deviates_are_those_of_the_plain_twin():
    states = stream_states([CHAIN] * 8, 1, range(8))
    expected = [naive.normal_deviates(states[:, lane].tolist(), 200) for lane in range(8)]
    normals = np.zeros((200, 8))
    normal_deviates(states, normals)
    np.testing.assert_allclose(normals, np.transpose(expected), rtol=0, atol=2e-8)


def test_deviates_are_normal_and_streams_independent():
    normals = np.empty((200_000, 16))
    normal_deviates(stream_states([CHAIN] * 16, 7, range(16)), normals)
    # bounds at 5 standard errors and more: error rate 6e-7 each
    for power, expected, variance in ((1, 0, 1), (2, 1, 2), (3, 0, 15), (4, 3, 96)):
        assert abs((normals**power).mean() - expected) < 5 * np.sqrt(variance / normals.size)
    for lag in (1, 2, 3, 4, 5, 10):
        assert abs((normals[lag:] * normals[:-lag]).mean()) < 5 / np.sqrt(normals.size)
        assert abs((normals[lag:, 1:] * normals[:-lag, :-1]).mean()) < 5 / np.sqrt(normals.size)
    for values in (normals, normals**2):
        correlation = np.corrcoef(values.T) - np.eye(16)
        assert np.abs(correlation).max() < 6 / np.sqrt(len(normals))

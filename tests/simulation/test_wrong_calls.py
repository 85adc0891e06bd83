"""Calls that contradict themselves or the model are refused in one line, before anything runs."""

import math

import pytest

import beltrepro
from beltrepro import ChainParameters, ChainState, Grid, Setup, catalogue, scan, simulate
from beltrepro.base.errors import InputError

CHAIN, TWO = ChainParameters(3, 10.0), [ChainParameters(3, 10.0)] * 2
STATE = ChainState.at_rest(CHAIN)
MODEL = {"n_blocks": 3, "belt_velocity": 10.0}
ANY = {"duration": 10.0}
STEPS = {"method": "verlet"}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"n_blocks": 0}, "n_blocks = 0: must be at least 1"),
        ({"n_blocks": 2.5}, "n_blocks = 2.5: a whole number"),
        ({"n_blocks": [2, 3]}, "n_blocks = [2, 3]: a whole number"),
        ({"belt_velocity": 0.0}, "belt_velocity = 0: must be greater than 0"),
        ({"belt_velocity": -1.0}, "belt_velocity = -1: must be greater than 0"),
        ({"noise": -0.5}, "noise = -0.5: must be at least 0"),
        ({"noise": math.nan}, "noise = nan: a finite number"),
        ({"static_friction": -71.4}, "static_friction = -71.4: must be greater than 0"),
        ({"friction_ratio": 1.0}, "friction_ratio = 1: must be at least 0 and below 1"),
        ({"friction_ratio": -0.1}, "friction_ratio = -0.1: must be at least 0 and below 1"),
        ({"rest_length": 0.0}, "rest_length = 0: must be greater than 0"),
        ({"linear_limit": 0.0}, "linear_limit = 0: must be greater than 0"),
        ({"compression_rate": -0.2}, "compression_rate = -0.2: must be greater than 0"),
        ({"extension_rate": math.inf}, "extension_rate = inf: a finite number"),
        ({"frictoin_ratio": 0.4}, "no argument 'frictoin_ratio'; did you mean 'friction_ratio'?"),
    ],
)
def test_a_chain_that_cannot_be_is_refused(changes, words):
    refused(words, ChainParameters, **MODEL | changes)


@pytest.mark.parametrize(
    ("called", "chains", "changes", "words"),
    [
        (scan, TWO, {"replicate": [1, 2, 3]}, "replicate of length 3: one value for all chains"),
        (scan, TWO, STEPS | {"time_step": [0.1] * 3}, "time_step of length 3: one value for all"),
        (scan, CHAIN, {"transient": 10.0}, "transient = 10: must be at least 0 and less than"),
        (scan, CHAIN, {"transient": -1.0}, "transient = -1: must be at least 0 and less than"),
        (scan, CHAIN, {"duration": 0.0}, "duration = 0: must be greater than 0"),
        (scan, CHAIN, {"method": "rk4"}, "method = 'rk4': allowed are verlet, event"),
        (scan, CHAIN, STEPS | {"tolerance": 1e-8}, "tolerance = 1e-08: method 'verlet' has none"),
        (scan, Setup(CHAIN), {"method": "event"}, "method: not together with a Setup"),
        (scan, CHAIN, {"kick": 0.1}, "kick = 0.1: only for separation and time_to_orbit"),
        (catalogue, CHAIN, {"section_block": 0}, "section_block = 0: allowed are 1 to 3"),
        (catalogue, CHAIN, {"section_block": 4}, "section_block = 4: allowed are 1 to 3"),
        (simulate, CHAIN, {"sample_interval": 0.0}, "sample_interval = 0: must be greater than 0"),
        (simulate, CHAIN, {"initial_positions": [50.0, 100.0]}, "3 numbers are needed"),
        (simulate, TWO, {"initial_positions": [[50.0, 99.0, 150.0]] * 3}, "one array for each"),
        (simulate, ChainParameters(4, 10.0), {"initial_state": STATE}, "initial_state of 3 blocks"),
    ],
)
def test_a_call_that_contradicts_itself_is_refused(called, chains, changes, words):
    refused(words, called, chains, **ANY | changes)


@pytest.mark.parametrize(
    ("axes", "changes", "words"),
    [
        (([], 5.0), {}, "n_blocks is empty: at least one number"),
        (([2], 5.0), {"replicates": 0}, "replicates: makes 0 points"),
    ],
)
def test_a_grid_without_points_is_refused(axes, changes, words):
    refused(words, Grid, *axes, **changes)


def refused(words, called, *arguments, **settings):
    """That a call is refused by one line with these words."""
    with pytest.raises(InputError) as caught:
        called(*arguments, **settings)
    assert words in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "name", ["simulate", "scan", "catalogue", "classify", "lyapunov_spectrum", "periodic_orbit"]
)
def test_numbers_without_a_name_are_told_how_to_write_them(name):
    refused(
        f"{name}: write duration=1000, transient=300", getattr(beltrepro, name), CHAIN, 1000, 300
    )

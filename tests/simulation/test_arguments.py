"""Each argument of each public function reaches its purpose: another value is another outcome."""

import inspect
from collections.abc import Mapping

import numpy as np
import pytest

import beltrepro
from beltrepro import (
    ChainParameters,
    ChainState,
    Setup,
    avalanche_energies,
    basins,
    catalogue,
    classify,
    density,
    lyapunov_spectrum,
    margin,
    orbit_branch,
    periodic_orbit,
    power_law,
    scan,
    simulate,
    slip_sizes,
    slipping_state,
    spectrum,
    sweep,
    time_to_continuous_slip,
    time_to_orbit,
)
from beltrepro.base.errors import InputError
from beltrepro.simulation.grid import QUANTITIES

CHAIN, NOISY = ChainParameters(2, 20.0), ChainParameters(3, 10.0, 1.0)
LENGTHS = {"duration": 400.0, "transient": 100.0}
LATER = {"duration": 390.0, "transient": 90.0}
BEGUN = {"seed": 2, "replicate": 3, "initial_spread": 0.2}
USUAL, EXACT = {"chains": [NOISY], **BEGUN, **LENGTHS}, {"chains": CHAIN, **BEGUN}
SECTION = {"section_position": 140.0, "section_values": 3, "laminar_time": 1.0}
CLOCK = {"noise_clock": "laboratory"}
ANOTHER = {"method": "verlet", "time_step": 0.002, "tolerance": 1e-3}
ANOTHER |= {"seed": 3, "replicate": 4, "initial_spread": 0.3}


def begun_at(chain, *places):
    """Another value of each keyword of a setup, the starts from these places."""
    return ANOTHER | {
        "initial_positions": places,
        "initial_state": ChainState.at_rest(chain, places),
    }


def orbit(belt_velocity):
    how = {"duration": 6000.0, "transient": 3000.0, "replicate": 1, "initial_spread": 1.0}
    return periodic_orbit(ChainParameters(2, belt_velocity), **how)


SETUP, OF_TWO = begun_at(NOISY, 50.0, 101.0, 149.0), begun_at(CHAIN, 50.0, 101.0)
RECORDS = catalogue(NOISY, **LENGTHS)
VALUES = 1 + np.random.default_rng(1).pareto(1.0, 3000)
SAMPLES = {"sample_interval": 0.2, "sample_start": 9.0, "belt": [(0.0, 10.0), (50.0, 12.0)]}
# What each is told, and another value of each of its other arguments.
CALLS = {
    simulate: (USUAL, SETUP | LATER | SAMPLES),
    scan: (USUAL, SETUP | LATER | SECTION | {"section_bins": [0.0, 100.0, 200.0]}),
    catalogue: (USUAL, SETUP | LATER | {"section_position": 140.0, "section_block": 2}),
    classify: (USUAL, SETUP | LATER | CLOCK),
    lyapunov_spectrum: (USUAL, SETUP | LATER | CLOCK | {"n_exponents": 2}),
    sweep: (USUAL | {"belt_velocity": [10.0, 12.0]}, SETUP | LATER | SECTION),
    time_to_continuous_slip: (
        {"chains": NOISY, "duration": 396.0, **BEGUN},  # which ends within a slip of the last block
        SETUP | {"duration": 390.0, "settle_time": 20.0, "laminar_time": 1.0},
    ),
    time_to_orbit: (
        EXACT | {"duration": 1500.0},
        OF_TWO | {"duration": 390.0, "closed": 0.9},
    ),
    basins: (EXACT | {"duration": 1500.0}, OF_TWO | {"duration": 390.0}),
    periodic_orbit: (
        EXACT | {"duration": 2400.0, "transient": 1500.0},
        OF_TWO | {"duration": 2100.0, "transient": 1400.0},
    ),
    margin: ({"orbit": orbit(19.0), "begin": 0.1}, {"begin": 0.013, "periods": 1, "slips": 1}),
    orbit_branch: (
        {"orbit": orbit(5.0), "lower": 1.2, "upper": 5.2, "step": 1.0},
        {"lower": 1.3, "upper": 5.3, "step": 0.5, "unstable": True, "tolerance": 1e-3},
    ),
    density: ({"values": VALUES}, {"bins_per_decade": 4}),
    power_law: ({"values": VALUES}, {"low": 3.0}),
    spectrum: ({"runs": VALUES, "sample_interval": 0.1}, {"sample_interval": 0.2}),
    slip_sizes: ({"source": RECORDS}, {"frame": "belt"}),
    avalanche_energies: (
        {"source": RECORDS, "last_block": False},
        {"last_block": True, "least_blocks": 2},
    ),
    slipping_state: (
        {"parameters": NOISY, "energy": 9.0},
        {"energy": 10.0, "seed": 3, "replicate": 4},
    ),
}
NO_NUMBER = {"workers", "progress", "on_error", "store"}  # depends on them
TOLD = {*inspect.signature(Setup).parameters, "settings"}  # said by results as it was given
WITH_TANGENTS = (classify, lyapunov_spectrum, basins, periodic_orbit)  # of "event" alone
WITHOUT_NOISE = (time_to_orbit, basins, periodic_orbit)  # steps are as long as they can be


def numbers(outcome, told):
    """All of them by name, but what it was told."""
    if isinstance(outcome, np.ndarray):
        names = outcome.dtype.names
        outcome = {name: outcome[name].tolist() for name in names} if names else outcome.tobytes()
    elif isinstance(outcome, list | tuple):
        return [numbers(item, told) for item in outcome]
    elif not isinstance(outcome, Mapping):
        outcome = getattr(outcome, "__dict__", repr(outcome))
    if not isinstance(outcome, Mapping):
        return outcome
    return {name: numbers(outcome[name], told) for name in outcome.keys() - told}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("function", CALLS, ids=lambda function: function.__name__)
def test_each_argument_changes_what_is_measured(function):
    usual, others = CALLS[function]
    own = list(inspect.signature(function).parameters)[1:]
    assert set(own) - NO_NUMBER - {*QUANTITIES, "quantity"} == others.keys()
    for name, other in others.items():
        told = usual
        if name == "initial_state":
            told = {name: value for name, value in usual.items() if name not in BEGUN}
        if name == "method" and function in WITH_TANGENTS:
            with pytest.raises(InputError, match="method = 'verlet': only 'event'"):
                function(**told | {name: other})
            continue
        one, another = (
            numbers(function(**call), TOLD | {name}) for call in (told, told | {name: other})
        )
        changes = not (name == "time_step" and function in WITHOUT_NOISE)
        assert (one != another) == changes, name


def test_each_function_with_options_is_asked():
    called = [getattr(beltrepro, name) for name in beltrepro.__all__]
    functions = {one for one in called if inspect.isfunction(one)}
    assert {one for one in functions if inspect.getfullargspec(one).kwonlyargs} <= CALLS.keys()

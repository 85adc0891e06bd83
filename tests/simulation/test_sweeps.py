"""Sweeps: at each value the bits of a scan from where the value before has ended."""

from dataclasses import replace

import numpy as np
import pytest

from beltrepro import ChainParameters, Grid, Results, Setup, scan, sweep
from beltrepro.base.errors import InputError
from beltrepro.simulation import sweeps

CHAIN = ChainParameters(3, 10.0)
SHORT = {"duration": 60.0, "transient": 20.0, "section_values": 20}
UP_DOWN = [8.0, 14.0, 20.0, 20.0, 14.0, 8.0]


def by_hand(chains, quantity, values, **begin):
    """Scans with the states handed on."""
    parts, settings = [], SHORT | begin
    for value in values:
        moved = [replace(chain, **{quantity: value}) for chain in chains]
        parts.append(scan(moved, **settings))
        settings = {name: settings[name] for name in (*SHORT, "method") if name in settings}
        settings |= {"initial_state": parts[-1].final_states}
    return parts


@pytest.mark.filterwarnings("ignore:.*warnings on the way")
@pytest.mark.filterwarnings("ignore:.*loading is measured")
@pytest.mark.parametrize(
    ("quantity", "values", "begin"),
    [
        ("belt_velocity", UP_DOWN, {"method": "verlet", "initial_spread": 1.0, "seed": 4}),
        ("noise", [0.5, 2.0, 1.0], {}),
        ("stiffness", [1.0, (1.0, 2.0, 1.0)], {"initial_spread": 1.0}),
        ("weakening_velocity", [500.0, 300.0], {"initial_spread": 1.0}),
    ],
)
def test_each_value_has_the_bits_of_a_scan_from_the_one_before(quantity, values, begin):
    begin = {"replicate": [0, 5, 6]} | begin
    parts = by_hand([CHAIN] * 3, quantity, values, **begin)
    swept = sweep([CHAIN] * 3, **SHORT, **begin, **{quantity: values})
    assert len(swept["step"]) == 3 * len(values)
    for step, part in enumerate(parts):
        rows = swept["step"] == step
        for name, array in part.items():
            if array.ndim < 2 or name == "section_velocity":
                here = swept[name][rows]
                column = here if here.ndim == array.ndim else here[:, 0]
                np.testing.assert_array_equal(column, array, err_msg=name)
        states = [state for state, there in zip(swept.final_states, rows, strict=True) if there]
        assert states == part.final_states
    assert np.isfinite(swept["section_velocity"][:, 0]).any()
    np.testing.assert_array_equal(swept["replicate"], [0, 5, 6] * len(values))


@pytest.mark.filterwarnings("ignore:.*warnings on the way")
def test_the_rows_say_which_way_and_are_saved(tmp_path):
    swept = sweep(Grid(3, 1.0, 1.0, replicates=2), **SHORT, belt_velocity=UP_DOWN)
    assert swept["way"].tolist() == ["up"] * 6 + ["down"] * 6
    np.testing.assert_array_equal(swept["belt_velocity"], np.repeat(UP_DOWN, 2))
    assert swept.axes == ["belt_velocity", "replicate"] and swept.settings["kind"] == "sweep"
    swept.save(tmp_path / "sweep.h5")
    read = Results.load(tmp_path / "sweep.h5")
    assert list(read) == list(swept) and read.final_states == swept.final_states
    np.testing.assert_array_equal(read["way"], swept["way"])
    assert list(swept.table())[:2] == ["step", "way"]
    again = sweep(Setup(Grid(3, 1.0, 1.0, replicates=2)), **SHORT, belt_velocity=UP_DOWN)
    np.testing.assert_array_equal(again["section_velocity"], swept["section_velocity"])
    masses = [(1, 1, 2), (1, 1, 1), (1, 1, 1), (1, 2, 1)]
    swept = sweep(ChainParameters(3, 10.0, 1.0), **SHORT, mass=masses)
    assert swept["way"].tolist() == ["down", "down", "up", "up"]
    np.testing.assert_array_equal(swept["mass"], masses)


def test_blocks_that_go_both_ways_are_told():
    chain, ratios = ChainParameters(3, 8.0), [(0.1, 0.2, 0.3), (0.3, 0.2, 0.1), (0.3, 0.3, 0.1)]
    for values, ways in (
        (ratios, ["both", "both", "up"]),
        (ratios[::-1], ["down", "down", "both"]),
    ):
        swept = sweep(chain, friction_ratio=values, duration=60.0, transient=20.0)
        assert swept["way"].tolist() == ways


def test_warnings_of_a_sweep_are_one_line():
    with pytest.warns(UserWarning) as heard:
        sweep(ChainParameters(10, 1.0), belt_velocity=[1.0, 1.1, 1.2], duration=200)
    assert len(heard) == 1 and heard[0].filename == __file__
    assert "3 warnings on the way, the first at belt_velocity = 1.0: load" in str(heard[0].message)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "one quantity with the values that it takes is needed, as belt_velocity=[5, 10]"),
        ({"noise": [1], "mass": [1]}, "given are noise, mass"),
        ({"noise": 1.0}, "noise = 1.0: the values that it takes are needed"),
        ({"noise": []}, "noise = []: the values that it takes are needed"),
        ({"noise": [1.0, -1.0]}, "noise = -1: must be at least 0"),
        ({"noise": [1.0, 50.0]}, "noise = 50: with friction_ratio = 0.45"),
        ({"mass": (1, 3, 1)}, "mass = (1, 3, 1): write mass=[(1, 3, 1)] for one chain whose"),
        ({"mass": [1.0, (1, 2)]}, "mass = [1, 2] has 2 numbers"),
        ({"n_blocks": [2, 3]}, "sweep has no argument 'n_blocks'"),
    ],
)
def test_a_wrong_sweep_is_told_in_one_line_before_the_first_scan(given, said, monkeypatch):
    monkeypatch.setattr(sweeps, "scan_of", None)
    with pytest.raises(InputError) as caught:
        sweep(CHAIN, **SHORT, **given)
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_values_that_stay_infinite_have_a_way_and_one_block_needs_no_word():
    chain = ChainParameters(1, 8.0)
    limits = [100.0, np.inf, np.inf]
    swept = sweep(chain, weakening_velocity=limits, duration=60.0, transient=20.0)
    assert swept["way"].tolist() == ["up"] * 3
    assert sweep(chain, mass=(2.0,), duration=60.0, transient=20.0)["mass"].tolist() == [2.0]


def test_a_grid_of_the_quantity_itself_is_refused():
    with pytest.raises(InputError, match="noise: not together with a Grid of several values"):
        sweep(Grid(3, 10.0, [0.0, 1.0]), **SHORT, noise=[1.0, 2.0])


@pytest.mark.filterwarnings("ignore:.*warnings on the way")
def test_a_chain_that_has_failed_stays_so_at_all_values_after():
    chains, values = [CHAIN, replace(CHAIN, noise=1.0)], [10.0, 1e5, 30.0]
    with pytest.warns(UserWarning, match="all chains have failed"):
        swept = sweep(chains, duration=60.0, on_error="nan", belt_velocity=values)
    assert np.isfinite(swept["disorder_parameter"][:2]).all()
    assert np.isnan(swept["disorder_parameter"][2:]).all()
    assert all(line.endswith("the chain has failed before") for line in swept["error"][4:])
    slower = [replace(chain, belt_velocity=9.0) for chain in chains]
    state, begun = swept.final_states[4], swept.final_states[0]
    with pytest.warns(UserWarning, match="1 of 2 chains have failed; .* has failed before"):
        later = scan(slower, duration=60.0, on_error="nan", initial_state=[state, begun])
    assert np.isnan(later["mean_length"]).tolist() == [True, False]


def test_the_store_of_a_sweep_is_told_from_its_results(tmp_path):
    path, chain = tmp_path / "store.h5", replace(CHAIN, noise=1.0)
    how = {"belt_velocity": [8.0, 14.0, 8.0], "duration": 60.0, "transient": 50.0}
    swept = sweep(chain, store=path, **how)
    with pytest.warns(UserWarning, match="up to 2 rows of one replicate at one point .* way if"):
        Results.load(path).plot(where={"initial_spread": 0.0}, y="section_count")
    swept.save(tmp_path / "saved.h5")
    with pytest.raises(InputError, match="the store of a sweep is a file that store= wrote, not"):
        sweep(chain, store=tmp_path / "saved.h5", **how)

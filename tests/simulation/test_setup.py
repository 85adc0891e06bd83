"""A setup is one value for all functions: what follows from it, and what it refuses."""

import dataclasses
import itertools

import numpy as np
import pytest

from beltrepro import (
    ChainParameters,
    ChainState,
    Grid,
    Results,
    Setup,
    catalogue,
    classify,
    lyapunov_spectrum,
    periodic_orbit,
    scan,
    simulate,
    time_to_continuous_slip,
    time_to_orbit,
)
from beltrepro.base.errors import InputError
from beltrepro.engine.state import Scheme
from beltrepro.simulation import trajectories

CHAIN, NOISY = ChainParameters(2, 20.0), ChainParameters(3, 10.0, 1.0)
STATE = ChainState.at_rest(CHAIN, time=0.5)
SHORT = {"duration": 60.0, "transient": 20.0}
# Three chains that share nothing, the odd one in the middle.
CHAINS = [NOISY, ChainParameters(1, 5.0, friction_ratio=0.6), CHAIN]
MIXED = {"method": ["event", "verlet", "event"], "time_step": [0.001, 0.002, 0.004]}
MIXED |= {"tolerance": [1e-8, None, None], "initial_spread": [0.3, 0.5, 1e-3]}
MIXED |= {"seed": [1, 2, 3], "replicate": [0, 4, 5]}


def bits(outcome):
    """All numbers that a function returned."""
    if isinstance(outcome, list):
        return [bits(item) for item in outcome]
    if isinstance(outcome, dict):
        return {name: array.tobytes() for name, array in outcome.items()}
    return {
        name: value.tobytes() if isinstance(value, np.ndarray) else repr(value)
        for name, value in vars(outcome).items()
    }


FUNCTIONS = dict.fromkeys([simulate, scan, catalogue, classify, lyapunov_spectrum], SHORT)
FUNCTIONS |= {time_to_continuous_slip: {"duration": 60.0}, time_to_orbit: {"duration": 60.0}}


# --- one value for all functions ---


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.__name__)
def test_keywords_and_a_setup_that_is_used_again_give_the_same_bits(function):
    options = {
        "time_step": 0.002,
        "seed": 4,
        "replicate": [0, 2, 7],
        "initial_spread": [0.1, 0.5, 1],
    }
    setup = Setup(CHAINS, **options)
    by_keywords = bits(function(CHAINS, **options, **FUNCTIONS[function]))
    assert by_keywords == bits(function(setup, **FUNCTIONS[function]))
    assert by_keywords == bits(function(setup, **FUNCTIONS[function]))
    changed = dataclasses.replace(setup, seed=5)
    assert by_keywords != bits(function(changed, **FUNCTIONS[function]))


START = {"initial_positions": [50.0, 101.0, 149.0]}


def test_one_chain_makes_one_value_and_several_make_a_table():
    setup = Setup(CHAIN, replicate=3, initial_spread=0.5)
    assert setup.alone and not Setup(CHAIN, replicate=[3]).alone and not Setup([CHAIN]).alone
    assert simulate(setup, **SHORT).parameters == classify(setup, **SHORT).parameters == CHAIN
    assert isinstance(simulate(Setup([CHAIN]), **SHORT), list)
    assert isinstance(classify(Setup([CHAIN]), **SHORT), Results)
    with pytest.raises(InputError, match="one run of one chain is needed"):
        periodic_orbit(Setup([CHAIN, NOISY]), **SHORT)


@pytest.mark.parametrize("function", [simulate, scan, time_to_continuous_slip])
def test_each_chain_has_its_own_settings_whatever_its_company(function):
    lengths = {"duration": 60.0}
    # the last two advance together with the first
    chains = [*CHAINS, NOISY, NOISY]
    settings = {name: [*values, values[0], values[0]] for name, values in MIXED.items()}
    settings |= {"seed": [1, 2, 3, 9, 8], "tolerance": [1e-8, None, None, 1e-8, 1e-9]}
    together = function(chains, **settings, **lengths)
    for index, chain in enumerate(chains):
        alone = function(chain, **{name: settings[name][index] for name in MIXED}, **lengths)
        if function is simulate:
            assert alone == together[index]
            continue
        for name, values in alone.items():
            row = together[name][index]
            row = row[: values.shape[1]] if values.ndim == 2 else row
            np.testing.assert_array_equal(row, values[0], err_msg=name)


def columns_of(outcome, chain):
    """Each array of a chain, and each field of its records."""
    for values in outcome.values():
        if fields := values.dtype.names:
            yield from (values[name][values["point"] == chain] for name in fields[1:])
        elif values.ndim:
            yield values[[chain]]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("function", list(FUNCTIONS)[1:], ids=lambda one: one.__name__)
def test_each_size_is_measured_as_if_alone(function):
    """Chains of one size do not stand together; what shorter ones lack is NaN, or 0 of counts."""
    sizes = ((2, 15.0), (5, 20.0), (1, 5.0), (3, 15.0, 1.0), (5, 12.0))
    chains = [ChainParameters(*values) for values in sizes]
    told = FUNCTIONS[function] | {"duration": 1500.0 if function is time_to_orbit else 160.0}
    each = {"replicate": [1, 2, 3, 4, 5], "initial_spread": [1.0, 2.0, 0.5, 0.0, 0.3]}
    if function in (scan, catalogue):
        each["section_position"] = [120.0, 610.0, 80.0, 190.0, 560.0]
    together = function(chains, **each, **told)
    for index, chain in enumerate(chains):
        one = {name: [values[index]] for name, values in each.items()}
        alone = list(columns_of(function([chain], **one, **told), 0))
        for here, expected in zip(columns_of(together, index), alone, strict=True):
            here, rest = np.split(here, [expected.shape[-1]], axis=-1)
            np.testing.assert_array_equal(here, expected)
            assert rest.size == 0 or np.all(np.isnan(rest) if rest.dtype.kind == "f" else rest == 0)


def test_one_chain_with_sequences_is_simulated_for_each_of_their_values():
    starts = [[48.0, 101.0], [50.0, 99.0], [53.0, 102.0]]
    options = {"duration": 20.0, "seed": 3}
    runs = simulate(CHAIN, initial_positions=starts, replicate=[2, 0, 1], **options)
    for run, start, replicate in zip(runs, starts, [2, 0, 1], strict=True):
        alone = simulate(CHAIN, initial_positions=start, replicate=replicate, **options)
        assert run == alone and run.initial_state.positions.tolist() == start
    runs = simulate(NOISY, replicate=iter(range(3)), **START, **options)
    several = {"replicate": range(3), **options}
    for starts in (START["initial_positions"], [START["initial_positions"]] * 3):
        assert runs == simulate([NOISY] * 3, initial_positions=starts, **several)


def test_the_start_is_at_rest_on_undeformed_springs():
    for setup in (Setup(NOISY), Setup(NOISY, initial_spread=3.0), Setup(NOISY, replicate=5)):
        (case,) = setup.cases
        np.testing.assert_array_equal(case.state.positions, NOISY.rest_positions)
        assert not case.state.directions.any()
    assert (case.method, case.time_step, case.tolerance) == ("event", 0.001, None)
    spread = Setup(ChainParameters(5, 20.0), replicate=range(1, 400), initial_spread=0.5).cases
    moved = np.array([case.state.displacements for case in spread])
    assert moved.std() == pytest.approx(0.5, rel=0.1) and abs(moved.mean()) < 0.06


# --- runs that repeat each other ---


def test_runs_that_repeat_each_other_do_not_pass_silently(recwarn):
    with pytest.warns(UserWarning, match=r"7 of 8 chains repeat.*replicate=range\(8\)$") as warned:
        simulate([NOISY] * 8, duration=1.0, sample_interval=None)
    assert all(warning.filename == __file__ for warning in warned)
    recwarn.clear()
    Setup(NOISY, replicate=range(8))
    Setup(NOISY, seed=[1, 2])
    Setup(CHAIN, replicate=[0, 1], initial_spread=1e-3)
    Setup([CHAIN, NOISY])
    Setup(CHAIN, time_step=[0.001, 0.002])
    assert not recwarn.list


SEEDS = {"seed": [1, 2]}
MIX = Grid(2, 20.0, [0.0, 1.0], replicates=4)


@pytest.mark.parametrize(
    ("chains", "options", "advice", "followed"),
    [
        ([CHAIN] * 3, {}, "replicate=range(3) and an initial_spread", {"replicate": range(3)}),
        (CHAIN, {"replicate": range(3)}, "an initial_spread", {}),
        (CHAIN, SEEDS, "replicate=range(2) and an initial_spread", {"replicate": range(2)}),
        (CHAIN, SEEDS | {"initial_spread": 1.0}, "replicate=range(2)", {"replicate": range(2)}),
        (MIX, {}, "an initial_spread", {}),
        (Grid(2, [9, 9], 1.0), {}, "a Grid of each value once", {"chains": Grid(2, [9], 1.0)}),
        (
            [CHAIN] * 2,
            {"initial_state": STATE},
            "replicate=range(2) and other states, by ChainState.moved or ChainState.at_balance(",
            {"initial_state": [STATE, STATE.moved([50.0, 101.0])]},
        ),
    ],
)
def test_advice_for_runs_that_repeat_each_other_helps(chains, options, advice, followed, recwarn):
    Setup(chains, **options)
    (warning,) = recwarn
    assert f"runs that differ need {advice}" in str(warning.message)
    recwarn.clear()
    spread = {"initial_spread": 1.0} if "initial_spread" in advice else {}
    Setup(**{"chains": chains} | options | spread | followed)
    assert not recwarn.list


@pytest.mark.parametrize(
    "field", ["displacements", "relative_velocities", "directions", "thresholds", "stream", "time"]
)
def test_runs_that_go_on_from_different_states_repeat_nothing(field, recwarn):
    """A change in any field that a run depends on makes another run of it, and no warning."""
    chain = ChainParameters(2, 20.0, 1.0)
    state = simulate(chain, duration=5, sample_interval=None).final_state
    recwarn.clear()
    value = getattr(state, field)
    changed = value + np.ones_like(value) if field == "stream" else value + 0.5
    other = dataclasses.replace(state, **{field: changed})
    Setup([chain] * 2, initial_state=[state, other])
    assert not recwarn.list
    if field == "stream":  # without noise nothing is drawn, so it does not matter
        states = [state.under(CHAIN) for state in (state, other)]
        with pytest.warns(UserWarning, match="1 of 2 chains repeat"):
            Setup(CHAIN, initial_state=states)
    with pytest.warns(UserWarning, match="1 of 2 chains repeat"):
        Setup(chain, initial_state=[state, state])


def test_the_key_of_a_run_differs_where_anything_does():
    """In each field of a case and of its state; the spread of a start shows in the state."""
    (case,) = Setup(NOISY).cases
    told = {"method": "verlet", "time_step": 0.002, "tolerance": 1e-8}
    names = {field.name for field in dataclasses.fields(case)}
    assert told.keys() == names - {"state", "initial_spread"}
    others = [dataclasses.replace(case, **{name: value}) for name, value in told.items()]
    schemes = [Scheme("a", 0.001, {"w": np.zeros(3)})]
    for changes in ({"integrator": "b"}, {"time_step": 0.002}, {"variables": {"w": np.ones(3)}}):
        schemes.append(dataclasses.replace(schemes[0], **changes))
    for name, value in vars(case.state).items():
        values = {"parameters": [CHAIN], "scheme": schemes}.get(name)
        for other in values or [value + np.ones_like(value)]:
            state = dataclasses.replace(case.state, **{name: other})
            others.append(dataclasses.replace(case, state=state))
    assert len({one.key for one in [case, *others]}) == 1 + len(others) == 21


# --- grids and results ---

AXES = {"n_blocks": [3, 1, 2], "belt_velocity": [5.0, 20.0], "friction_ratio": [0.45, 0.6]}


@pytest.fixture(scope="module")
def results():
    return scan(Grid(**AXES, noise=1.0, replicates=2), seed=4, initial_spread=1.0, **SHORT)


def test_a_grid_is_all_combinations_and_its_numbers_those_of_scan(results):
    points = list(itertools.product(*AXES.values(), range(2)))
    names = (*AXES, "replicate")
    assert list(zip(*(results[name].tolist() for name in names), strict=True)) == points
    chains = [ChainParameters(n, u, 1.0, friction_ratio=ratio) for n, u, ratio, _ in points]
    replicates = [replicate for *_, replicate in points]
    direct = scan(chains, replicate=replicates, seed=4, initial_spread=1.0, **SHORT)
    assert bits(direct) == bits(results)
    assert len(np.unique(results["disorder_parameter"])) == len(points)
    assert results.axes == ["n_blocks", "belt_velocity", "friction_ratio", "replicate"]
    assert repr(results).startswith("Results(24 of n_blocks, belt_velocity, friction_ratio, rep")
    one = scan(Grid(2, 5.0), **SHORT)
    assert len(one.table()) == 1 and one.axes == []


@pytest.mark.parametrize(("laminar_time", "escapes"), [(45.0, 1), (210.9, 1), (211.4, 0)])
def test_time_to_continuous_slip_is_that_of_the_events_of_each_run(laminar_time, escapes):
    """The last block of four slips on from t = 288.84 to the end."""
    chains = [ChainParameters(3, 5.0, 1.0), ChainParameters(4, 45.0), ChainParameters(2, 60.0)]
    how = {"duration": 500.0, "sample_interval": None}
    lengths = {"duration": 500.0, "settle_time": 30.0, "laminar_time": laminar_time}
    times = time_to_continuous_slip(chains, **lengths)
    for chain, run in enumerate(simulate(chains, transient=470.0, **how)):
        n = run.parameters.n_blocks
        sticks = run.events[run.events["kind"] == "stick"]
        late = sticks[sticks["time"] >= 470]["block"]
        rates = [np.sum(late == block) / 30 for block in range(1, n + 1)]
        np.testing.assert_allclose(times["final_stick_rate"][chain, :n], rates)
        last = run.events[run.events["block"] == n][-1]
        escaped = last["kind"] == "slip" and 500 - last["time"] > laminar_time
        stuck = sticks["time"][sticks["block"] == n].max()
        assert times["escaped"][chain] == escaped
        assert times["lifetime"][chain] == (stuck if escaped else 500)
        assert times["final_disorder"][chain] == run.disorder_parameter
        assert times["final_mean_length"][chain] == run.mean_length
    late = scan(chains, duration=500.0, transient=470.0)
    ranges = late["maximum_length"] - late["minimum_length"]
    np.testing.assert_allclose(times["final_amplitude"], ranges)
    assert times["escaped"].sum() == escapes


def test_a_laminar_phase_is_longer_than_the_slips_of_heavy_blocks():
    """At u = 10 a mass of 1e4 sticks every 628.3 for ever."""
    law = {"linear_limit": np.inf, "rest_length": 5000.0}
    chains = [ChainParameters(1, 10.0, mass=mass, **law) for mass in (1e4, 1.0)]
    times = time_to_continuous_slip(chains, duration=5400.0)
    assert not times["escaped"].any()
    assert times.settings["laminar_time"] == "200 sqrt(mass / stiffness)"
    differ = ChainParameters(2, 10.0, mass=(1.0, 4.0), stiffness=(0.25, 1.0))
    for chain, time in ((chains[0], 20_000), (chains[1], 200), (differ, 800)):
        with pytest.warns(match=f"duration = 2: no chain .* laminar_time is {time}$"):
            time_to_continuous_slip(chain, duration=2.0)


def test_few_exponents_of_a_shorter_chain_end_with_nan():
    few = lyapunov_spectrum(CHAINS, duration=60.0, n_exponents=3)["exponents"]
    assert np.isnan(few).sum(axis=1).tolist() == [0, 1, 0]


# --- what holds numbers ---


class Lengths(np.ndarray):
    """Numbers with a unit, as those of astropy and pint."""

    unit = "m"


def test_tables_and_other_holders_of_numbers_are_their_numbers_or_refused():
    pandas = pytest.importorskip("pandas")
    rows = [[40.0, 101.0, 149.0], [52.0, 99.0, 155.0]]
    frame = pandas.DataFrame(rows, columns=[1, 2, 3])  # names that could be positions
    cases = Setup(NOISY, initial_positions=frame, replicate=[1, 2]).cases
    assert [case.state.positions.tolist() for case in cases] == rows
    (case,) = Setup(NOISY, initial_positions=frame.iloc[1]).cases
    assert case.state.positions.tolist() == rows[1]
    assert ChainParameters(3, 10.0, mass=frame.loc[0]).mass == tuple(rows[0])
    assert [chain.belt_velocity for chain in Grid(3, frame[2]).chains] == [101.0, 99.0]
    assert ChainState.at_rest(NOISY, frame.loc[0]).positions.tolist() == rows[0]
    masked = np.ma.array(rows[0], mask=[False, True, False])
    for holder in (frame, frame.T, masked, np.array(rows[0]).view(Lengths), bytearray(b"123")):
        for called, name in (
            (lambda held: ChainParameters(3, 10.0, mass=held), "mass"),
            (lambda held: Grid(3, held), "belt_velocity"),
            (lambda held: Setup(NOISY, replicate=held), "replicate"),
            (lambda held: ChainState.at_rest(NOISY, held), "positions"),
        ):
            with pytest.raises(InputError, match=f"^{name}"):
                called(holder)


MASSES = "write mass=[(1, 3, 1)] for one chain whose blocks differ so, mass=[1, 3] for several"


@pytest.mark.parametrize(
    ("n_blocks", "mass", "says"),
    [
        (3, (1, 3, 1), MASSES),
        (3, [1, 3, 1], MASSES),
        ([2, 3], np.array([1.0, 3.0, 1.0]), MASSES),
        (3, (1, 2, 3), "mass=[(1, 2, 3)] for one chain whose blocks differ so, mass=[1, 2, 3] for"),
        (2, (1.23456789, 1 / 3), "write mass=[(1.23456789, 0.3333333333333333)] for one"),
        (3, [2, 2], "mass = [2, 2]: write mass=[2] for several"),
        (3, [1, 2, 3], [1, 2, 3]),
        (3, (1, 2), [1, 2]),
        (3, [(1, 3, 1), (1, 1, 3)], [(1, 3, 1), (1, 1, 3)]),
        (1, (2.0,), [2.0]),
    ],
)
def test_masses_of_blocks_are_not_taken_for_those_of_chains(n_blocks, mass, says):
    if isinstance(says, list):
        assert [chain.mass for chain in Grid(n_blocks, 10, mass=mass).chains] == says
        return
    with pytest.raises(InputError) as caught:
        Grid(n_blocks, 10, mass=mass)
    assert says in str(caught.value)


def test_a_grid_of_iterators_can_be_changed():
    grid = dataclasses.replace(Grid(3, iter([10.0, 20.0]), replicates=iter([4, 7])), noise=1.0)
    assert [chain.belt_velocity for chain in grid.chains] == [10.0, 10.0, 20.0, 20.0]
    assert grid.replicate == (4, 7, 4, 7)


# --- samples and memory ---


def test_samples_that_do_not_fit_are_refused_before_the_start(monkeypatch):
    chain = ChainParameters(5, 20.0)
    monkeypatch.setattr(trajectories, "available_memory", lambda: 10**9)
    with pytest.raises(InputError) as caught:
        simulate([chain] * 2, duration=2e6, replicate=[0, 1], initial_spread=1e-3)
    words = str(caught.value)
    # 2 chains, 2e7 samples of 1 + 3 * 5 numbers of 8 bytes
    assert "sample_interval = 0.1" in words and "5.12 GB" in words and "\n" not in words
    fits = float(words.split("from ")[1].split()[0])
    cases = Setup(chain, seed=[1, 2], replicate=1, initial_spread=1.0).cases
    trajectories.check_samples(fits, 0.0, 2e6, cases)
    with pytest.raises(InputError):
        trajectories.check_samples(fits / 1.3, 0.0, 2e6, cases)
    trajectories.check_samples(0.1, 1.9e6, 2e6, cases)


def test_memory_that_the_system_tells_in_kilobytes_becomes_bytes(monkeypatch):
    text = "MemTotal: 9000 kB\nMemAvailable:    1000 kB\n"
    monkeypatch.setattr(trajectories.Path, "read_text", lambda path: text)
    assert trajectories.available_memory() == 1024 * 1000


# --- what is refused ---

LATER, STEPS = {"initial_state": STATE}, {"method": "verlet"}


@pytest.mark.parametrize(
    ("chains", "options", "words"),
    [
        (Setup(CHAIN), {"seed": 3}, "seed: not together with a Setup"),
        (Grid(2, 5.0), {"replicate": 1}, "replicate: not together with a Grid"),
        (Grid([2, 3], 5.0), {"seed": [1, 2, 3]}, "seed of length 3: one value for all chains"),
        (CHAIN, {"seed": [1, 2], "replicate": [1, 2, 3]}, "replicate of length 3: one value for"),
        (CHAIN, {"initial_spread": 1e3, "replicate": 3}, "on the wrong side of each other"),
        (NOISY, {"initial_state": STATE}, "initial_state of 2 blocks: a chain of n_blocks = 3"),
        (CHAIN, LATER | {"initial_positions": [60.0, 110.0]}, "initial_positions: not together"),
        (CHAIN, LATER | {"initial_spread": 0.1}, "initial_spread: not together with initial_state"),
        (CHAIN, LATER | STEPS | {"time_step": 0.003}, "initial_state at t = 0.5: method 'verlet'"),
        (CHAIN, STEPS | {"sample_interval": 0.5445}, "'verlet' needs a multiple of time_step"),
        (CHAIN, STEPS | {"tolerance": 1e-8}, "tolerance = 1e-08: method 'verlet' has none"),
        (CHAIN, {"sample_start": 11}, "sample_start = 11: must be at most duration = 10"),
    ],
)
def test_bad_input_is_one_line(chains, options, words):
    with pytest.raises(InputError) as caught:
        simulate(chains, **{"duration": 10} | options)
    assert words in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("function", "allowed", "refused"),
    [
        (scan, {"section_position": 1e-9}, {"section_position": 0.0}),
        (scan, {"section_values": 0}, {"section_values": 100_001}),
        (scan, {"section_position": [615.0]}, {"section_position": [600.0, 610.0]}),
        (catalogue, {"section_block": 1}, {"section_block": 0}),
        (catalogue, {}, {"section_block": 3}),
        (catalogue, {}, {"chains": [NOISY, CHAIN], "section_block": 3, "section_position": 80.0}),
        (time_to_continuous_slip, {"settle_time": 0.5}, {"settle_time": 0.0}),
        (time_to_continuous_slip, {}, {"settle_time": 0.51}),
        (scan, {"transient": 0.4}, {"transient": 0.5}),
        (scan, {"duration": 0.2}, {"duration": 0.0}),
    ],
)
def test_what_each_function_is_told_at_the_ends_of_its_range(function, allowed, refused):
    chosen = {"chains": CHAIN, "duration": 0.5}
    assert all(values.dtype != object for values in function(**chosen | allowed).values())
    with pytest.raises(InputError, match="n_blocks|" + "|".join(refused)):
        function(**chosen | refused)


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ({"replicates": 0}, "replicates: makes 0 points, allowed are 1 to 1000000"),
        ({"noise": np.linspace(0, 1, 1001), "replicates": 1000}, "noise: makes 1001000 points"),
    ],
)
def test_a_grid_that_cannot_be_is_one_line(axes, words):
    with pytest.raises(InputError, match=words):
        Grid(**{"n_blocks": 2, "belt_velocity": 5.0} | axes)

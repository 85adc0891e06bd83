"""A scan that goes on: past chains that fail, after an interruption, with more replicates."""

from dataclasses import replace

import numpy as np
import pytest

from beltrepro import (
    ChainParameters,
    Grid,
    Results,
    catalogue,
    classify,
    lyapunov_spectrum,
    scan,
    simulate,
    sweep,
    time_to_continuous_slip,
    time_to_orbit,
)
from beltrepro.base import provenance
from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.simulation import gathering

GOOD, BAD = ChainParameters(5, 10.0), ChainParameters(5, 150.0)  # at 150 blocks 4 and 5 meet
CHAINS = [GOOD, BAD, ChainParameters(5, 12.0), ChainParameters(3, 10.0), replace(BAD, noise=1.0)]
WELL = [0, 2, 3]
SHORT = {"duration": 300.0, "transient": 100.0}
GRID = Grid([2, 12], [5.0, 10.0], 1.0, replicates=3)
FUNCTIONS = {
    scan: SHORT | {"section_bins": [-120.0, -50.0, 0.0]},
    time_to_continuous_slip: {"duration": 300.0},
    classify: SHORT,
    lyapunov_spectrum: SHORT,
}
functions = pytest.mark.parametrize(
    ("called", "settings"), FUNCTIONS.items(), ids=lambda value: getattr(value, "__name__", "")
)
pytestmark = pytest.mark.filterwarnings("ignore:.*loading is measured:UserWarning")


@pytest.fixture(autouse=True)
def committed(monkeypatch):
    monkeypatch.setattr(provenance, "code_version", lambda: "2.0.0+g0123456789ab")


def same(one: Results, other: Results) -> None:
    """Check that results agree in every bit, in the order of their columns, and in their states."""
    assert list(one) == list(other)
    # rows that were read name what made them
    assert one.settings | provenance.origin() == other.settings | provenance.origin()
    for name, array in one.items():
        assert array.shape == other[name].shape, name
        np.testing.assert_array_equal(array, other[name], err_msg=name)
        if array.dtype.kind != "U":
            assert array.tobytes() == other[name].tobytes(), name
    assert one.final_states == other.final_states


# --- chains that fail ---


@functions
@pytest.mark.parametrize("workers", [1, 3])
def test_a_chain_that_fails_leaves_the_others_their_bits(called, settings, workers):
    with pytest.raises(ModelStateError, match=r"u=150.* meet"):
        called(CHAINS, **settings)
    says = r"^2 of 5 chains have failed; the first is N=5, u=150.*: blocks \d and \d meet"
    with pytest.warns(UserWarning, match=says):
        results = called(CHAINS, on_error="nan", workers=workers, **settings)
    alone = called([CHAINS[index] for index in WELL], **settings)
    assert set(results) == {*alone, "error"}
    for name, array in alone.items():
        np.testing.assert_array_equal(results[name][WELL] if array.ndim else array, array)
    assert [bool(line) for line in results["error"]] == [False, True, False, False, True]
    for name in list(alone)[list(alone).index("replicate") + 1 :]:
        lost = results[name][[1, 4]] if results[name].ndim else np.zeros(0)
        assert set(lost.astype(str).flat) <= {"nan", "0", "False", ""}, name


def test_a_catalogue_tells_which_chains_have_failed():
    with pytest.warns(UserWarning, match=r"^2 of 5 chains have failed"):
        rows = catalogue(CHAINS, on_error="nan", **SHORT)
    alone = catalogue([CHAINS[index] for index in WELL], **SHORT)
    for name, array in alone.items():
        array["point"] = np.array(WELL)[array["point"]]
        assert rows[name].tobytes() == array.tobytes()
    assert rows.table("errors")["point"].tolist() == [1, 4] and "error" not in alone


def test_where_all_fail_the_first_error_is_raised():
    for called in (*FUNCTIONS, catalogue):
        with pytest.raises(ModelStateError, match="u=150"):
            called(BAD, on_error="nan", **FUNCTIONS.get(called, SHORT))


def test_a_spectrum_is_that_of_the_runs_that_do_not_fail():
    chain = ChainParameters(5, 5.0, weakening_velocity=30.0)  # they fail at t = 119.4 and 119.0
    settings = {"duration": 119.2, "transient": 20.0, "replicate": range(2), "initial_spread": 1.0}
    with pytest.warns(
        UserWarning, match="^1 of 2 chains have failed.*: block 1 reaches the support"
    ):
        spectrum = lyapunov_spectrum(chain, on_error="nan", **settings)
    assert len(spectrum.runs) == len(spectrum.most_stuck) == 1


# --- a file that grows ---


@pytest.fixture
def computed(monkeypatch):
    """The numbers of the chains that are computed."""
    numbers, parts_of = [], gathering.parts_of

    def spied(measure, on_error, group):
        parts = parts_of(measure, on_error, group)
        numbers.extend(group.indices.tolist())
        return parts

    monkeypatch.setattr(gathering, "parts_of", spied)
    return numbers


@functions
@pytest.mark.parametrize("workers", [1, 2])
def test_what_is_finished_is_not_computed_again(called, settings, workers, tmp_path, computed):
    def interrupted(fraction):
        if fraction > 0.5:
            raise KeyboardInterrupt

    settings = settings | {"workers": workers}
    whole, path = called(GRID, **settings), tmp_path / "r.h5"
    more = replace(GRID, replicates=range(5))
    larger = called(more, store=tmp_path / "whole.h5", **settings)
    computed.clear()
    with pytest.raises(KeyboardInterrupt):
        called(GRID, store=path, progress=interrupted, **settings)
    assert len(computed) == 6 or workers > 1  # of those two may be ready before they are looked at
    same(called(GRID, store=path, **settings), whole)
    assert sorted(computed) == list(range(12))
    told = []
    same(called(GRID, store=path, progress=told.append, **settings), whole)
    assert len(computed) == 12 and told == [1.0]
    same(called(more, store=path, **settings), larger)
    assert len(computed) == 20 and path.read_bytes() == (tmp_path / "whole.h5").read_bytes()
    rows = [13, 2, 7]
    chains, numbers = zip(*((more.chains[row], more.replicate[row]) for row in rows), strict=True)
    found = called(chains, store=path, replicate=numbers, **settings)
    assert len(computed) == len(Results.load(path)["replicate"]) == 20
    for name, array in larger.items():
        np.testing.assert_array_equal(found[name], array[rows] if array.ndim else array)


@pytest.mark.parametrize(
    ("name", "there", "here"),
    [
        ("duration", 300.0, 400.0), ("transient", 100.0, 50.0), ("method", "event", "verlet"),
        ("tolerance", 1e-10, 1e-12), ("time_step", 0.001, 0.01), ("seed", 1, 2),
        ("initial_spread", 0.0, 1.0), ("section_position", "none", 90.0),
        ("section_values", 500, 5), ("laminar_time", r"200 sqrt\(mass / stiffness\)", 50.0),
    ],
)  # fmt: skip
def test_other_settings_are_refused_in_one_line(name, there, here, tmp_path):
    path, chain = tmp_path / "r.h5", ChainParameters(2, 5.0, 1.0)
    first = scan(chain, store=path, **SHORT)
    before, says = path.read_bytes(), f"{name} is {there} there and {here} here$"
    with pytest.raises(InputError, match=rf"^store = .*r\.h5: {says}"):
        scan(chain, store=path, **SHORT | {name: here})
    with pytest.raises(InputError, match=f"^other: {says}"):
        scan(chain, **SHORT | {name: here}).joined(first)
    assert path.read_bytes() == before


def test_two_calls_add_to_one_file(tmp_path):
    path, others = tmp_path / "r.h5", [ChainParameters(2, 6.0), ChainParameters(3, 6.0)]
    (tmp_path / ".unfinished-99999999-r.h5").write_text("of one that was killed")
    alive = [tmp_path / f".unfinished-{name}" for name in ("1-r.h5", "99999999-my-r.h5")]
    for file in alive:
        file.write_text("of one that is alive, or of another name")
    told = []

    def meanwhile(fraction):
        told.append(fraction)
        if len(told) == 1:
            scan(others, store=path, **SHORT)
        elif fraction > 0.9:
            path.unlink(missing_ok=True)  # what is known is written again

    scan(GRID, store=path, progress=meanwhile, **SHORT)
    assert Results.load(path)["n_blocks"].tolist() == [2, 3, *[2] * 6, *[12] * 6]
    assert sorted(tmp_path.iterdir()) == [*alive, path]


@pytest.mark.parametrize("place", [".", "r.txt/r.h5", "run.h5", "old.h5"])
def test_what_cannot_be_a_store_is_one_line(place, tmp_path, computed):
    (tmp_path / "r.txt").write_text("mine")
    simulate(GOOD, duration=1.0).save(tmp_path / "run.h5")
    old = scan(GOOD, duration=10.0)
    old.of_runs.clear()  # as versions before 2.0 wrote them
    old.save(tmp_path / "old.h5")
    computed.clear()
    words = "cannot be written|must end in .h5|a run, not results|no keys, as in files of earlier"
    with pytest.raises(InputError, match=rf"^[^\n]*({words})[^\n]*$"):
        scan(GOOD, store=tmp_path / place, duration=10.0)
    assert not computed


def test_a_store_keeps_errors_and_the_warning_of_loading(tmp_path):
    path, slow = tmp_path / "r.h5", ChainParameters(3, 1.0)
    said, found = [], []
    settings = {"duration": 400.0, "method": ["event", "event", "verlet"], "seed": [1, 2, 3]}
    for store in ({}, {"store": path}, {"store": path}):
        with pytest.warns(UserWarning) as caught:
            found.append(scan([BAD, slow, GOOD], on_error="nan", **settings, **store))
        said.append([str(warning.message) for warning in caught])
    results = found[0]
    for other in found[1:]:
        same(other, results)
    assert said[0] == said[1] == said[2] and len(said[0]) == 2
    assert list(Results.load(path)) == list(results)
    with pytest.raises(ModelStateError, match="u=150"):
        scan([BAD, slow, GOOD], store=path, **settings)
    with pytest.raises(ModelStateError, match="failed before"):
        scan([BAD, slow, GOOD], duration=10.0, initial_state=results.final_states)


def test_rows_of_a_store_keep_the_code_that_made_them_and_other_code_is_told(
    tmp_path, monkeypatch, recwarn
):
    for code, velocities, made_by, says in (
        ("a", [5.0], "a", ""),
        ("a", [5.0], "a", ""),
        ("b", [5.0], "a", "rows of code a, and this is b; a new file has those of this code alone"),
        ("b", [7.0], "a; b", ""),  # none of its rows is asked for
        ("b", [5, 7], "a; b", "rows of code a; b, and this is b; a new"),
        ("b.dirty", [8.0], "b.dirty", ""),
        ("b.dirty", [8.0], "b.dirty", "and this is b.dirty, which edits that no commit has may"),
    ):
        path = tmp_path / ("edited.h5" if "dirty" in code else "store.h5")
        monkeypatch.setattr(provenance, "code_version", lambda code=code: code)
        results = scan(Grid(2, velocities), duration=60.0, store=path)
        results.save(tmp_path / "some.h5")
        assert Results.load(tmp_path / "some.h5").settings["code_version"] == made_by
        said = [str(warning.message) for warning in recwarn if "store" in str(warning.message)]
        assert len(said) == bool(says) and says in "".join(said)
        recwarn.clear()


def test_a_catalogue_grows_too(tmp_path, computed):
    """Its rows are those of a call without a store, in the order and with the width of the call."""

    def interrupted(fraction):
        if fraction > 0.5:
            raise KeyboardInterrupt

    path, more = tmp_path / "c.h5", replace(GRID, replicates=range(4))
    with pytest.raises(KeyboardInterrupt):
        catalogue(GRID, store=path, progress=interrupted, **SHORT)
    few = [index for index in reversed(range(16)) if more.chains[index].n_blocks == 2]
    some = [more.chains[index] for index in few]
    for chains, count, how in (
        (GRID, 12, {}), (GRID, 12, {}), (more, 16, {}),
        (some, 16, {"replicate": [more.replicate[index] for index in few]}),
    ):  # fmt: skip
        found = catalogue(chains, store=path, **how, **SHORT)
        assert len(computed) == count
        kept, computed[:] = computed[:], []
        whole = catalogue(chains, **how, **SHORT)
        computed[:] = kept
        for name, rows in whole.items():
            assert rows.dtype == found[name].dtype and rows.tobytes() == found[name].tobytes()
            assert rows.size > 20
    with pytest.raises(InputError, match="section_block is the last there and 1 here"):
        catalogue(GRID, store=path, section_block=1, **SHORT)
    with pytest.raises(InputError, match=r"store of a catalogue; catalogue\(\.\.\., store='"):
        Results.load(path)
    bad = catalogue([GOOD, BAD], store=tmp_path / "b.h5", on_error="nan", **SHORT)
    again = catalogue([GOOD, BAD], store=tmp_path / "b.h5", on_error="nan", **SHORT)
    assert again["errors"].tolist() == bad["errors"].tolist() and len(bad["errors"]) == 1


def test_a_sweep_grows_and_goes_on_past_chains_that_fail(tmp_path, computed):
    path, values = tmp_path / "s.h5", {"belt_velocity": [10.0, 12.0, 10.0]}
    how = {"initial_spread": 1.0, **SHORT}

    def interrupted(fraction):
        if fraction > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(GOOD, replicate=range(2), store=path, progress=interrupted, **values, **how)
    sweep(GOOD, replicate=range(2), store=path, **values, **how)
    assert len(computed) in (6, 8)  # two may be ready before they are looked at
    computed.clear()
    found = sweep(GOOD, replicate=range(3), store=path, **values, **how)
    assert len(computed) == 3
    same(found, sweep(GOOD, replicate=range(3), **values, **how))
    with pytest.warns(UserWarning, match="the first at static_friction = 71.4: all chains"):
        lost = sweep(GOOD, static_friction=[71.4, 500, 71.4, 71.4], on_error="nan", **SHORT)
    failed = [False, False, True, True]  # springs that were so stretched throw blocks together
    assert np.isnan(lost["disorder_parameter"]).tolist() == failed
    assert [bool(line) for line in lost["error"]] == failed
    with pytest.raises(ModelStateError, match="u=150"):
        sweep(GOOD, belt_velocity=[150, 10], on_error="nan", **SHORT)


@functions
def test_arrays_of_a_store_are_as_wide_as_those_of_the_chains_asked_for(called, settings, tmp_path):
    path, short = tmp_path / "w.h5", [ChainParameters(2, 5.0), ChainParameters(11, 10.0)]
    called([ChainParameters(12, 10.0), *short], store=path, **settings)
    for chains in (short, short[:1]):
        same(called(chains, store=path, **settings), called(chains, **settings))


# --- tables that are joined, runs that go on ---


def test_joined_results_have_each_run_once(tmp_path):
    one, other = (scan(replace(GRID, replicates=range(a, b)), **SHORT) for a, b in ((0, 2), (1, 4)))
    one["own"], one["levels"] = ["a"] * 8, np.arange(3)
    one.save(tmp_path / "one.h5")
    for first in (one, Results.load(tmp_path / "one.h5")):
        both = first.joined(other)
        assert both["replicate"].tolist() == [0, 1] * 4 + [2, 3] * 4
        for name in other:
            np.testing.assert_array_equal(both[name][:8], one[name])
            np.testing.assert_array_equal(both[name][8:10], other[name][1:3])
        assert both.final_states[8] == other.final_states[1]
        assert both["own"].tolist() == ["a"] * 8 + [""] * 8 and both["levels"].shape == (3,)
        both.save(tmp_path / "both.h5")
        assert Results.load(tmp_path / "both.h5").final_states == both.final_states
    whole = scan(replace(GRID, replicates=4), store=tmp_path / "both.h5", **SHORT)
    assert whole["replicate"].tolist() == [0, 1, 2, 3] * 4  # what is saved goes on as a store
    np.testing.assert_array_equal(np.sort(whole["mean_length"]), np.sort(both["mean_length"]))
    heavy = ChainParameters(3, 5.0, mass=(1.0, 2.0, 1.0))
    mixed = scan(heavy, **SHORT).joined(one)
    np.testing.assert_array_equal(mixed["mass"][:2, :3], [[1.0, 2.0, 1.0], [1.0, 1.0, np.nan]])
    with pytest.raises(InputError, match=r"^other: kind is motion there and scan here"):
        one.joined(classify(GRID, **SHORT))
    with pytest.raises(InputError, match=r"^other = 5: Results are needed"):
        one.joined(5)
    settled = time_to_orbit(ChainParameters(2, 5.0), duration=1500.0)
    assert len(settled.joined(settled)["lifetime"]) == 1


@pytest.mark.parametrize("method", ["event", "verlet"])
def test_a_continued_scan_has_the_bits_of_a_long_one(method, tmp_path):
    chains = [ChainParameters(2, 5.0, 1.0), GOOD, ChainParameters(5, 10.0, 1.0)]
    settings = {"method": method, "replicate": [3, 0, 1]}
    section = {"section_position": [180.0, 600.0, 600.0]}
    first = scan(chains, duration=250.0, **settings, **section)
    first.save(tmp_path / "first.h5")
    whole = scan(chains, duration=500.0, **settings, **section)
    assert whole["section_count"].min() > 5
    runs = simulate(chains, duration=500.0, sample_interval=None, **settings)
    assert whole.final_states == [run.final_state for run in runs]
    for states in (first.final_states, Results.load(tmp_path / "first.h5").final_states):
        assert states == first.final_states
        later = scan(chains, duration=250.0, method=method, initial_state=states, **section)
        assert later.final_states == whole.final_states
        assert later["replicate"].tolist() == [3, 0, 1]
        for name in ("last_stick_time", "energy_residual"):
            np.testing.assert_array_equal(later[name], whole[name])
        for name in ("slip_count", "section_count"):
            np.testing.assert_array_equal(later[name] + first[name], whole[name])
        mean = (later["mean_length"] + first["mean_length"]) / 2
        np.testing.assert_allclose(mean, whole["mean_length"], rtol=1e-12)


def test_a_grid_has_the_replicates_that_are_named():
    assert Grid(2, [5.0, 6.0], replicates=range(4, 6)).replicate == (4, 5, 4, 5)
    with pytest.raises(InputError, match=r"^replicates = \[1, 1\]: each may be there once"):
        Grid(2, 5.0, replicates=[1, 1])


def test_a_store_tells_sections_apart_to_the_last_bit(tmp_path, computed):
    place = [250.0, np.nextafter(250.0, 300.0)]
    how = SHORT | {"section_position": place, "store": tmp_path / "r.h5"}
    for _ in range(2):
        assert scan([GOOD, GOOD], **how)["section_position"].tolist() == place
    assert len(computed) == 2

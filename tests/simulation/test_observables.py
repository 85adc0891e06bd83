"""Observables of runs and catalogues: the same of both, against plain loops, and of the studies."""

from dataclasses import replace

import numpy as np
import pytest

from beltrepro import (
    ChainParameters,
    avalanche_energies,
    catalogue,
    section,
    simulate,
    slip_sizes,
    spectrum,
)
from beltrepro.base.errors import InputError
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.avalanches import measure
from made_up import few_resamples  # noqa: F401 shorter

pytestmark = pytest.mark.filterwarnings("ignore:.*loading is measured:UserWarning")
CHAINS = [ChainParameters(3, 8.0, 1.0, mass=(1, 3, 1)), ChainParameters(5, 2.0)]
LENGTHS = {"duration": 400.0, "transient": 150.0}


@pytest.fixture(scope="module")
def runs():
    return simulate(CHAINS, **LENGTHS)


@pytest.fixture(scope="module")
def records():
    return catalogue(CHAINS, **LENGTHS)


def same(one, other):
    return (
        one.values.tolist() == other.values.tolist()
        and len(one) > 5
        and (one.chain.tolist() == other.chain.tolist())
    )


def test_slips_and_avalanches_of_runs_are_those_of_a_catalogue(runs, records):
    for frame in ("laboratory", "belt"):
        assert same(slip_sizes(runs, frame=frame), slip_sizes(records, frame=frame))
    for how in ({}, {"last_block": False}, {"last_block": False, "least_blocks": 2}):
        assert same(avalanche_energies(runs, **how), avalanche_energies(records, **how))
    one = slip_sizes(runs[1])
    assert one.values.tolist() == slip_sizes(runs).values[slip_sizes(runs).chain == 1].tolist()
    later = simulate(CHAINS[1], initial_state=runs[1].final_state, duration=200, transient=50)
    kept = later.events["time"] >= 450
    assert later.events["time"][0] < 450 and kept.any()
    starts = later.events[kept & (later.events["block"] == 5) & (later.events["kind"] == "slip")]
    assert 0 <= starts.size - len(slip_sizes(later, frame="belt")) <= 1


def test_slip_sizes_by_a_plain_loop_over_the_events_of_the_last_block(runs):
    # of hardly any kinetic friction, so that many slips are forward, which have no size
    smooth = simulate(ChainParameters(3, 8.0, friction_ratio=0.1), duration=400.0)
    for run in (*runs, smooth):
        sizes, begun = {"laboratory": [], "belt": []}, None
        for event in run.events[run.events["block"] == run.parameters.n_blocks]:
            if event["kind"] == "slip":
                begun = event
            elif begun is not None and begun["time"] >= run.transient:
                size = begun["position"] - event["position"]
                sizes["laboratory"].append(size)
                lasting = event["time"] - begun["time"]
                sizes["belt"].append(size + run.parameters.belt_velocity * lasting)
        for frame, expected in sizes.items():
            expected = [size for size in expected if size > 0]
            assert slip_sizes(run, frame=frame).values == pytest.approx(expected, rel=1e-12)


def test_energies_of_avalanches_add_up_to_those_of_all_slips_in_them(runs):
    """Of all blocks, and of those avalanches alone in which the last one slips."""
    run = runs[1]
    energies = avalanche_energies(run)
    assert 0 < len(energies) < len(avalanche_energies(run, last_block=False))
    rows = catalogue(CHAINS[1], **LENGTHS)
    totals = []
    for one in rows["avalanches"]:
        slips = rows["slips"]
        inside = (slips["start_time"] >= one["start_time"]) & (
            slips["stop_time"] <= one["stop_time"]
        )
        if np.any(slips["block"][inside] == 5):
            totals.append(slips["dissipated"][inside].sum())
    assert energies.values == pytest.approx(totals)
    several = rows["avalanches"]["blocks"] >= 2
    energies = avalanche_energies(rows, last_block=False, least_blocks=2)
    assert energies.values.tolist() == rows["avalanches"]["dissipated"][several].tolist()
    assert 0 < several.sum() < several.size


def test_the_spectrum_of_a_run_is_that_of_its_last_block_after_the_transient(runs):
    alone = spectrum(runs[0])
    values = runs[0].positions[runs[0].time >= 150, 2]
    given = spectrum(values, sample_interval=0.1)
    np.testing.assert_allclose(alone.power, given.power, rtol=1e-9)
    assert 0.0039 < alone.frequency[0] < 0.0041
    later = simulate(CHAINS[1], initial_state=runs[1].final_state, duration=200, transient=50)
    kept = spectrum(later.positions[later.time >= 450, 4], sample_interval=0.1)
    np.testing.assert_allclose(spectrum(later).power, kept.power, rtol=1e-9)
    with pytest.warns(UserWarning, match="runs of 2 chains: this is the mean of their spectra"):
        both = spectrum([runs[0], runs[1]])
    np.testing.assert_allclose(both.power, (alone.power + spectrum(runs[1]).power) / 2)
    assert not alone.plot().get_legend()
    assert alone.exponent(0.3, 2).runs == 7 and both.exponent(0.3, 2).runs == 14
    law = alone.law(0.3, 2)
    ax = alone.plot(law=law, color="red")
    pale, medians, fitted = ax.lines
    assert np.array_equal(pale.get_xydata(), np.transpose([alone.frequency, alone.power]))
    assert {medians.get_color(), pale.get_color()} == {"red"} and ax.get_yscale() == "log"
    np.testing.assert_allclose(fitted.get_xydata().T, [(0.3, 2), law([0.3, 2])])
    assert f"exponent {law.exponent.value:.3g} (" in fitted.get_label()


def test_a_spectrum_of_a_belt_that_changes_says_so():
    run = simulate(ChainParameters(2, 5.0), belt=[(0, 5.0), (50, 9.0)], duration=100)
    with pytest.warns(UserWarning, match="of all velocities together"):
        spectrum(run)


def test_the_law_of_a_spectrum_has_the_digits_of_the_study(runs):
    series = Dataset({"time": runs[1].time, "positions": runs[1].positions}, {"transient": 150.0})
    judged = measure.spectral_law(series, band=(0.4, 3.0)).judged
    law = spectrum(runs[1]).law(0.4, 3)
    for name, ours in (("exponent", law.exponent), ("prefactor", law.prefactor)):
        assert judged[name].numbers == ours.numbers
    about = measure.spectral_law(series, band=(0.4, 3.0), amplitude=True).judged["exponent"]
    assert about.numbers == pytest.approx(law.exponent.scaled(0.5).numbers, rel=1e-9)


def test_a_section_of_slow_belts_keeps_its_points():
    tiny = {"static_friction": 71.4e-8, "rest_length": 50e-8, "linear_limit": np.inf}
    chains = [ChainParameters(3, 10.0, linear_limit=np.inf), ChainParameters(3, 10e-8, **tiny)]
    points = [len(section(catalogue(chain, duration=400, transient=100))) for chain in chains]
    assert points[0] == points[1] > 5


def test_a_section_is_of_the_last_block_where_it_slips():
    chain = ChainParameters(5, 10.0, 1.0)
    records = catalogue([chain] * 2, replicate=range(2), section_block=2, **LENGTHS)
    points, found = records["section"], section(records)
    relative = points["velocities"][:, 4] - 10
    slips = relative < -1e-6
    assert 5 < slips.sum() < slips.size
    assert found["relative_velocity"].tolist() == relative[slips].tolist()
    assert found["position"].tolist() == points["positions"][slips, 4].tolist()
    assert found["point"].tolist() == points["point"][slips].tolist()
    assert not found["repeated"].any()
    assert repr(found) == f"SectionPoints({len(found)} points of 2 chains)"
    assert type(found["position"]) is np.ndarray and repr(found == found).startswith("Sect")
    for how in ({}, {"density": True}):
        ax = found.plot(**how)
        assert ax.get_ylabel() == "$v_N - u$ (model velocity)"
    (mesh,) = ax.collections
    corner, share = np.asarray(mesh.get_coordinates()), np.ma.filled(mesh.get_array(), 0.0)
    cells = np.outer(np.diff(corner[:, 0, 1]), np.diff(corner[0, :, 0]))
    assert np.sum(cells * share) == pytest.approx(1)
    with pytest.raises(InputError, match="color: a density has many"):
        found.plot(density=True, color="grey")
    with pytest.raises(InputError, match="at none the last block slips"):
        found[:0].plot()
    line = found.copy()
    line["position"] = 314.3 * (1 + 1e-16 * np.arange(len(line)))  # as at the section of this block
    with pytest.raises(InputError, match=r"density = True: x_N is 314.3 at all points.*draw the"):
        line.plot(density=True)
    with pytest.warns(UserWarning, match="repeat another bit by bit"):
        twice = section(catalogue([CHAINS[1]] * 2, **LENGTHS))
    again, half = twice["repeated"], len(twice) // 2
    assert half >= 3 and again[half:].all() and not again[:half].all()


def test_points_say_something_new_in_each_unit_of_time():
    repeated = []
    for unit in (1.0, 10.0, 0.1, 0.01):
        mass = tuple(unit**2 * np.array([1, 1.5, 2]))
        chain = ChainParameters(3, 11 / unit, friction_ratio=0.4, mass=mass)
        points = section(catalogue(chain, duration=1500 * unit, transient=200 * unit))
        repeated.append(points["repeated"].tolist())
    assert len(repeated[0]) == 73 and repeated == repeated[:1] * 4
    assert 0 < sum(repeated[0]) < 36


def test_what_is_no_source_is_one_line_that_says_what_is(runs, records):
    later = replace(runs[1].initial_state, time=0.05)  # as many samples, one less after 150
    shorter = replace(runs[1], time=runs[1].time - 0.05, initial_state=later)
    calls = [
        (lambda: spectrum(runs[0], sample_interval=1.0), "sample_interval: not together with runs"),
        (lambda: spectrum([runs[0], 5]), r"runs = .*: a Run, a sequence of them"),
        (lambda: spectrum(np.ones(99)), "sample_interval = None: a number is needed"),
        (
            lambda: spectrum([runs[0], simulate(CHAINS[0], duration=9)]),
            "at one interval, over one time",
        ),
        (lambda: spectrum([runs[1], shorter]), "at one interval, over one time"),
        (lambda: spectrum(np.ones((99, 3)), sample_interval=1.0), r"runs of shape \(99, 3\): \(R"),
        (lambda: slip_sizes(5), "source = 5: the Catalogue of some chains, a Run or a sequence"),
        (lambda: section(runs[0]), "the Catalogue of some chains is needed, whose crossings"),
        (lambda: section(records), r"chains of \[3, 5\] blocks; those of one N are needed"),
    ]
    for call, text in calls:
        with pytest.raises(InputError, match=text) as caught:
            call()
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 300

"""Everything that a public function returns: table, fields by name, a short line, notebooks."""

import dataclasses
import warnings

import h5py
import matplotlib.figure
import numpy as np
import pytest

from beltrepro import (
    ChainParameters,
    ChainState,
    Grid,
    Results,
    Run,
    basins,
    catalogue,
    classify,
    lyapunov_spectrum,
    orbit_branch,
    periodic_orbit,
    scan,
    section,
    simulate,
    slipping_state,
    spectrum,
    time_to_continuous_slip,
)  # fmt: skip
from beltrepro.base import provenance, store
from beltrepro.base.errors import InputError

pytestmark = pytest.mark.filterwarnings("ignore:.*loading is measured:UserWarning")
CHAIN = ChainParameters(2, 10.0)


@pytest.fixture(scope="module")
def returned():
    """A result of each public type, by the name of the type."""
    run = simulate(CHAIN, duration=50, transient=20)
    orbit = periodic_orbit(ChainParameters(1, 5.0), duration=200, transient=100)
    results = [
        run,
        scan([CHAIN], duration=50, transient=20),
        catalogue(CHAIN, duration=50, transient=20),
        classify(CHAIN, duration=60, transient=20),
        lyapunov_spectrum(CHAIN, duration=60, transient=20),
        orbit,
        orbit_branch(orbit, lower=4.9, upper=5.1),
        basins(ChainParameters(1, 5.0), duration=1000),
        spectrum(run),
        section(catalogue(CHAIN, duration=99, transient=20)),
    ]
    return {type(result).__name__: result for result in results}


PICTURES = [
    *((kind, "plot") for kind in ("Basins", "Catalogue", "LyapunovSpectrum", "OrbitBranch")),
    *(("Run", f"plot_{what}") for what in ("length", "slips", "phase")),
    *(("Results", name) for name in ("plot", "plot_section")),
    ("Basins", "plot_shares"), ("Catalogue", "plot_slips"), ("PeriodicOrbit", "plot"),
    ("PowerSpectrum", "plot"), ("SectionPoints", "plot"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "name"), PICTURES)
def test_a_picture_of_one_panel_goes_where_it_is_told(kind, name, returned, tmp_path):
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("agg")
    plot = getattr(returned[kind], name)
    figure = matplotlib.figure.Figure()
    ax = figure.subplots()
    assert plot(ax=ax) is ax and ax.has_data() and ax.get_xlabel() and ax.get_ylabel()
    alone = plot()
    assert alone.figure.get_figwidth() == pytest.approx(8.6 / 2.54)
    for path in (tmp_path / "alone.png", tmp_path / "panel.pdf"):
        assert plot(path, **{"ax": ax} if path.suffix == ".pdf" else {}) is not None
        assert path.stat().st_size > 3000
    assert not plt.get_fignums() and len(list(tmp_path.iterdir())) == 2
    with pytest.raises(InputError, match="'axs'; did you mean 'ax"):
        plot(axs=ax)
    with pytest.raises(InputError, match="must end in"):
        plot("picture.jpg")


@pytest.mark.parametrize(
    "kind",
    ["Basins", "Catalogue", "LyapunovSpectrum", "Motion", "OrbitBranch", "PeriodicOrbit",
     "Results", "Run"],
)  # fmt: skip
def test_a_result_has_a_table_a_line_and_its_parts_by_name(kind, returned):
    result = returned[kind]
    table = result.table()
    assert len(table) and table.columns.is_unique and len(repr(result)) < 1000
    assert "\n" not in repr(result) and "array(" not in repr(result)
    assert "<table" in result._repr_html_() and "Traceback" not in result._repr_html_()
    if dataclasses.is_dataclass(result):
        name = dataclasses.fields(result)[0].name
        assert result[name] is getattr(result, name)
        with pytest.raises(InputError, match="did you mean"):
            result[name + "x"]


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """Results with vectors of several lengths, text and truth values, and their file."""
    path = tmp_path_factory.mktemp("results") / "r.h5"
    chains = [ChainParameters(3, u, mass=(1, 2, 1)) for u in (5.0, 10.0)]
    results = scan(chains, duration=50, section_values=0)
    results["escaped"] = np.array([True, False])
    results.save(path)
    return results, path


def test_a_file_of_results_names_axes_and_units(saved, tmp_path):
    results, path = saved
    mixed = {"return_state": np.zeros((2, 6))}
    Results(results | mixed, results.settings).save(tmp_path / "m.h5")
    with h5py.File(tmp_path / "m.h5") as file:
        text = "model length (1.4 mm), then model velocity (0.0183 m/s)"
        assert file["return_state"].attrs["units"] == text
    with h5py.File(path) as file:
        axes = [[axis[0].name for axis in file[name].dims] for name in ("mass", "slip_count")]
        units = [file[name].attrs["units"] for name in ("belt_velocity", "slip_count", "mass")]
    assert axes == [["/chain", "/block"], ["/chain", "/block_10"]]
    assert units == ["model velocity (0.0183 m/s)", "1", "model mass (0.116 kg)"]
    loaded = Results.load(path)
    assert list(loaded) == list(results) and "coordinates" not in loaded.settings
    assert {name for name in store.read(path).arrays if "/" not in name} == set(results)
    loaded.settings["code_version"] = "1.9"  # saved anew they are what that version made
    loaded.save(path.with_name("again.h5"))
    assert Results.load(path.with_name("again.h5")).settings == loaded.settings
    store.write(path.with_name("old.h5"), results, {"kind": "scan"})  # as before version 2.0
    assert set(Results.load(path.with_name("old.h5"))) == set(results)


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_xarray_opens_a_file_of_results(saved, engine):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip(engine.replace("cdf4", "CDF4"))
    results, path = saved
    with xarray.open_dataset(path, engine=engine) as opened:
        assert dict(opened.sizes) == {"chain": 2, "block": 3, "block_10": 10, "crossing": 0}
        assert set(opened.coords) == {"belt_velocity"} and set(opened.variables) == set(results)
        for name in ("mass", "slip_count", "escaped"):
            np.testing.assert_array_equal(opened[name], results[name])


def test_results_by_chain_and_from_a_file(returned, tmp_path):
    results = scan(Grid(2, [5.0, 10.0], replicates=2), duration=50, initial_spread=1)
    assert results[2]["belt_velocity"] == 10.0 and results[-1]["replicate"] == 1
    assert len(list(results[0]["slip_count"])) == 10
    with pytest.raises(IndexError):
        results[4]
    results.save(tmp_path / "r.csv")
    lines = (tmp_path / "r.csv").read_text().splitlines()
    assert len(lines) == 5 and lines[0].split(",") == results.table().columns.tolist()
    results.save(tmp_path / "r.h5")
    loaded = Results.load(tmp_path / "r.h5")
    assert loaded.settings.items() >= results.settings.items()
    assert list(loaded) == list(results) and "columns" not in loaded.settings
    for name, array in results.items():
        np.testing.assert_array_equal(loaded[name], array)
    returned["Run"].save(tmp_path / "run.h5")
    for result in (returned["Run"], results):
        with pytest.raises(InputError, match=r"run.npz: must end in .*\.h5$"):
            result.save(tmp_path / "run.npz")
    with pytest.raises(InputError, match=r"a run, not results; Run\.load reads"):
        Results.load(tmp_path / "run.h5")
    for kind in (Results, Run):
        with pytest.raises(InputError, match=r"r\.csv: pandas.read_csv reads a table"):
            kind.load(tmp_path / "r.csv")
    for name, meant in (("r", "disorder_parameter"), ("slip_counts", "slip_count")):
        with pytest.raises(KeyError, match=f"no array '{name}'; did you mean '{meant}'"):
            results[name]
    for other in ("zzz", ["replicate"], slice(2), None, True):
        with pytest.raises(KeyError, match=r"no array .*: there are n_blocks, belt_velocity, "):
            results[other]


SLIDING = ChainParameters(1, 5.0, static_friction=10.0)  # slips for ever once its spring is linear


@pytest.mark.parametrize(
    ("chains", "options", "says"),
    [
        (ChainParameters(5, 10.0), {"section_position": 99999.0},
         r"N=5, u=10, sigma=0: x_5 runs from 463\.\d+ to 759\.\d+, never down through 99999$"),
        (ChainParameters(5, 10.0), {"section_block": 1, "section_position": 300.0},
         r"x_1 runs from 101\.\d+ to 199\.\d+, never down through 300$"),
        (SLIDING, {"initial_state": ChainState.in_motion(SLIDING, [57.0], [0.0])},
         "N=1, .*, static_friction=10: no slip begins and ends: all blocks slip from t = 0 on$"),
        ([ChainParameters(5, 10.0), ChainParameters(5, 1e-3)], {},
         r"^1 of 2 chains: N=5, u=0\.001, .*: no slip .*: all blocks stick from t = 0 on; x_5"),
        (ChainParameters(3, 30.0), {}, "sigma=0: no avalanche from one rest of all blocks to the"),
    ],
)  # fmt: skip
def test_a_catalogue_without_rows_says_what_the_chain_did_instead(chains, options, says):
    with pytest.warns(UserWarning, match=says):
        catalogue(chains, duration=400.0, transient=100.0, **options)
    if "section_position" in options and "section_block" not in options:
        runs = r"no chain comes down .* from 463\.\d+ to 759\.\d+"
        for several, which in ((chains, "$"), ([ChainParameters(2, 10.0), chains], " in the one")):
            with pytest.warns(UserWarning, match=runs + which):
                scan(several, duration=400.0, transient=100.0, **options)


def test_samples_of_a_run_have_a_column_for_each_block(returned):
    run = returned["Run"]
    table = run.table()
    np.testing.assert_array_equal(table["position_2"], run.positions[:, 1])
    assert len(table) == len(run.time) and "velocity_1" in table
    assert run.version == provenance.code_version()  # with its commit


def test_constants_that_differ_among_blocks_have_columns_of_their_own():
    masses = ((1.0, 2.0, 1.0), (2.0, 1.0, 1.0))
    chains = [ChainParameters(3, 10.0, 1.0, mass=mass) for mass in masses]
    table = scan(chains, duration=60.0, transient=20.0).table()
    assert table[["mass_1", "mass_2", "mass_3"]].to_numpy().tolist() == [[*m] for m in masses]
    shared = scan(chains[:1] * 2, duration=60.0, transient=20.0, replicate=range(2)).table()
    assert shared[["mass_1", "mass_2", "mass_3"]].to_numpy().tolist() == [[*masses[0]]] * 2


def test_a_catalogue_has_a_table_of_each_array(returned):
    catalogue = returned["Catalogue"]
    for name in ("slips", "avalanches"):
        table = catalogue.table(name)
        assert table.columns.tolist() == list(catalogue[name].dtype.names)
        np.testing.assert_array_equal(table["start_time"], catalogue[name]["start_time"])
    section = catalogue.table("section")
    np.testing.assert_array_equal(section["velocity_2"], catalogue["section"]["velocities"][:, 1])
    with pytest.raises(InputError, match=r"kind = 'slip': allowed are .* did you mean 'slips'"):
        catalogue.table("slip")
    assert repr(catalogue).startswith(f"Catalogue({len(catalogue['slips'])} slips, ")


# --- too short for a laminar phase ----------------------------------------------------------------


def test_a_run_too_short_for_a_laminar_phase_has_no_share_of_them():
    """Its only block slips all the time."""
    chain = ChainParameters(1, 1000.0, rest_length=1e4)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a spring so long is compressed beyond all numbers
        start = slipping_state(chain, 40.0)
    short, long = (scan(chain, duration=time, initial_state=start) for time in (150.0, 250.0))
    assert np.isnan([short["laminar_fraction"], short["laminar_longest"]]).all()
    assert long["laminar_fraction"] == 1 and long["laminar_longest"] == 250
    with pytest.warns(match="duration = 150: no chain escapes in it whose laminar_time is 200"):
        time_to_continuous_slip(chain, duration=150.0, initial_state=start)


# --- what others put in or read -------------------------------------------------------------------


def test_columns_of_ones_own_are_in_the_table_if_they_have_a_number_for_each_chain():
    results = scan([ChainParameters(1, 10.0), ChainParameters(1, 20.0)], duration=60, transient=20)
    results["mine"], results["note"] = [1, 2], "of today"
    assert results.table()["mine"].tolist() == [1, 2] and "note" not in results.table()
    assert results[1]["mine"] == 2


def test_a_dataset_is_not_taken_for_results(tmp_path):
    store.write(tmp_path / "n5.h5", {"replicate": np.zeros(3), "noise": np.ones(3)}, {})
    with pytest.raises(InputError, match="not a file of results: it lacks n_blocks"):
        Results.load(tmp_path / "n5.h5")

"""Branches and basins: what is recorded of small chains, and tables of made-up data."""

import numpy as np
import pytest

import figure_data
from beltrepro import ChainParameters, Setup, orbit_branch, periodic_orbit, sliding_energy
from beltrepro.replication.plan import attractors as attracted
from beltrepro.replication.plan.attractors import basin_starts, births, sweeps
from beltrepro.replication.studies.fall import measure
from beltrepro.replication.verdicts.criteria import IN_PART, NO, OPEN, YES
from beltrepro.stats.estimates import share
from made_up import data, few_resamples, grades, measured, settled  # noqa: F401

ELSEWHERE = {"duration": 4000.0, "transient": 2000.0}


@pytest.fixture(scope="module")
def recorded():
    """Two blocks at two belt velocities, three starts each."""
    chains = [ChainParameters(2, u) for u in (19.0, 20.0) for _ in range(3)]
    setup = Setup(chains, replicate=2 * [1, 2, 3], initial_spread=5.0)
    return basin_starts(setup, duration=4000.0, energies=[1.0, 600.0])


def test_starts_of_each_kind_are_recorded(recorded):
    assert recorded["attractor"].shape == recorded["disorder_parameter"].shape == (6, 3)
    assert recorded["start_energy"].tolist() == [0.0, 1.0, 600.0]
    # H below u^2 / 2: no block reaches the belt
    assert np.all(recorded["state"][:, 1] == "equilibrium slip")
    assert np.all(recorded["state"][:, 0] == "periodic")
    # by the first point of each u; each label that a start reaches is there
    assert set(recorded["attractors"]["point"]) == {0, 3}
    for point in (0, 3):
        there = recorded["attractors"]["attractor"][recorded["attractors"]["point"] == point]
        assert set(recorded["attractor"][point : point + 3].ravel()) <= set(there)


def test_an_energy_of_starts_is_that_of_a_block(monkeypatch):
    begun = []
    monkeypatch.setattr(attracted, "basins", lambda setup, **how: begun.append(setup) or 1 / 0)
    for n_blocks in (2, 5):
        with pytest.raises(ZeroDivisionError):
            basin_starts(Setup([ChainParameters(n_blocks, 20.0)]), duration=400.0, energies=[3.0])
        state = begun[-1].initial_state[1]
        energy = sliding_energy(state.parameters, state.positions, state.velocities)
        assert energy / n_blocks == pytest.approx(3.0)


def test_branches_are_recorded_with_their_ends(recorded):
    orbits = recorded["branches"]
    orbit = periodic_orbit(ChainParameters(2, 19.0), **ELSEWHERE)
    branch = orbit_branch(orbit, lower=19.0, upper=20.0)
    alike = orbits[(orbits["point"] == 0) & (orbits["period_events"] == orbit.period_events)]
    first = alike[alike["attractor"] == alike["attractor"][0]]
    assert first["belt_velocity"][-1] == branch.upper
    assert [*first["end"][[0, -1]]] == [branch.lower_end.kind, branch.upper_end.kind]
    assert not np.any(first["end"][1:-1])
    r = branch.disorder_parameter[[0, -1]]
    assert first["disorder_parameter"][[0, -1]] == pytest.approx(r, rel=1e-6)


def test_a_sweep_goes_on_from_the_point_before():
    # of two blocks one orbit is left at the ends; between them the way decides
    chains = [ChainParameters(2, u) for u in (23.0, 19.75, 18.8, 20.0, 19.0, 20.5, 19.5)]
    swept = sweeps(Setup(chains), duration=400.0, transient=200.0)["disorder_parameter"]
    assert swept.shape == (7, 2)
    order = np.argsort([chain.belt_velocity for chain in chains])
    up, down = swept[order].T
    assert up[[0, -1]] == pytest.approx(down[[0, -1]], rel=0.03)
    assert np.all(np.abs(up[3:5] / down[3:5] - 1) > 0.05)  # hysteresis, of two orbits


@pytest.fixture(scope="module")
def born():
    """Births of an orbit of five slips, with the paper's springs and with linear ones."""
    chains = [ChainParameters(5, u, linear_limit=limit) for limit, u in ((20, 18), (1e9, 22))]
    starts = Setup(
        [one for one in chains for _ in range(3)], replicate=[1, 2, 3] * 2, initial_spread=10
    )
    told = {"duration": 20000.0, "slips": [5], "friction_ratios": [0.4, 0.45, 0.5]}
    return births(starts, **told)["births"]


@pytest.mark.thorough
def test_births_with_the_springs_of_the_paper(born):
    here = np.sort(born[born["point"] == 0], order="friction_ratio")
    assert here["friction_ratio"].tolist() == [0.4, 0.45, 0.5]
    # as followed by an outside program
    assert here["belt_velocity"] == pytest.approx([18.91, 17.10, 15.36], abs=0.01)
    assert set(here["end"]) == {"grazing"} and set(here["end_block"]) == {5}


@pytest.mark.thorough
def test_births_of_linear_springs_lie_on_a_straight_line(born):
    here = born[born["point"] == 3]
    scaled = here["belt_velocity"] / ((1 - here["friction_ratio"]) * 71.4)
    assert len(here) == 3 and scaled == pytest.approx(scaled[0], rel=1e-7)
    # a mode grows there, and no block comes to touch the belt
    assert set(here["end"]) == {"torus"}


def test_shares_of_made_up_starts():
    data = figure_data.branching()
    table = measure.basin_shares(data)
    assert len(table) == 6 * 3 and np.all(table["runs"] == 4)
    # at u = 20 of five blocks starts at rest end at small r from run 1 on, those of H = 600 never
    at = table[(table["n_blocks"] == 5) & (table["belt_velocity"] == 20)]
    assert at[at["start_energy"] == 0]["share"].item() == 0.75
    assert at[at["start_energy"] == 600]["share"].item() == 0.0
    assert np.all(at["low"] <= at["share"]) and np.all(at["share"] <= at["high"])


def test_shares_of_ends_over_ranges_of_the_belt_velocity():
    table = figure_data.dataset("fall_shares")
    shares = table.pivot_table(index="begin", columns="end", values="share")
    assert table["begin"].unique().tolist() == np.arange(14, 22, 0.5).tolist()
    assert (table["runs"] == 5 * 8).all()
    assert shares["small r"].tolist() == pytest.approx([0] * 6 + [0.4] + [0.5] * 9)
    of_small = shares[["5", "11", "23", "other of small r"]]
    assert of_small.loc[18:].to_numpy() == pytest.approx(1 / 8)
    assert shares["33"].loc[18:].to_numpy() == pytest.approx(1 / 8)
    assert shares.drop(columns="small r").sum(axis=1).to_numpy() == pytest.approx(1)


def test_lifetimes_over_ranges_of_the_belt_velocity():
    table = figure_data.dataset("chaos_lifetimes")
    wide, near = (table[table["width"] == width] for width in measure.WIDTHS.values())
    assert wide["settled"].tolist() == [1] * 15 + [pytest.approx(1 / 5)]
    assert (wide["lifetime"].iloc[:15] == 1000).all() and (wide["slips"] == 100).all()
    assert near["begin"].to_numpy() == pytest.approx(10.74 + 0.002 * np.arange(10))
    assert near["settled"].to_numpy()[:7] == pytest.approx(1)
    assert near["settled"].to_numpy()[8:] == pytest.approx(0) and near["slips"].isna().sum() == 2


def test_contraction_of_made_up_runs():
    table = figure_data.dataset("contraction").set_index("n_blocks")
    # ten blocks are irregular at nearly all u, two never
    assert table["irregular"][2] == 0 < table["irregular"][10] and table["exponent"][
        2
    ] == pytest.approx(-0.01, abs=1e-4)
    assert np.isnan(table["exponent_irregular"][2]) and table["exponent_irregular"][10] > 0
    assert (table["exponent_low"] <= table["exponent"]).all() and table["erased"][10] == 10


def test_the_mean_lifetime_counts_the_time_of_runs_that_did_not_settle():
    size, settled = np.repeat([5, 6, 7], 8), np.arange(24) < 12
    arrays = {"n_blocks": size, "belt_velocity": np.full(24, 30.0), "settled": settled}
    arrays["lifetime"] = np.where(settled, 500.0, 2000.0)
    five, six, seven = (measure.mean_lifetime(arrays, n) for n in (5, 6, 7))
    assert (five.value, six.value) == (500, (4 * 500 + 4 * 2000) / 4) and five.low < 500 < five.high
    assert seven.value == np.inf > seven.low > 2000
    assert np.isnan(measure.mean_lifetime(arrays, 8).value)
    arrays["belt_velocity"][:] = 20.0
    assert np.isnan(measure.mean_lifetime(arrays, 5).value)


def test_a_time_step_as_a_noise():
    # thresholds that scatter like those of slips that begin late by up to a step
    late = np.random.default_rng(0).uniform(0, 0.001, 100_000)
    last, inside = measure.noise_of_step(18.5, 0.001)
    assert (18.5 * late).std() == pytest.approx(last, rel=0.01) and inside == 2 * last


def test_a_share_over_velocities_knows_how_these_scatter():
    u = np.repeat(np.arange(10.0), 20)
    mixed, apart = np.tile([0, 1], 100), (u % 2).astype(int)
    close, wide = measure.share_over(u, mixed), measure.share_over(u, apart)
    assert close.value == wide.value == 0.5 and close.high < 0.58 < 0.8 < wide.high < 0.9
    assert measure.share_over(u, 0 * apart).high == pytest.approx(share(0, 200).high)


def test_birth_lines_count_velocities_in_the_unit_of_linear_springs():
    table = figure_data.dataset("birth_lines")
    assert len(table) == 12
    for (linear, slips), line in table.groupby(["linear", "slips"]):
        assert line["scaled"].to_numpy() == pytest.approx(0.4 + 0.1 * linear - slips / 400)


def test_the_onset_of_small_r():
    u = np.arange(8.0, 28, 0.125)
    small = (u >= 17.25) & ~((u > 19) & (u < 22))  # and orbits of large r above
    small[np.isin(u, [10, 12.5])] = True
    found = measure.onset(u, small)
    assert found.value == 17.5 and found.low < 17.1 and found.high < 19.1
    assert np.isnan(measure.onset(u, u < 0).value)


# --- what explains the fall of r ------------------------------------------------------------------

VELOCITIES = np.arange(14.0, 22)


def five_slips(ratios, velocities):
    """The orbit of five slips, born at these velocities."""
    line = np.zeros(len(ratios), attracted.BIRTH)
    line["period_events"], line["friction_ratio"] = 5, ratios
    line["belt_velocity"], line["end"] = velocities, "grazing"
    constants = {"linear_limit": np.array([20.0]), "static_friction": np.array([71.4])}
    return data(constants | {"births": line})


def upwards(fall, runs=8):
    """Sweeps with two noises, without which they fall at u, some of them one later."""
    u, noise, run = map(np.ravel, np.meshgrid(VELOCITIES, [0.0, 1.0], np.arange(runs)))
    small = np.where(noise == 0, u >= fall + (run % 3 == 0), u >= 15)
    r = np.stack([np.where(small, 0.02, 0.12), np.full(u.size, 0.02)], axis=1)  # down: small
    arrays = {"belt_velocity": u, "noise": noise, "replicate": run, "disorder_parameter": r}
    return data(arrays)


@pytest.mark.parametrize(
    ("falls", "verdict"),
    [
        ((20, 19, 18), YES),
        ((18, 18, 18), OPEN),
        ((18, 19, 20), IN_PART),  # the wrong way
        ((15, 15, 16), NO),
    ],
)
def test_when_sweeps_fall(falls, verdict):
    names = ("sweeps_fast", "sweeps", "sweeps_slow")
    swept = {name: upwards(fall) for name, fall in zip(names, falls, strict=True)}
    swept["small_orbits"] = five_slips([0.4, 0.45], [18.9, 17.1])
    assert grades("fall-by-hold", **swept)[""] == verdict
    numbers = measured("fall-by-hold", **swept).numbers
    assert [numbers[name].value for name in ("shortest", "longest")] == [falls[0], falls[-1]]


@pytest.mark.parametrize(
    ("away", "verdict", "near_second"),
    [(lambda f: 0.2, YES, 0), (lambda f: 3.0, NO, 1), (lambda f: 40 * (f - 0.5), NO, 0.23)],
)
def test_falls_at_births_over_friction_ratios(away, verdict, near_second):
    """And near those of a second orbit, 3 above."""
    ratios = np.round(np.arange(0.4, 0.61, 0.02), 2)
    f, u = map(np.ravel, np.meshgrid(ratios, np.arange(6.25, 30, 0.5)))
    place = 19 - 35 * (f - 0.4) + np.vectorize(away)(f)
    arrays = {"friction_ratio": f, "belt_velocity": u}
    arrays["disorder_parameter"] = np.where(u > place, 0.02, 0.12)
    made = {"small_orbits": five_slips([0.4, 0.6], [19.0, 12.0]), "friction_map": data(arrays)}
    assert grades("fall-at-birth", **made)[""] == verdict
    both = made["small_orbits"].arrays
    both["births"] = np.tile(both["births"], 2)
    both["births"]["period_events"][2:] = 11
    both["births"]["belt_velocity"][2:] += 3
    assert grades("fall-at-birth", **made)[""] == verdict
    share = measured("fall-at-birth", **made).numbers["friction ratios within 1 of 11"].value
    assert share == pytest.approx(near_second, abs=0.1)


@pytest.mark.parametrize(
    ("below", "above", "slips", "verdict"),
    [
        *((0, 0.6, 900, YES), (0, 1, 900, IN_PART), (0.2, 0.6, 900, IN_PART)),
        *((0, 0.6, 33, IN_PART), (0.2, 0.1, 33, NO)),
    ],
)
def test_which_orbits_exact_runs_meet(below, above, slips, verdict):
    u = np.round(np.repeat(np.arange(14, 22, 0.05), 10), 2)
    small = np.tile(np.arange(10) / 10, u.size // 10) < np.where(u < 17.2, below, above)
    arrays = {"belt_velocity": u, "period_events": np.where(small, 5, slips)}
    arrays["disorder_parameter"] = np.where(small, 0.015, 0.12)
    runs = data(arrays | {"state": np.full(u.size, "periodic")})
    assert grades("orbits-met", fall_orbits=runs)[""] == verdict
    numbers = measured("orbits-met", fall_orbits=runs).numbers
    assert numbers["5, 19.5 to 21.5"].value == pytest.approx(above)
    assert numbers[f"{'33' if slips == 33 else 'more than 100'}, 14 to 17"].value == 1 - below


@pytest.mark.parametrize(
    ("wide", "near", "verdict"),
    [(17.2, 10.7, YES), (12, 10.7, IN_PART), (17.2, 11, OPEN), (12, 11, IN_PART)],
)
def test_where_chaos_ends(wide, near, verdict):
    made = figure_data.chaos_ends(np.arange(8.5, 17.11, 0.02), wide)
    u = np.round(np.arange(10.74, 10.7601, 1e-4), 4)
    close = figure_data.chaos_ends(u, 11)
    lasting = np.abs(close.arrays["belt_velocity"] - 10.75) < 6e-4
    close.arrays["settled"] = ~lasting | (near > 10.75)
    slow = settled([2e6, 5e5, 2.5e6, 5e5], u=[0.5, 0.75, 1, 2], duration=2.5e6)
    runs = {"chaos_ends": made, "chaos_ends_near": close, "survival_long": slow}
    assert grades("chaos-ends", **runs)[""] == verdict
    numbers = measured("chaos-ends", **runs).numbers
    for words, expected in (("u below 2", (2 / 3, 3)), ("u from 2 to 8.5", (0, 1))):
        slow = numbers[f"irregular for 1e6, {words}"]
        assert (slow.value, slow.runs) == expected


@pytest.mark.parametrize(
    ("shares", "verdict"),
    [
        *(((0.6, 0.9, 0.9), YES), ((0.6, 0.6, 0.6), OPEN), ((0.6, 0.6, 0.9), OPEN)),
        *(((1, 1, 1), IN_PART), ((1, 0.2, 0.9), NO)),
    ],
)
def test_what_clears_orbits_of_large_r(shares, verdict):
    exact, noisy, stepped = shares
    runs = figure_data.disturbances({0.0: exact, 1e-3: 0.4, 0.01: noisy})
    made = {"disturbances": runs, "disturbances_scheme": figure_data.disturbances({0.0: stepped})}
    fine = figure_data.disturbances({0.0: exact}).arrays
    made["fall_orbits"] = data(fine | {"state": np.full(fine["replicate"].size, "periodic")})
    assert grades("disturbance-clears", **made)[""] == verdict
    more = measured("disturbance-clears", **made).numbers["small r, sigma = 0.01 minus sigma = 0"]
    assert more.value == pytest.approx(noisy - exact)
    table = measure.disturbance_shares(made)
    assert table["share"].tolist() == pytest.approx([exact, 0.4, noisy, stepped])
    assert (table["runs"] == 8 * 10).all()


@pytest.mark.parametrize(
    ("five", "ten", "verdict"),
    [(-0.01, 0.008, YES), (0.005, 0.008, IN_PART), (-0.01, -0.02, IN_PART), (0.001, -0.01, NO)],
)
def test_where_deviations_shrink(five, ten, verdict):
    growth = {4: -0.02 if five < 0 else five, 5: five, 6: min(0.002, ten), 10: ten}
    size = np.repeat(list(growth), 12)
    scatter = np.tile(np.linspace(0.9, 1.1, 12), 4)
    arrays = {"n_blocks": size, "nontrivial_exponent": np.vectorize(growth.get)(size) * scatter}
    arrays["state"], arrays["erased"] = np.full(size.size, "transient"), size
    followed = {"n_blocks": size, "belt_velocity": np.full(size.size, 30.0)}
    followed |= {"settled": size < 10, "lifetime": np.full(size.size, 1e3)}
    made = {"motion_map": data(arrays), "survival": data(followed)}
    assert grades("contraction", **made)[""] == verdict
    found = measured("contraction", **made)
    assert found.numbers["most erased, N = 6"].value == 6
    assert found.also["lifetime, N = 5"].value == 1e3 < found.also["lifetime, N = 10"].value

"""Claims on avalanches on catalogues whose laws are known."""

import numpy as np
import pytest
from test_scale_free import power_law, with_cutoff

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.observe.slips import AVALANCHE, SLIP
from beltrepro.replication.studies.avalanches import measure as avalanches
from beltrepro.stats import scale_free
from made_up import few_resamples, judged, readings  # noqa: F401

RNG = np.random.default_rng
LAB = "laboratory frame"


def catalogue(sizes, energies, *, chains=16, n_blocks=2, belt_velocity=3.0, at_once=True):
    """Avalanches of two blocks: the last slips for 4, the first for 4 from 1 (or 5) later on.

    Each second avalanche is a slip of the first block alone.
    """
    count = len(sizes)
    own = np.zeros(count, SLIP)
    own["point"] = np.repeat(np.arange(chains), count // chains)
    own["block"], own["start_time"] = n_blocks, 40.0 * np.arange(count)
    own["stop_time"] = own["start_time"] + 4
    own["start_position"] = 600 + np.asarray(sizes)
    own["stop_position"] = 600
    own["dissipated"] = 0.3 * np.asarray(energies)
    first, alone = own.copy(), own.copy()
    first["block"] = alone["block"] = 1
    later = 1 if at_once else 4
    first["dissipated"] = 0.7 * np.asarray(energies)
    for slips, by in ((first, later), (alone, 20)):
        for name in ("start_time", "stop_time"):
            slips[name] += by
    alone["dissipated"] = 900.0
    made = np.zeros(2 * count, AVALANCHE)
    made["point"] = np.repeat(own["point"], 2)
    made["start_time"] = np.repeat(own["start_time"], 2) + np.tile([0, 20], count)
    made["stop_time"] = made["start_time"] + np.tile([4 + later, 4], count)
    made["blocks"] = np.tile([2, 1], count)
    made["dissipated"] = np.column_stack([energies, np.full(count, 900.0)]).ravel()
    made["spring_energy_drop"] = 2 * made["dissipated"]
    slips = np.sort(np.concatenate([own, first, alone]), order=["point", "start_time"])
    attributes = {"n_blocks": n_blocks, "belt_velocity": belt_velocity}
    return Dataset({"slips": slips, "avalanches": made}, attributes)


def of_laws(size=-1.47, energy=-0.87, *, count=8000, **how):
    return catalogue(power_law(size, 60, 600, count), power_law(energy, 1e3, 4e4, count, 1), **how)


# --- exponents ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("exponent", "verdict"), [(-1.47, "holds"), (-1.1, "fails"), (-2.0, "fails")]
)
def test_exponents_of_sizes(exponent, verdict):
    made = {"slips_u1": of_laws(size=exponent)}
    for reading in readings("slip-size-exponent", made):
        found = judged("slip-size-exponent", made, reading)
        if reading == "belt frame":  # the law of other sizes
            continue
        assert found[0] == verdict, reading
        assert found[2].judged["exponent"].value == pytest.approx(exponent, abs=0.2)
        assert found[2].runs == 16


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("exponent", "verdict"), [(-0.87, "holds"), (-0.5, "fails"), (-1.5, "fails")]
)
def test_exponents_of_energies(exponent, verdict):
    made = {"slips_u1": of_laws(energy=exponent)}
    assert judged("slip-energy-exponent", made)[0] == verdict
    for reading in ("drop in spring energy", "last block only", "maximum likelihood"):
        estimate = judged("slip-energy-exponent", made, reading)[2].judged["exponent"]
        assert estimate.value == pytest.approx(exponent, abs=0.12), reading
    # slips of the first block alone count in the reading of its name only
    everything = judged("slip-energy-exponent", made, "all avalanches of the chain")
    assert everything[2].judged["exponent"].value != pytest.approx(exponent, abs=0.12)
    # of the first block three quarters of its slip lie within the slip of the last one
    slips = made["slips_u1"].arrays["slips"]
    until = avalanches.dissipation_while_last_block_slips(slips, 2)
    total = slips["dissipated"][slips["block"] == 2] / 0.3
    assert np.sort(until) == pytest.approx(np.sort(total * (0.3 + 0.7 * 0.75)))


def test_the_interval_of_an_exponent_is_that_over_chains():
    """Chains that differ as a whole: bins and values do not know of that."""
    exponents = RNG(3).uniform(-2.2, -0.7, 16)
    sizes = np.concatenate([power_law(e, 60, 600, 500, k) for k, e in enumerate(exponents)])
    for reading in (LAB, "maximum likelihood"):
        unlike = judged("slip-size-exponent", {"slips_u1": catalogue(sizes, sizes)}, reading)
        mixed = RNG(4).permutation(sizes)
        alike = judged("slip-size-exponent", {"slips_u1": catalogue(mixed, mixed)}, reading)
        reach = [each[2].judged["exponent"].high - each[2].judged["exponent"].low
                 for each in (unlike, alike)]  # fmt: skip
        assert reach[0] > 2.5 * reach[1], reading
    assert unlike[0] == "undecided"


def test_exponents_need_slips_and_chains():
    sizes = power_law(-1.5, 60, 600, 480)
    with pytest.raises(NotEnoughDataError, match="slips_u1: 480 slips of the last block, not 500"):
        judged("slip-size-exponent", {"slips_u1": catalogue(sizes, sizes)})
    sizes = power_law(-1.5, 60, 600, 600)
    with pytest.raises(NotEnoughDataError, match="one chain"):
        judged("slip-size-exponent", {"slips_u1": catalogue(sizes, sizes, chains=1)})


# --- self-organised criticality -------------------------------------------------------------------


@pytest.mark.thorough
def test_a_scale_free_catalogue_is_called_so_and_one_with_a_cutoff_is_not(monkeypatch):
    monkeypatch.setattr(
        scale_free.goodness_of_fit, "__kwdefaults__", {"independent": None, "samples": 60}
    )
    # the most probable bin is the lowest one only if values begin at the edge of a bin
    edge = 10**1.8
    law = power_law(-1.47, edge, 600, 4000)
    verdict, parts, found = judged("soc-power-law", {"slips_u1": catalogue(law, law)})
    assert parts["log-likelihood, power law minus exponential"] == "holds"
    assert parts["largest size over the cutoff"] == "holds"
    assert verdict == "holds" and found.judged["p of the power law"].value > 0.1
    cut = with_cutoff(0.0, 0.02, edge, 600, 4000)
    verdict, parts, found = judged("soc-power-law", {"slips_u1": catalogue(cut, cut)})
    assert verdict == "fails" and set(parts.values()) == {"fails"}
    high = np.max(cut)
    assert found.judged["largest size over the cutoff"].value == pytest.approx(0.02 * high, rel=0.2)
    energies = judged("soc-power-law", {"slips_u1": catalogue(cut, law)}, "energies")
    assert energies[0] == "holds"
    few = {"slips_u1": catalogue(law[:512], law[:512])}
    assert judged("soc-power-law", few)[1]["largest size over the cutoff"] == "undecided"


def growing(power_of_sizes, power_of_energies, chains=8):
    made = {}
    for n_blocks, name in {3: "slips_n3", 5: "slips_u1", 7: "slips_n7", 10: "slips_n10"}.items():
        grown = [n_blocks**each for each in (power_of_sizes, power_of_energies)]
        base = power_law(-1.47, 1, 20, 2400, n_blocks)
        made[name] = catalogue(
            60 * grown[0] * base, 300 * grown[1] * base, chains=chains, n_blocks=n_blocks
        )
    return made


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("powers", "verdict"),
    [((1, 1.5), "holds"), ((0, 0), "fails"), ((1, 0.5), "partly"), ((0.5, 1), "undecided")],
)
def test_the_growth_of_the_cutoff(powers, verdict):
    made = growing(*powers)
    for reading in ("99 % quantile", "ratio of moments"):
        found = judged("soc-cutoff", made, reading)
        assert found[0] == verdict
        for name, power in zip(found[2].judged, powers, strict=True):
            estimate = found[2].judged[name]
            assert estimate.value == pytest.approx(power, abs=0.15) and estimate.runs == 8
    with pytest.raises(NotEnoughDataError, match="no slips_n7"):
        judged("soc-cutoff", {name: made[name] for name in made if name != "slips_n7"})


def test_cutoffs_of_orbits_without_scatter_have_an_interval():
    made = growing(1, 1.5)
    same = np.tile([100.0, 200.0, 400.0], 800)
    made["slips_n3"] = catalogue(same, same, chains=8, n_blocks=3)
    assert np.isfinite(judged("soc-cutoff", made)[2].judged["slip size: growth with N"].high)


def test_a_cutoff_that_scatters_less_weighs_more():
    """Slope and line of least squares with the intervals of unequal chains; NaN of one chain."""
    rng = RNG(8)
    samples = {}
    for n_blocks, scatter, chains in ((3, 0.02, 6), (5, 0.5, 9), (10, 0.2, 7)):
        size = n_blocks**1.3 * np.exp(scatter * rng.standard_normal(chains))
        chain = np.repeat(np.arange(chains), 40)
        samples[n_blocks] = avalanches.Sample(size[chain] * rng.uniform(0.9, 1, chain.size), chain)
    growth = avalanches.growth(samples)
    n_blocks = np.array(list(samples))
    cutoffs = [np.quantile(sample.values, 0.99) for sample in samples.values()]
    assert [estimate.value for estimate in growth.cutoffs] == pytest.approx(cutoffs)
    width = [np.log(estimate.high / estimate.low) for estimate in growth.cutoffs]
    weights = 1 / np.array(width)
    slope, level = np.polyfit(np.log(n_blocks), np.log(cutoffs), 1, w=weights)
    assert growth.power.value == pytest.approx(slope)
    np.testing.assert_allclose(growth.line(n_blocks), np.exp(level) * n_blocks**slope)
    one = {n: avalanches.Sample(of.values, 0 * of.chain) for n, of in samples.items()}
    with pytest.raises(NotEnoughDataError, match="one chain"):
        avalanches.growth(one)


def test_samples_are_of_the_last_block_and_of_what_it_takes_part_in():
    """Slips forward count as none; a slip that begins at the end of an avalanche is in it."""
    slips = np.zeros(6, SLIP)
    slips["point"] = [0, 0, 0, 4, 4, 4]
    slips["block"] = [2, 1, 2, 2, 2, 1]
    slips["start_time"], slips["stop_time"] = [5, 1, 30, 2, 50, 60], [6, 5, 31, 3, 54, 61]
    slips["start_position"] = [9, 99, 1, 3, 8, 99]
    slips["stop_position"] = [4, 0, 3, 1, 1, 0]
    made = np.zeros(4, AVALANCHE)
    made["point"] = [0, 0, 4, 4]
    made["start_time"], made["stop_time"] = [1, 29, 2, 60], [5, 31, 3, 61]
    made["dissipated"] = [10, 20, 30, 40]
    data = Dataset({"slips": slips, "avalanches": made}, {"n_blocks": 2, "belt_velocity": 3.0})
    sizes, belt = (avalanches.slip_sizes(data, frame) for frame in ("laboratory", "belt"))
    assert (sizes.values.tolist(), sizes.chain.tolist()) == ([5, 2, 7], [0, 4, 4])
    assert belt.values.tolist() == [8, 1, 5, 19]
    energies = avalanches.avalanche_energies(data)
    assert (energies.values.tolist(), energies.chain.tolist()) == ([10, 20, 30], [0, 0, 4])
    assert avalanches.all_energies(data).values.tolist() == [10, 20, 30, 40]


# --- blocks that slip together --------------------------------------------------------------------


def naive_most_at_once(found, slips):
    most = []
    for one in found:
        own = slips[slips["point"] == one["point"]]
        inside = (own["start_time"] >= one["start_time"]) & (own["stop_time"] <= one["stop_time"])
        own = own[inside]
        instants = own["start_time"]
        counts = [((own["start_time"] <= t) & (own["stop_time"] > t)).sum() for t in instants]
        most.append(max(counts))
    return np.array(most)


def test_blocks_that_slip_at_one_instant_are_counted_as_by_a_plain_loop():
    rng = RNG(6)
    slips = np.zeros(200, SLIP)
    slips["point"], slips["block"] = np.repeat([0, 3], 100), rng.integers(1, 5, 200)
    slips["start_time"] = np.repeat(10.0 * np.arange(50), 4) + rng.integers(0, 4, 200)
    slips["stop_time"] = slips["start_time"] + rng.integers(1, 4, 200)
    found = np.zeros(50, AVALANCHE)
    found["point"] = np.repeat([0, 3], 25)
    found["start_time"] = 10.0 * np.arange(50)
    found["stop_time"] = found["start_time"] + 8
    order = rng.permutation(200)
    expected = naive_most_at_once(found, slips)
    assert avalanches.most_at_once(found, slips[order]).tolist() == expected.tolist()
    assert len(set(expected)) > 2


def test_shares_of_avalanches_in_which_all_blocks_slip():
    law = power_law(-0.87, 1e3, 4e4, 1600)
    name, share = "blocks-slip-together", "avalanches in which all blocks slip at once"
    made = {"slips_u1": catalogue(law, law)}
    values = {
        reading: judged(name, made, reading)[2].judged[share].value
        for reading in readings(name, made)
    }
    # each second avalanche, of little energy, is one of the first block alone
    assert values.pop("at one instant, weighted by energy") > 0.9
    assert set(values.values()) == {0.5}
    apart = {"slips_u1": catalogue(law, law, at_once=False)}
    assert judged(name, apart)[2].judged[share].value == 0
    assert judged(name, apart)[0] == "partly"  # of different sizes they are
    assert judged(name, apart, "during the avalanche")[2].judged[share].value == 0.5
    assert judged(name, made, "at one instant, weighted by energy")[0] == "holds"

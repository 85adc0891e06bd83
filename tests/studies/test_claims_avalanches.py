"""Claims on the chain at u = 1: series and catalogues whose laws are known."""

import numpy as np
import pytest
from test_power_law import power_law

from beltrepro import ChainValues
from beltrepro.base.store import Dataset
from beltrepro.observe.slips import AVALANCHE, SLIP
from beltrepro.replication.studies.avalanches import measure as avalanches
from beltrepro.replication.verdicts.criteria import IN_PART, NO, OPEN, YES
from beltrepro.replication.verdicts.evidence import EXACT
from beltrepro.stats import power_law as laws
from made_up import both, few_resamples, grades, measured  # noqa: F401

RNG = np.random.default_rng
EDGES = 10**1.8, 10**2.8  # of bins, 5 or 10 a decade
EXACT_TESTED = f"{EXACT}, in the range that fits best"


@pytest.fixture(autouse=True)
def few_samples(monkeypatch):
    monkeypatch.setattr(avalanches, "SCALED_RESAMPLES", 40)
    monkeypatch.setattr(
        laws.goodness_of_fit, "__kwdefaults__", {"independent": None, "samples": 60}
    )


# --- the spectrum ---------------------------------------------------------------------------------


def coloured(*pieces, duration=60_000.0, interval=1.0, transient=1000.0):
    """Series with the spectral density factor * nu**exponent from each of some frequencies on."""
    size = int(duration / interval)
    nu = np.fft.rfftfreq(size, interval)
    density = np.zeros(nu.size)
    for low, factor, exponent in pieces:
        density[nu > low] = factor * nu[nu > low] ** exponent
    rng = RNG(1)
    noise = rng.standard_normal(nu.size) + 1j * rng.standard_normal(nu.size)
    x = np.fft.irfft(noise * np.sqrt(density * size / interval) / 2, size)
    arrays = {"time": interval * np.arange(size), "positions": np.column_stack([x[::-1], x])}
    return Dataset(arrays, {"transient": transient})


def law(exponent, factor=1.0, **how):
    return coloured((0, factor, exponent), **how)


BENT = coloured((0, 1.0, -1.21), (0.03, 0.03**2.8, -4.01))
PRINTED = law(-2.42, 1.28)  # as an amplitude over 1e6: 0.0016 * nu**-1.21


@pytest.mark.parametrize(
    ("series", "exact", "verdicts"),
    [
        (PRINTED, PRINTED, (YES, YES)),
        (PRINTED, law(-3.4, 1.28), (YES, IN_PART)),  # one exponent, but another
        (PRINTED, BENT, (YES, IN_PART)),  # no law
        (law(-3.4, 1.28), law(-3.4, 1e4), (IN_PART, IN_PART)),
        (law(-2.82, 1.28), PRINTED, (IN_PART, YES)),
    ],
)
def test_the_spectrum(series, exact, verdicts):
    assert both("spectrum-exponent", u1=series, u1_event=exact) == verdicts


def test_the_amplitude_of_a_spectrum_is_that_of_a_long_series():
    """2|X|/n of white noise of variance s^2 and interval d over a time T: 2 s sqrt(d / T)."""
    numbers = measured("spectrum-exponent", u1=PRINTED).judged
    assert numbers["exponent"].value == pytest.approx(-1.21, abs=0.05)
    white = RNG(2).standard_normal(160_000) * 3
    arrays = {"time": 0.5 * np.arange(white.size), "positions": white[:, None]}
    series = Dataset(arrays, {"transient": 0.0})
    prefactor = measured("spectrum-exponent", u1=series).judged["prefactor"]
    size = 2e6  # samples in a time of 1e6
    spectrum = 2 * np.abs(np.fft.rfft(white)) / white.size * np.sqrt(white.size / size)
    assert prefactor.value == pytest.approx(np.sqrt(np.mean(spectrum**2)), rel=0.1)
    assert prefactor.low < prefactor.value < prefactor.high


@pytest.mark.parametrize(
    ("exact", "verdict"),
    [
        (law(-1, duration=2e5), YES),
        (coloured((0, 1, 0.8), (0.003, 0.003**1.8, -1), duration=2e5), IN_PART),
        (coloured((0, 1, 0), (0.003, 0.003**2.3, -2.3), duration=2e5), NO),
        (law(-1), OPEN),  # too short for what is slow
    ],
)
def test_one_over_f_is_asked_of_the_power_down_to_low_frequencies(exact, verdict):
    assert both("one-over-f", u1=PRINTED, u1_event=exact) == (YES, verdict)
    assert both("one-over-f", u1=law(-0.2), u1_event=exact) == (NO, verdict)


# --- slips in a series ----------------------------------------------------------------------------


def velocity_series(peaks):
    """Slips of 2 time units every 10 from t = 5 on, with given peaks of |v_r|; u = 2.

    It begins in a slip, which is not seen as a whole.
    """
    time = 0.5 * np.arange(20 * len(peaks) + 20)
    relative = np.where(time < 1, -9e9, 0.0)
    rows = [(1.0, 2, "stick")]
    for index, peak in enumerate(peaks):
        begin = 5 + 10.0 * index
        relative[(time > begin) & (time < begin + 2)] = -peak / 2
        relative[time == begin + 1] = -peak
        relative[time == begin + 5] = -9e9  # while it is stuck
        rows += [(begin, 2, "slip"), (begin + 2, 2, "stick"), (begin + 3, 1, "slip")]
    arrays = {"time": time, "velocities": np.column_stack([time, 2 + relative])}
    arrays["events"] = np.array(rows, dtype=[("time", "f8"), ("block", "i8"), ("kind", "U5")])
    return Dataset(arrays, {"n_blocks": 2, "belt_velocity": 2.0})


def peaks_of(factor, spread, count=200):
    return factor * np.exp(spread * RNG(3).standard_normal(count))


@pytest.mark.parametrize(
    ("factor", "spread", "verdict"),
    [(50, 0.5, YES), (50, 0.01, IN_PART), (5, 0.01, NO), (6, 0.5, OPEN)],
)
def test_peaks_of_the_velocity_in_slips(factor, spread, verdict):
    peaks = peaks_of(factor, spread)
    series, fast = velocity_series(peaks), velocity_series(peaks_of(50, 0.5))
    assert both("slip-velocity", u1=series, u1_event=fast) == (verdict, YES)
    assert both("slip-velocity", u1=fast, u1_event=series) == (YES, verdict)
    numbers = measured("slip-velocity", u1=series).judged
    assert numbers["median peak |v_r| / u"].value == pytest.approx(np.median(peaks) / 2)
    ratio = np.quantile(peaks, 0.95) / np.quantile(peaks, 0.05)
    assert numbers["peaks: 95 % over 5 % quantile"].value == pytest.approx(ratio)
    assert numbers["peaks: 95 % over 5 % quantile"].runs == 20


# --- catalogues -----------------------------------------------------------------------------------


def catalogue(sizes, energies, *, chains=16, n_blocks=2, belt_velocity=3.0, at_once=True):
    """Avalanches of two blocks: the last slips for 4, the first for 4 from 1 (or 5) later on.

    Each second avalanche is a slip of the first block alone.
    """
    count = len(sizes)
    chosen = np.zeros(count, SLIP)
    chosen["point"] = np.repeat(np.arange(chains), count // chains)
    chosen["block"], chosen["start_time"] = n_blocks, 40.0 * np.arange(count)
    chosen["stop_time"] = chosen["start_time"] + 4
    chosen["start_position"] = 600 + np.asarray(sizes)
    chosen["stop_position"] = 600
    chosen["dissipated"] = 0.3 * np.asarray(energies)
    first, alone = chosen.copy(), chosen.copy()
    first["block"] = alone["block"] = 1
    later = 1 if at_once else 4
    first["dissipated"] = 0.7 * np.asarray(energies)
    for slips, by in ((first, later), (alone, 20)):
        for name in ("start_time", "stop_time"):
            slips[name] += by
    alone["dissipated"] = 900.0
    made = np.zeros(2 * count, AVALANCHE)
    made["point"] = np.repeat(chosen["point"], 2)
    made["start_time"] = np.repeat(chosen["start_time"], 2) + np.tile([0, 20], count)
    made["stop_time"] = made["start_time"] + np.tile([4 + later, 4], count)
    made["blocks"] = np.tile([2, 1], count)
    made["dissipated"] = np.column_stack([energies, np.full(count, 900.0)]).ravel()
    slips = np.sort(np.concatenate([chosen, first, alone]), order=["point", "start_time"])
    attributes = {"n_blocks": n_blocks, "belt_velocity": belt_velocity}
    return Dataset({"slips": slips, "avalanches": made}, attributes)


def of_laws(size=-1.47, energy=-0.87, *, count=8000, **how):
    sizes = power_law(size, *EDGES, count)
    return catalogue(sizes, power_law(energy, 1e3, 1e5, count, 1), **how)


def cut_off():
    """Sizes and energies that fall as exponentials."""
    sizes = EDGES[0] + RNG(0).exponential(50.0, 4000)
    return catalogue(sizes, sizes)


# --- exponents ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "size", "energy"),
    [
        ({}, (YES, YES), (YES, YES)),
        ({"size": -1.05}, (NO, IN_PART), (YES, YES)),
        ({"size": -1.69}, (IN_PART, IN_PART), (YES, YES)),
        ({"energy": -0.4}, (YES, YES), (NO, IN_PART)),
    ],
)
def test_exponents_of_power_laws(change, size, energy):
    made = of_laws(**change)
    made = {"slips_u1": made, "slips_u1_event": made}
    assert both("slip-size-exponent", **made) == size
    assert both("slip-energy-exponent", **made) == energy


def test_the_interval_of_an_exponent_is_that_over_chains():
    """Chains that differ as a whole: bins and values do not know of that."""
    exponents = RNG(3).uniform(-2.2, -0.7, 16)
    sizes = np.concatenate([power_law(e, *EDGES, 500, k) for k, e in enumerate(exponents)])
    mixed = RNG(4).permutation(sizes)
    for reading in ("line through all bins", EXACT):
        unlike, alike = (
            measured("slip-size-exponent", reading, slips_u1=made, slips_u1_event=made)
            for made in (catalogue(sizes, sizes), catalogue(mixed, mixed))
        )
        reach = [np.ptp(one.judged["exponent"].numbers[1:]) for one in (unlike, alike)]
        assert reach[0] > 2.5 * reach[1], reading


# --- self-organised criticality -------------------------------------------------------------------


def test_a_power_law_is_told_from_an_exponential():
    free, cut, other = of_laws(count=4000), cut_off(), of_laws(size=-1.05, count=4000)
    assert both("soc-power-law", slips_u1=free, slips_u1_event=free) == (YES, YES)
    assert both("soc-power-law", slips_u1=other, slips_u1_event=cut) == (IN_PART, NO)
    test = measured("soc-power-law", EXACT_TESTED, slips_u1_event=free).judged["p of the power law"]
    assert test.value > 0.1
    energies = measured("soc-power-law", "energies", slips_u1=free).judged["p of the power law"]
    assert energies.value > 0.1 and energies.runs == 16


SIZES = {5: "slips_u1", 7: "slips_n7", 10: "slips_n10"}


def growing(power_of_sizes, power_of_energies, chains=8, shape=lambda n_blocks: -1.47):
    """Catalogues by both methods in which sizes and energies are stretched by powers of N."""
    made = {}
    for n_blocks, name in SIZES.items():
        grown = [n_blocks**power for power in (power_of_sizes, power_of_energies)]
        base = power_law(shape(n_blocks), 1, 20, 2400, n_blocks)
        made[name] = catalogue(
            60 * grown[0] * base, 300 * grown[1] * base, chains=chains, n_blocks=n_blocks
        )
    return made | {f"{name}_event": dataset for name, dataset in made.items()}


LINE_OF_N = {5: -1.47, 7: -2.5, 10: -0.3}  # no two densities of one form


@pytest.mark.parametrize(
    ("powers", "shape", "verdict"),
    [
        ((1, 1.5), None, YES),
        ((0, 0), None, IN_PART),  # of one form, but they do not grow
        ((0, 0), LINE_OF_N, NO),
        ((1, 1.5), LINE_OF_N, IN_PART),
        ((0.35, 0.8), None, IN_PART),
    ],
)
def test_growth_and_form_of_avalanches(powers, shape, verdict):
    made = growing(*powers, shape=shape.get) if shape else growing(*powers)
    assert both("soc-cutoff", **made) == (verdict, verdict)
    if not shape:
        *grown, _ = measured("soc-cutoff", **made).judged.values()
        for estimate, power in zip(grown, powers, strict=True):
            assert estimate.value == pytest.approx(power, abs=0.15) and estimate.runs == 8


def test_densities_of_one_law_collapse_and_others_do_not():
    """A critical law begins at one size and goes the further the longer the chain."""

    def critical(n_blocks, chain, low=100.0, exponent=-1.4):
        values = power_law(exponent, low, 3000 * (n_blocks / 5) ** 2.5, 6000, 10 * n_blocks)
        return ChainValues(values, chain)

    chain = np.repeat(np.arange(8), 750)

    def apart(samples):
        return avalanches.collapse(samples).judged["distance from one curve"]

    collapsed = avalanches.collapse({n: critical(n, chain) for n in (5, 7, 10)})
    assert collapsed.also["power of N"].value == pytest.approx(2.4, abs=0.2)
    (one,) = collapsed.judged.values()
    assert one.value < 1.1 and one.high < 1.2
    assert collapsed.also["distance without scaling"].value > 1.08 * one.value
    tilted = {n: critical(n, chain, exponent=-1.4 - 0.2 * (n - 5)) for n in (5, 7, 10)}
    assert apart(tilted).low > 1.15


def test_the_form_is_that_of_avalanches_of_several_blocks_and_each_method_has_its_own():
    """Those of the first block alone, of one energy, and the other method must not count."""
    same, unlike = growing(1, 1.4), growing(1, 1.4, shape=LINE_OF_N.get)
    mixed = {name: same[name] for name in SIZES.values()}
    assert both("soc-cutoff", **unlike | mixed) == (IN_PART, IN_PART)
    assert both("soc-cutoff", **same | {name: unlike[name] for name in mixed}) == (YES, YES)
    measurement = measured("soc-cutoff", EXACT, **same)
    assert measurement.also["power of N"].value == pytest.approx(1.4, abs=0.05)


def test_a_cutoff_that_scatters_less_weighs_more():
    """Slope and line of least squares with the intervals of unequal chains."""
    rng = RNG(8)
    samples = {}
    for n_blocks, scatter, chains in ((3, 0.02, 6), (5, 0.5, 9), (10, 0.2, 7)):
        size = n_blocks**1.3 * np.exp(scatter * rng.standard_normal(chains))
        chain = np.repeat(np.arange(chains), 40)
        samples[n_blocks] = ChainValues(size[chain] * rng.uniform(0.9, 1, chain.size), chain)
    growth = avalanches.growth({n: avalanches.log_cutoff(one) for n, one in samples.items()})
    n_blocks = np.array(list(samples))
    cutoffs = [np.quantile(sample.values, 0.99) for sample in samples.values()]
    assert [estimate.value for estimate in growth.cutoffs] == pytest.approx(cutoffs)
    width = [np.log(estimate.high / estimate.low) for estimate in growth.cutoffs]
    weights = 1 / np.array(width)
    slope, level = np.polyfit(np.log(n_blocks), np.log(cutoffs), 1, w=weights)
    assert growth.power.value == pytest.approx(slope)
    np.testing.assert_allclose(growth.line(), np.exp(level) * n_blocks**slope)


# --- blocks that slip together --------------------------------------------------------------------


def test_blocks_that_slip_together():
    """Each second avalanche is one of the first block alone; in the others both slip."""
    energies = power_law(-0.87, 1e3, 4e4, 1600)
    pair, apart = (catalogue(energies, energies, at_once=once) for once in (True, False))
    assert both("blocks-slip-together", slips_u1=pair, slips_u1_event=pair) == (YES, YES)
    assert both("blocks-slip-together", slips_u1=apart, slips_u1_event=pair) == (IN_PART, YES)
    assert both("blocks-slip-together", slips_u1=pair, slips_u1_event=apart) == (YES, IN_PART)
    alike = np.full(1600, 900.0)
    alike = catalogue(alike, alike, at_once=False)
    assert both("blocks-slip-together", slips_u1=alike, slips_u1_event=pair) == (NO, YES)
    measurement = measured("blocks-slip-together", slips_u1=pair)
    assert measurement.judged["avalanches of two blocks or more"].numbers == (0.5, 0.5, 0.5)
    assert measurement.also["avalanches of all blocks"].value == 0.5

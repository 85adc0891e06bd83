"""Units, spring law, friction rule and parameters against the paper (Sec. III)."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import naive
from beltrepro import ChainParameters, Setup
from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.model import section_position, units
from beltrepro.model.friction import next_direction, start_noise
from beltrepro.model.spring import (
    chain_deformations,
    external_force,
    potential_energy,
    spring_energy,
    spring_extension,
    spring_force,
)

CHAIN = [field.name for field in fields(ChainParameters)]


def test_units_are_those_of_the_paper():
    time, mass, length = np.sqrt(0.1158 / 19.8), 0.1158, 1.4e-3
    base = {"mass": mass, "length": length, "time": time, "velocity": length / time}
    base |= {"force": mass * length / time**2, "energy": mass * (length / time) ** 2}
    for quantity, unit in base.items():
        assert units.to_si(2.0, quantity) == pytest.approx(2 * unit)
        assert units.from_si(2 * unit, quantity) == pytest.approx(2.0)
    assert units.to_si(0.1, "disorder_parameter") == units.from_si(0.1, "friction_ratio") == 0.1
    with pytest.raises(InputError, match="did you mean 'disorder_parameter'"):
        units.to_si(1.0, "disorder_paramter")
    assert units.to_si(np.inf, "linear_limit") == np.inf
    with pytest.raises(InputError, match="value = inf: a finite number is needed"):
        units.to_si(10**400, "length")
    rate = units.to_si([2, np.nan], "extension_rate")
    np.testing.assert_allclose(rate, [2 / length, np.nan])
    assert units.to_si(2.0, "stiffness") == pytest.approx(2 * mass / time**2)
    assert units.to_si(2.0, "viscosity") == pytest.approx(2 * mass / time)
    assert units.from_si(1.98, "force") == pytest.approx(71.4, abs=0.05)
    assert pytest.approx(0.45, abs=0.005) == units.KINETIC_FRICTION_N / units.STATIC_FRICTION_N


def test_friction_rule():
    cases = [
        (0, 0.0, 71.4, 0),  # stuck, at the threshold
        (0, 0.0, 71.5, 1),  # slips towards the external force
        (1, 3.0, -50.0, 1),  # slips on while v_r keeps its sign
        (1, 0.1, 0.0, 1),
        (1, 0.0, 0.0, 0),  # at zero it is decided anew
        (1, -0.1, 50.0, 0),  # sign change with |F_ex| < F_st: sticks
        (1, -0.1, 80.0, 1),  # sign change with |F_ex| > F_st: slips on towards F_ex
        (1, -0.1, -80.0, -1),
    ]
    *states, expected = np.concatenate([cases, -np.array(cases)]).T
    np.testing.assert_array_equal(next_direction(*states, 71.4), expected)
    # without force and threshold a block slips with the belt
    forces = np.array([0.0, -0.0, 1e-300, -1e-300])
    assert next_direction(np.zeros(4), np.zeros(4), forces, -1.0).tolist() == [1, 1, 1, -1]


# --- other laws, edges ----------------------------------------------------------------------------

USUAL = ChainParameters(1, 1.0)
LAW = {"linear_limit": 7.0, "compression_rate": 0.5, "extension_rate": 0.04}
OTHER = ChainParameters(3, 2.0, rest_length=30.0, **LAW)
LINEAR = ChainParameters(3, 2.0, linear_limit=np.inf)


@pytest.mark.parametrize("deformation", [-35, -20.0, -7.5, -7.0, -1.0, 0.0, 7.0, 7.5, 20, 40, 150])
@pytest.mark.parametrize("chain", [USUAL, OTHER, LINEAR])
def test_the_spring_law_follows_its_constants(deformation, chain):
    limit = chain.linear_limit
    force = naive.spring_force(deformation, limit, chain.compression_rate, chain.extension_rate)
    assert spring_force(deformation, chain) == pytest.approx(force)
    assert spring_extension(-force, chain) == pytest.approx(deformation)
    breaks = [point for point in (-limit, limit) if abs(point) < abs(deformation)]
    work = -quad(spring_force, 0, deformation, args=(chain,), points=breaks or None)[0]
    assert spring_energy(deformation, chain) == pytest.approx(work, rel=1e-9, abs=1e-12)


def test_forces_and_energies_of_a_chain_are_those_of_its_springs():
    positions = np.array([[25.0, 70.0, 95.0], [30.0, 60.0, 90.0]])
    lengths = np.array([[25.0, 45.0, 25.0], [30.0, 30.0, 30.0]])
    np.testing.assert_array_equal(chain_deformations(positions, OTHER), lengths - 30)
    one, two, three = (
        naive.spring_force(length - 30, limit=7.0, compression=0.5, extension=0.04)
        for length in (25.0, 45.0, 25.0)
    )
    np.testing.assert_allclose(
        external_force(positions, OTHER), [[one - two, two - three, three], [0, 0, 0]]
    )
    energy = sum(spring_energy(length - 30, OTHER) for length in (25.0, 45.0, 25.0))
    np.testing.assert_allclose(potential_energy(positions, OTHER), [energy, 0])


def test_constants_of_the_paper_are_the_defaults():
    chain = ChainParameters(5, 1.0)
    assert (chain.noise, chain.static_friction, chain.friction_ratio) == (0, 71.4, 0.45)
    assert (chain.rest_length, chain.linear_limit) == (50, 20)
    assert (chain.compression_rate, chain.extension_rate) == (0.2, 0.01)
    assert (chain.mass, chain.stiffness) == (1, 1)
    assert (chain.weakening_velocity, chain.viscosity) == (math.inf, 0)
    assert chain.law == (71.4, 0.45, 50, 20, 0.2, 0.01, 1, 1, math.inf, 0) and not chain.varied
    assert chain.rest_positions.tolist() == [50, 100, 150, 200, 250]
    assert ChainParameters(5, 7.5, 2.2).describe() == "N=5, u=7.5, sigma=2.2"


def test_a_chain_in_words_has_what_differs_from_the_law_of_the_paper_and_si_units():
    chain = ChainParameters(3, 10.0, friction_ratio=0.4, mass=(1, 3, 1), linear_limit=math.inf)
    law = "friction_ratio=0.4, linear_limit=inf"
    assert chain.describe() == f"N=3, u=10, sigma=0, {law}, mass=(1, 3, 1)"
    masses = "mass=(0.1158, 0.3474, 0.1158) kg"
    assert chain.describe(si=True) == f"N=3, u=0.1831 m/s, sigma=0 N, {law} m, {masses}"
    many = ChainParameters(9, 10.0, rest_length=range(50, 59))
    assert many.describe().endswith(", rest_length=(50, 51, 52, ...)")


# As documented, written here once more: numbers that are allowed, and numbers that are not.
POSITIVE = (1e-300, 0.8e9, 1e9), (0.0, -1e-300, 1.001e9, 1.2e9)
LIMITS = dict.fromkeys(CHAIN, POSITIVE) | {
    "n_blocks": ((1, 2, 51, 1000, 5.0, np.int64(5)), (0, 1_000_001, 2.5, -3, True, "five", None)),
    "noise": ((0, 0.8e9, 1e9), (-1e-300, 1.001e9, 1.2e9)),
    "friction_ratio": ((0, 0.8, 0.999), (-0.01, 1.0, 1.2)),
    "compression_rate": ((1e-6, 0.8e9, 1e9), (0.0, 0.999e-6, -1.0, 1.2e9)),
    "extension_rate": ((1e-6, 0.8e9, 1e9), (0.0, 0.999e-6, -1.0, 1.2e9)),
    "viscosity": ((0, 0.8e9, 1e9), (-1e-300, 1.001e9, 1.2e9)),
    "time_step": ((1e-9, 1.2e-9, 0.08, 0.1), (0.999e-9, 0.8e-9, 0.1001, 0.12, 0)),
    "tolerance": ((1e-16, 1.2e-16, 0.8, 1), (0.999e-16, 0.8e-16, 1.001, 1.2, 0)),
    "seed": ((0, 2**63 - 1), (-1, 2**63, 2.5)),
    "initial_spread": ((0, 3.0), (-1e-9, 1.2e9)),
}


@pytest.mark.parametrize("name", LIMITS)
def test_limits_are_those_of_the_documents(name):
    def made(value):
        if name in CHAIN:
            chain = ChainParameters(**{"n_blocks": 5, "belt_velocity": 1.0} | {name: value})
            return getattr(chain, name)
        case = Setup(ChainParameters(5, 1.0), **{name: value}).cases[0]
        return case.state.seed if name == "seed" else getattr(case, name)

    allowed, refused = LIMITS[name]
    for value in allowed:
        number = made(value)
        assert number == value and type(number) is (int if name in ("n_blocks", "seed") else float)
    # linear springs have no limit, and friction need not weaken
    infinite = -np.inf if name in ("linear_limit", "weakening_velocity") else np.inf
    for value in (*refused, np.nan, infinite):
        with pytest.raises(InputError, match=f"^{name} = ") as caught:
            made(value)
        both_ends = "greater than 0 and at most 1e+09"
        assert LIMITS[name] is not POSITIVE or value != 0 or both_ends in str(caught.value)


def test_ranges_of_numbers_have_both_ends_and_no_rounding():
    assert checks.spaced("u", 0.2, 50, 0.2)[34] == checks.spaced("u", 0.5, 50, 0.5)[13] == 7.0
    assert checks.spaced("u", 0.1, 0.7, 0.1) == (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)
    assert checks.spaced("u", 1, 2, 0.3) == (1, 1.3, 1.6, 1.9)
    assert checks.spaced("u", 3, 3, 1) == (3,)
    assert len(checks.spaced("u", 1, 100_000, 1)) == 100_000
    for refused, words in (
        ((1, 100_001, 1), "u.step = 1: gives 1e[+]05 values, at most 100000"),
        ((2, 1, 1), "u.stop = 1: must not be less than start = 2"),
        ((1, 2, 0), "u.step = 0: must be greater than 0"),
    ):
        with pytest.raises(InputError, match=words):
            checks.spaced("u", *refused)


def balance_by_search(chain, blocks=None):
    """Where the springs hold the last of some blocks against the friction of it and all beyond."""
    blocks = blocks or chain.n_blocks
    kinetic = chain.friction_ratio * chain.static_friction
    kinetic /= 1 + chain.belt_velocity / chain.weakening_velocity
    kinetic += chain.viscosity * chain.belt_velocity
    lengths = [
        brentq(lambda stretch, pull=kinetic * carried: spring_force(stretch, chain) + pull, 0, 1e4)
        for carried in range(chain.n_blocks, chain.n_blocks - blocks, -1)
    ]
    return blocks * chain.rest_length + sum(lengths)


@pytest.mark.parametrize(
    ("n_blocks", "position"),
    [(2, 187.7), (3, 314.3), (4, 457.5), (5, 615.0), (6, 785.0), (7, 966.2), (10, 1566.1)],
)
def test_the_section_of_each_size(n_blocks, position):
    chain = ChainParameters(n_blocks, 3.0, 2.0)
    assert section_position(chain) == position
    # 0.998 of the balance (Sec. IV.A), to one digit
    share = 615 / balance_by_search(ChainParameters(5, 1.0))
    assert round(share, 3) == 0.998
    for block in (None, *range(1, n_blocks + 1)):
        expected = share * balance_by_search(chain, block)
        assert abs(section_position(chain, block) - expected) <= 0.05 + 1e-9


@pytest.mark.parametrize("field", [field.name for field in fields(ChainParameters)[3:]])
def test_the_section_follows_every_constant_of_the_law(field):
    usual = ChainParameters(5, 20.0)
    # the springs of a chain in balance are stretched, so the compressed branch does not matter
    changed = {"weakening_velocity": 50.0, "viscosity": 0.1}
    other = replace(usual, **{field: changed.get(field, 0.9 * getattr(usual, field))})
    share = 615 / balance_by_search(usual)
    assert abs(section_position(other) - share * balance_by_search(other)) <= 0.05 + 1e-9
    assert (section_position(other) != 615.0) == (field not in ("compression_rate", "mass"))


def test_the_section_of_a_chain_in_metres_is_that_in_model_units():
    unit = 0.0014
    lengths = {"rest_length": 50 * unit, "linear_limit": 20 * unit, "static_friction": 71.4 * unit}
    rates = {"compression_rate": 0.2 / unit, "extension_rate": 0.01 / unit}
    chain = ChainParameters(5, 20 * unit, **lengths, **rates)
    assert section_position(chain) == pytest.approx(615 * unit, rel=1e-3)


def test_one_wrong_number_among_those_of_the_blocks_is_named():
    for values, words in (
        ((1.0, 2.0), "mass = .* has 2 numbers: one number or 3 are needed"),
        ((1.0, -2.0, 1.0), r"mass\[1\] = -2: must be greater than 0"),
        ({1.0, 2.0, 3.0}, "mass = .*: a number is needed"),
    ):
        with pytest.raises(InputError, match=words):
            ChainParameters(3, 10.0, mass=values)


def test_of_blocks_that_differ_the_noisiest_start_counts():
    chain = ChainParameters(3, 5.0, 2.0, friction_ratio=(0.2, 0.6, 0.4))
    # closed form: sigma sqrt(1 + f_s^2) / ((1 - f_s) F_st)
    assert start_noise(chain) == pytest.approx(2.0 * 1.36**0.5 / (0.4 * 71.4), rel=1e-12)

"""Units, spring law, friction rule and parameters against the paper (Sec. III)."""

import numpy as np
import pytest
from scipy.integrate import quad

from beltrepro import ChainParameters
from beltrepro.errors import InputError
from beltrepro.model import units
from beltrepro.model.friction import friction_force, next_direction
from beltrepro.model.spring import spring_energy, spring_extension, spring_force


def test_units_are_those_of_the_paper():
    assert round(units.TIME_S, 4) == 0.0765
    assert round(units.VELOCITY_M_S, 4) == 0.0183
    assert round(units.FORCE_N, 4) == 0.0277
    assert units.from_si(1.98, "force") == pytest.approx(71.4, abs=0.05)
    assert units.to_si(19.0, "velocity") == pytest.approx(0.35, abs=0.005)
    assert units.to_si(units.from_si(0.28, "velocity"), "velocity") == pytest.approx(0.28)


@pytest.mark.parametrize("join", [-20.0, 20.0])
def test_spring_law_joins_smoothly(join):
    step = 1e-6
    below, above = spring_force(join - step), spring_force(join + step)
    assert above - below == pytest.approx(-2 * step, rel=1e-5)
    slopes = np.diff(spring_force(join + step * np.array([-1, 0, 1]))) / step
    np.testing.assert_allclose(slopes, -1, atol=1e-6)


def test_spring_law_beyond_the_joins():
    assert spring_force(10.0) == -10.0
    assert spring_force(-30.0) == pytest.approx(20 + (np.exp(2.0) - 1) / 0.2)
    assert spring_force(120.0) == pytest.approx(-(20 + (np.e - 1) / 0.01))


@pytest.mark.parametrize("deformation", [-35.0, -20.0, -7.0, 0.0, 12.0, 20.0, 150.0])
def test_energy_is_the_integral_of_the_force(deformation):
    breaks = [point for point in (-20.0, 20.0) if abs(point) < abs(deformation)]
    work = -quad(spring_force, 0, deformation, points=breaks or None)[0]
    assert spring_energy(deformation) == pytest.approx(work, rel=1e-9, abs=1e-12)


def test_extension_inverts_the_force():
    deformation = np.linspace(-45, 300, 200)
    np.testing.assert_allclose(spring_extension(-spring_force(deformation)), deformation)


@pytest.mark.parametrize(
    ("direction", "relative_velocity", "force", "expected"),
    [
        (0, 0.0, 71.3, 0),  # stuck, below the threshold
        (0, 0.0, -71.5, -1),  # slips towards the external force
        (0, 0.0, 71.5, 1),
        (-1, -3.0, 50.0, -1),  # slips on while v_r keeps its sign
        (-1, 0.1, 50.0, 0),  # sign change with |F_ex| < F_st: sticks
        (-1, 0.1, 80.0, 1),  # sign change with |F_ex| > F_st: slips on towards F_ex
        (1, -0.1, -80.0, -1),
    ],
)
def test_friction_rule(direction, relative_velocity, force, expected):
    assert next_direction(direction, relative_velocity, force, 71.4) == expected


def test_friction_force():
    assert friction_force(0, 30.0, 71.4, 0.45) == -30.0
    assert friction_force(-1, 30.0, 71.4, 0.45) == pytest.approx(0.45 * 71.4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n_blocks": 0}, "n_blocks = 0"),
        ({"n_blocks": 2.5}, "n_blocks = 2.5"),
        ({"belt_velocity": -1}, "belt_velocity = -1"),
        ({"belt_velocity": "fast"}, "belt_velocity = 'fast'"),
        ({"noise": -0.1}, "noise = -0.1"),
        ({"noise": float("nan")}, "noise = nan"),
        ({"friction_ratio": 1}, "friction_ratio = 1"),
    ],
)
def test_bad_parameters_are_named(arguments, message):
    with pytest.raises(InputError, match=message):
        ChainParameters(**({"n_blocks": 5, "belt_velocity": 1.0} | arguments))

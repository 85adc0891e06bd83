"""A belt that changes its velocity in a run: the bits of runs from change to change, as one."""

from dataclasses import replace

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState, Run, avalanche_energies, simulate, slip_sizes
from beltrepro.base.errors import InputError

BELT = [(0, 6.0), (120, 14.0), (200.5, 3.0)]
LENGTHS = [120.0, 80.5, 99.5]
pytestmark = pytest.mark.filterwarnings("ignore:.*loading is measured")
ARRAYS = ("time", "positions", "velocities", "friction", "events")


def by_hand(chain, state=None, **settings):
    """The runs from one change to the next."""
    runs = []
    for (_, speed), length in zip(BELT, LENGTHS, strict=True):
        moving = replace(chain, belt_velocity=speed)
        runs.append(simulate(moving, duration=length, initial_state=state, **settings))
        state = runs[-1].final_state
    return runs


@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize("method", ["event", "verlet"])
def test_one_run_has_the_bits_of_the_pieces(method, noise):
    chain, settings = ChainParameters(4, 25.0, noise, mass=(1, 1, 2, 1)), {"method": method}
    run = simulate(chain, duration=300, transient=60, belt=BELT, **settings)
    pieces = by_hand(chain, **settings)
    for name in ARRAYS:
        joined = np.concatenate([getattr(piece, name) for piece in pieces])
        np.testing.assert_array_equal(getattr(run, name), joined, err_msg=name)
    assert len(run.events) > 50
    assert run.final_state == pieces[-1].final_state
    assert list(run.changes) == [piece.final_state for piece in pieces[:-1]]
    assert run.belt == BELT and run.parameters.belt_velocity == 6
    late = run.positions[run.time > 59.95, -1]
    assert run.disorder_parameter == pytest.approx(late.std() / late.mean(), rel=1e-9)
    tensions = [piece.mean_wall_tension for piece in pieces]
    assert run.mean_wall_tension == pytest.approx(np.average(tensions, weights=LENGTHS))
    if noise == 0:
        rounding = 1e-12 if method == "event" else 3e-4
        assert abs(run.energy_residual) < rounding and abs(run.sum_rule_residual) < rounding


def test_chains_on_one_belt_go_on_together_as_alone():
    chains = [ChainParameters(3, speed, 1.0) for speed in (5.0, 10.0)]
    state = simulate(chains[0], duration=250, sample_interval=None).final_state
    settings = {"duration": 60, "belt": np.array([[20, 8.0], [40, 12.0]]), "initial_state": state}
    for run, chain in zip(simulate(chains, **settings), chains, strict=True):
        assert run == simulate(chain, **settings)
        speeds = [(0, chain.belt_velocity), (20, 8), (40, 12)]
        assert run.belt == speeds and run.final_state.time == 310
    one = {"duration": 60, "belt": [(0, 7.0)], "seed": 3}
    run = simulate(chains[0], **one)
    assert run == simulate(replace(chains[0], belt_velocity=7.0), duration=60, seed=3)
    assert run.belt == [(0, 7)] and run.changes == ()


def test_it_is_saved_drawn_and_told(tmp_path):
    run = simulate(ChainParameters(3, 5.0), duration=60, belt=[(0, 6), (30, 9)], transient=5)
    run.save(tmp_path / "run.h5")
    read = Run.load(tmp_path / "run.h5")
    assert read == run and read.belt == [(0, 6), (30, 9)]
    assert read.sum_rule_residual == run.sum_rule_residual
    assert "u=6, sigma=0, then 1 other u, event" in repr(run)
    axes = run.plot(tmp_path / "run.png").axes
    assert len(axes) == 3 and ", then 1 other u:  $r$ of all" in axes[0].get_title()


def test_a_belt_that_stops_holds_the_chain_and_goes_on():
    """Slide, hold, slide: what slips comes to rest, and the springs stay as they are then."""
    belt = [(100, 1e-6), (300, 5.0)]
    run = simulate(ChainParameters(5, 5.0), duration=400, belt=belt)
    held = (run.time > 150) & (run.time < 300)
    assert np.ptp(run.positions[held], axis=0).max() < 2e-4
    assert not np.any((run.events["time"] > 150) & (run.events["time"] < 300))
    assert run.events["time"][-1] > 310 and run.positions[-1, -1] > run.positions[held][0, -1]
    assert abs(run.energy_residual) < 1e-12 and abs(run.sum_rule_residual) < 1e-12


@pytest.mark.parametrize("belt", [[(20, 3), (41, 7)], [(31, 3)], [(25, 5), (31, 3), (58, 9)]])
def test_slips_and_avalanches_go_on_where_the_belt_changes(belt):
    """Sizes by the way of the belt, energies by force times way, from the samples."""
    run = simulate(ChainParameters(2, 5.0), duration=60, belt=belt, sample_interval=0.001)
    since = np.searchsorted([time for time, _ in run.belt], run.time, side="right") - 1
    speed = np.array([velocity for _, velocity in run.belt])[since]
    relative = run.velocities - speed[:, None]
    of_last = run.events[run.events["block"] == 2]
    slips = of_last["time"][: of_last.size // 2 * 2].reshape(-1, 2)
    way = [-relative[(run.time > a) & (run.time < b), 1].sum() * 0.001 for a, b in slips]
    assert slip_sizes(run, frame="belt").values == pytest.approx(way, rel=2e-3)
    moving = np.cumsum(np.where(run.events["kind"] == "slip", 1, -1))
    ends = run.events["time"][moving == 0]
    power = -(run.friction * relative).sum(axis=1) * 0.001
    lost = np.diff([power[run.time < end].sum() for end in (0.0, *ends)])
    energies = avalanche_energies(run, last_block=False).values
    assert energies == pytest.approx(lost, rel=2e-3) and energies.size


@pytest.mark.parametrize(
    ("belt", "said"),
    [
        (5, "belt = 5: pairs (t, u) are needed, as [(0, 5), (500, 10)]"),
        ([5, 10], "belt = [5, 10]: pairs (t, u) are needed"),
        ([(0, 5), (20, None)], "pairs (t, u) are needed"),
        ([(0, 5), (0, 6)], "t of belt[1] = 0: must be greater than 0"),
        ([(-1, 5)], "t of belt[0] = -1: must be at least 0 and at most 50"),
        ([(0, 5), (51, 6)], "t of belt[1] = 51: must be greater than 0"),
        ([(0, 0.0)], "u of belt[0] = 0: must be greater than 0"),
    ],
)
def test_a_wrong_belt_is_told_in_one_line(belt, said):
    with pytest.raises(InputError) as caught:
        simulate(ChainParameters(2, 5.0), duration=50, belt=belt)
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_verlet_changes_at_a_step():
    with pytest.raises(InputError, match=r"belt\[0\] at t = 20.0005: .* needs a multiple"):
        simulate(ChainParameters(2, 5.0), duration=50, belt=[(20.0005, 9)], method="verlet")
    state = ChainState.at_rest(ChainParameters(2, 5.0), time=10.0)
    run = simulate(state.parameters, duration=50, belt=[(20, 9)], initial_state=state)
    assert run.changes[0].time == 30
    ramp = np.column_stack([np.linspace(0, 50, 3), [5.0, 6.0, 7.0]])  # the last one has no length
    run = simulate(ChainParameters(2, 5.0), duration=50, belt=ramp)
    assert run.belt == [(0.0, 5.0), (25.0, 6.0)]

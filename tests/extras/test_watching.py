"""Watching a chain: what is shown is where the chain is; keys and sliders; films."""

from dataclasses import replace

import av
import numpy as np
import pytest
from matplotlib.backend_bases import KeyEvent
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from beltrepro import ChainParameters, simulate
from beltrepro.base.errors import ModelStateError
from beltrepro.cli import app as cli
from beltrepro.extras import watch
from beltrepro.model.units import LENGTH_M, TIME_S

CHAIN = ChainParameters(3, 15.0, 1.0)


@pytest.fixture
def window():
    canvas = FigureCanvasAgg(Figure(figsize=(8, 5)))
    return watch.Window(watch.Watched(CHAIN, 250.0, 4), canvas.figure, 2.0)


def test_what_is_shown_is_where_the_chain_is(window):
    first = window.chain.state
    reached = simulate(CHAIN, duration=250.0, seed=4).final_state
    assert np.array_equal(first.positions, reached.positions)
    for _ in range(40):
        window.show(1 / 24)
    state = window.chain.state
    assert state.time - first.time == pytest.approx(2.0 * 40 / 24 / TIME_S)
    assert window.chain.belt == pytest.approx(15.0 * (state.time - first.time))
    middles = [path.get_extents().intervalx.mean() for path in window.blocks.get_paths()]
    assert middles == pytest.approx(LENGTH_M * state.positions)
    edges = [to_rgb(watch.STATES[int(np.sign(way))][1]) for way in state.directions]
    assert np.allclose(window.blocks.get_edgecolor()[:, :3], edges)
    lasts = state.time - first.time
    run = simulate(CHAIN, duration=lasts, initial_state=first)
    places = np.isin(window.chain.seen[0].round(6), run.time.round(6))
    assert window.curve.get_ydata()[places] == pytest.approx(LENGTH_M * run.positions[:, -1])
    r = window.chain.disorder_parameter
    assert r == pytest.approx(run.disorder_parameter, rel=0.02)
    assert f"r = {r:.3f}" in window.numbers.get_text()


def test_r_is_that_of_the_chain_at_any_speed_and_the_curve_that_of_the_last_seconds():
    """Frames a period apart show the chain at one place; slow ones count by their time."""
    chain = watch.Watched(ChainParameters(1, 5.0), 200.0, 1)
    begin = chain.state
    for _ in range(4):
        chain.advance(15.79375)
    for _ in range(200):
        chain.advance(0.03)
    lasted = chain.state.time - begin.time
    run = simulate(begin.parameters, duration=lasted, initial_state=begin, sample_interval=0.01)
    assert chain.disorder_parameter == pytest.approx(run.disorder_parameter, rel=0.003)
    for _ in range(30):
        chain.advance(15.79375)
    assert np.ptp(chain.seen[0]) == pytest.approx(30 / TIME_S, abs=0.1)
    assert np.diff(chain.seen[0]).max() < 0.11


def test_keys_and_sliders_act_at_once_and_keep_the_positions(window, monkeypatch):
    window.show(1.0)
    before = window.chain.state
    window.velocity.set_val(31.5)
    window.noise.set_val(0.0)
    window.show(0.0)
    assert window.chain.state.parameters == replace(CHAIN, belt_velocity=31.5, noise=0.0)
    assert np.array_equal(window.chain.state.positions, before.positions)
    assert window.chain.disorder_parameter == 0  # begins anew
    for key, words in (
        (" ", "paused"),
        (" ", "speed × 2"),
        ("up", "speed × 4"),
        ("right", "paused"),
    ):
        KeyEvent("key_press_event", window.figure.canvas, key)._process()
        assert words in window.numbers.get_text()
    assert window.chain.state.time == before.time + 4 / 24 / TIME_S

    def fail(*_, **__):
        raise ModelStateError("blocks passed through each other")

    monkeypatch.setattr(watch.Watched, "advance", fail)
    window.show(0.1)
    assert window.paused and "passed through" in window.numbers.get_text()


def test_a_window_is_drawn_as_a_whole_picture_is(window):
    """What moves over a background that is kept."""
    canvas = window.figure.canvas
    window.start()
    window.speed = 0.0
    canvas.draw()
    for _ in range(3):
        window.chain.advance(1.0)
        window._animation._step()
    blitted = np.asarray(canvas.buffer_rgba()).copy()
    for artist in window.moving:
        artist.set_animated(False)
    canvas.draw()
    assert np.abs(blitted.astype(int) - np.asarray(canvas.buffer_rgba())).mean() < 0.5


def test_the_command_writes_a_film_in_which_the_last_block_is_white(tmp_path, capsys):
    path = tmp_path / "a.mp4"
    words = ["watch", "--n-blocks=2", "--belt-velocity=15", "--duration=0.125"]
    assert cli.main([*words, "--transient=30", f"--output={path}"]) == 0
    assert capsys.readouterr() == (f"{path}: 3 frames\n", "")
    with av.open(str(path)) as film:
        first = next(film.decode(video=0)).to_ndarray(format="rgb24")
    left, right = 0.06 * 1280, 0.97 * 1280  # of the axes
    inside = np.arange(int(left) + 3, int(right) - 2)
    row = first[200:240, inside].min(axis=(0, 2))  # a strip of the belt that the blocks fill
    middle = inside[row > 200].mean() + 0.5
    figure = Figure(figsize=(12.8, 7.2))
    chain = watch.Watched(ChainParameters(2, 15.0), 30.0, 1)
    end = watch.View(chain, figure).blocks.axes.get_xlim()[1]
    place = left + (right - left) * LENGTH_M * chain.state.positions[-1] / end
    assert middle == pytest.approx(place, abs=1.5)

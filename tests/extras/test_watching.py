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
    figure = Figure(figsize=(8, 5))
    FigureCanvasAgg(figure)
    return watch.Window(watch.begin(CHAIN, 250.0, 4), 2.0, 24.0, figure)


def test_what_is_shown_is_where_the_chain_is(window):
    first = window.chain.state
    assert np.array_equal(
        first.positions, simulate(CHAIN, duration=250.0, seed=4).final_state.positions
    )
    lengths = [first.positions[-1]]
    for _ in range(40):
        window.show(1 / 24)
        lengths.append(window.chain.state.positions[-1])
    state, view = window.chain.state, window.view
    assert state.time - first.time == pytest.approx(2.0 * 40 / 24 / TIME_S)
    assert window.chain.belt == pytest.approx(15.0 * (state.time - first.time))
    places = LENGTH_M * state.positions
    middles = [path.get_extents().intervalx.mean() for path in view.blocks.get_paths()]
    assert middles == pytest.approx(places)
    edges = [to_rgb(watch.STATES[int(np.sign(way))][1]) for way in state.directions]
    assert np.allclose(view.blocks.get_edgecolor()[:, :3], edges)
    length, disorder = (curve.get_ydata() for curve in view.curves)
    assert length[-1] == places[-1] and len(length) == 41
    r = np.std(lengths) / np.mean(lengths)
    assert disorder[-1] == pytest.approx(r) and f"r = {r:.3f}" in view.numbers.get_text()


def test_keys_and_sliders_act_at_once_and_keep_the_positions(window, monkeypatch):
    before = window.chain.state
    window.velocity.set_val(31.5)
    window.noise.set_val(0.0)
    window.show(0.0)
    assert window.chain.state.parameters == replace(CHAIN, belt_velocity=31.5, noise=0.0)
    assert np.array_equal(window.chain.state.positions, before.positions)
    for key, words in (
        (" ", "paused"),
        (" ", "speed × 2"),
        ("up", "speed × 4"),
        ("right", "paused"),
    ):
        KeyEvent("key_press_event", window.view.figure.canvas, key)._process()
        assert words in window.view.numbers.get_text()
    assert window.chain.since < window.chain.state.time == before.time + 4 / 24 / TIME_S
    KeyEvent("key_press_event", window.view.figure.canvas, "c")._process()
    assert window.chain.since == window.chain.state.time

    def fail(*_):
        raise ModelStateError("blocks passed through each other")

    monkeypatch.setattr(watch.Watched, "advance", fail)
    window.show(0.1)
    assert window.paused and "passed through" in window.view.numbers.get_text()


def test_the_command_writes_a_film_in_which_the_last_block_is_white(tmp_path, capsys):
    path = tmp_path / "a.mp4"
    words = ["watch", "--n-blocks=2", "--belt-velocity=15", "--fps=10", "--duration=0.3"]
    assert cli.main([*words, "--transient=30", f"--output={path}"]) == 0
    said = capsys.readouterr()
    assert said.out.startswith(f"{path}: ") and said.err == ""
    scale_m = float(said.out.split()[1]) / 1000
    with av.open(str(path)) as film:
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(frames) == 3
    line = frames[0][180:260].min(axis=(0, 2))  # a strip of the belt that the last block fills
    line[[*range(80), *range(1230, 1280)]] = 0  # the frame of the axes
    (white,) = np.nonzero(line > 200)
    run = simulate(ChainParameters(2, 15.0), duration=30.0)
    place = 0.06 * 1280 + (LENGTH_M * run.final_state.positions[-1] + 0.02) / scale_m
    assert white.mean() + 0.5 == pytest.approx(place, abs=1.5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"output": "a.mp4", "duration": "0.01"}, "a film of at least one frame needs 0.0417 s"),
        ({"output": "a.gif"}, "a.gif: must end in .mp4"),
        ({"fps": "0"}, "fps = 0: must be at least 1 and at most 120"),
        ({"speed": "-1"}, "speed = -1: must be at least 0.05 and at most 50"),
        ({"duration": "5"}, "only a film has one, give --output too"),
        ({}, "no display to open a window on: write a film with --output"),
    ],
)
def test_bad_input_is_one_line(changes, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(watch.picture, "display", lambda: "")
    settings = {"n-blocks": "2", "belt-velocity": "15"} | changes
    assert cli.main(["watch", *(f"--{name}={value}" for name, value in settings.items())]) == 2
    said = capsys.readouterr()
    assert said.out == "" and message in said.err and len(said.err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []

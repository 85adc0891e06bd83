"""Watching a chain: the model without a display, what is drawn, keys and sliders, films."""

import time
from dataclasses import replace

import av
import matplotlib
import numpy as np
import pytest
from matplotlib.backend_bases import KeyEvent
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from beltrepro import ChainParameters, ChainState, simulate
from beltrepro.base.errors import ModelStateError
from beltrepro.cli import app as cli
from beltrepro.extras import watch
from beltrepro.extras.watch import Clock, Player, View, Window, begin, look, write_film
from beltrepro.extras.watch.player import KEPT
from beltrepro.extras.watch.scenery import BLOCK_ALONG, visible_length
from beltrepro.extras.watch.view import span_of
from beltrepro.model.spring import chain_deformations, spring_extension, spring_force
from beltrepro.model.units import FORCE_N, LENGTH_M, TIME_S

CHAIN = ChainParameters(3, 15.0, 1.0)
CLOCK = Clock(speed=2.0)
FRAME = CLOCK.ticks_of_frame
# Where a run is cut off the grid of 250, the method shows its truncation (docs/states.md).
CUT = 1e-6


def player(chain=CHAIN, clock=CLOCK, seed=4):
    return Player.begin(ChainState.at_rest(chain, seed=seed), clock.tick)


@pytest.fixture(scope="module")
def later():
    """A chain that has slipped for a while."""
    return player().advance(60 * FRAME)


# --- the model ------------------------------------------------------------------------------------


def shown_by_simulate(chain=CHAIN, tick=CLOCK.tick, duration=750):
    """One long run, sampled at each tick."""
    return simulate(chain, duration=duration, method="event", seed=4, sample_interval=tick)


@pytest.mark.parametrize(
    ("noise", "tick", "pieces"),
    [
        (0.0, CLOCK.tick, [1, FRAME, 7, 3 * FRAME, 2500, FRAME, 5000, 1, 900]),
        (1.0, CLOCK.tick, [1, FRAME, 7, 3 * FRAME, 2500, FRAME, 5000, 1, 900]),
        (1.0, 400.0, [1, 2]),  # the run is cut within a tick
    ],
)
def test_pieces_are_one_long_run_bit_for_bit(noise, tick, pieces):
    chain = replace(CHAIN, noise=noise)
    now, row = Player.begin(ChainState.at_rest(chain, seed=4), tick), 0
    run = shown_by_simulate(chain, tick, duration=1250)
    for ticks in pieces:
        now, row = now.advance(ticks), row + ticks
        assert now.time == run.time[row]
        assert np.array_equal(now.positions, run.positions[row])
        slips = run.velocities[row] != chain.belt_velocity
        assert np.array_equal(now.directions != 0, slips)
    assert now.time > 500  # two cuts have been passed
    assert now.advance(0).time == now.time


def test_other_parameters_keep_positions_and_act_at_once(later):
    faster = replace(CHAIN, belt_velocity=30.0, noise=0.0)
    state, changed = later.state, later.under(faster)
    assert later.under(CHAIN) is later
    for same in (state, changed):
        assert same.time == pytest.approx(later.time, rel=1e-12)
        assert np.allclose(same.positions, later.positions, rtol=0, atol=CUT)
        assert np.array_equal(same.directions == 0, later.directions == 0)
    run = simulate(
        faster, duration=50, initial_state=state.under(faster), sample_interval=CLOCK.tick
    )
    after = changed.advance(20)
    assert after.time == pytest.approx(later.time + 20 * CLOCK.tick, rel=1e-12)
    assert np.allclose(after.positions, run.positions[19], rtol=0, atol=CUT)
    assert later.belt == pytest.approx(15.0 * later.time)
    assert after.belt == pytest.approx(15.0 * later.time + 30.0 * 20 * CLOCK.tick)


def test_r_and_mean_length_are_those_of_what_was_shown():
    now, lengths = player().advance(2000), shown_by_simulate().positions[:, -1]
    later = now.anew().advance(1500)
    for record, shown in ((now.record, lengths[:2001]), (later.record, lengths[2000:3501])):
        assert record.disorder_parameter == pytest.approx(shown.std() / shown.mean(), rel=1e-9)
        assert record.mean_length == pytest.approx(shown.mean(), rel=1e-12)
        first = [shown[:count].std() / shown[:count].mean() for count in (1, 2, 3, 10)]
        assert record.disorder[: len(shown)][[0, 1, 2, 9]] == pytest.approx(first, rel=1e-6)
    recent = lengths[:3501][-len(later.record.length) :]
    assert np.array_equal(later.record.length, recent) and len(recent) > 1000
    assert later.record.since == now.time and len(later.record.disorder) == 1501
    again = later.under(replace(CHAIN, noise=2.0)).advance(1)
    assert again.record.count == 2 and len(again.record.length) > 1000


@pytest.mark.parametrize(("transient", "shown_before"), [(0, 0), (120, 120), (700, KEPT)])
def test_a_transient_is_seen_in_the_trace_and_left_out_of_r(transient, shown_before):
    first = begin(CHAIN, CLOCK, transient, 4)
    assert first.record.since == first.time == transient
    before = first.record.time - first.time
    assert before[0] == pytest.approx(-shown_before, abs=CLOCK.tick)
    assert np.allclose(np.diff(before), CLOCK.tick, rtol=0, atol=CLOCK.tick)
    assert (np.diff(before) > 0).all() and before[-1] == 0
    run = shown_by_simulate(duration=750)
    expected = np.interp(first.record.time, run.time, run.positions[:, -1])
    assert np.allclose(first.record.length, expected, atol=0.01)
    assert f"since {transient * TIME_S:.1f} s: r = 0.000" in words(first)
    for now in (first, first.anew(), first.under(replace(CHAIN, noise=2.0)), first.advance(FRAME)):
        assert np.isfinite(now.record.disorder).all() and "nan" not in words(now)


def words(player):
    """The line of numbers."""
    return View(player, CLOCK).numbers.get_text()


@pytest.mark.parametrize(("seconds", "span"), [(0.25, 0.5), (14.0, 28.0), (20.0, 30.0)])
def test_a_short_film_fills_its_curves(seconds, span):
    assert View(player(), CLOCK, span=span_of(CLOCK, seconds)).strips.length.axes.get_xlim() == (
        pytest.approx(-span), 0
    )  # fmt: skip


def test_a_clock_pauses_steps_and_changes_speed():
    clock = Clock(speed=0.5, frames_per_second=30)
    assert clock.ticks_of_frame * clock.tick * TIME_S == pytest.approx(0.5 / 30)
    fast, slow = clock.changed(1), clock.changed(-1)
    assert fast.shown_speed == 1.0 and slow.shown_speed == 0.25
    assert (fast.ticks_of_frame, slow.ticks_of_frame) == (
        2 * clock.ticks_of_frame, clock.ticks_of_frame // 2
    )  # fmt: skip
    assert fast.tick == slow.tick == clock.tick
    assert clock.changed(-9).ticks_of_frame == 1 and clock.changed(9).shown_speed == 8.0


# --- the picture ----------------------------------------------------------------------------------


@pytest.mark.parametrize("n_blocks", [1, 12])
def test_artists_are_where_the_chain_is(n_blocks):
    chain = ChainParameters(n_blocks, 15.0, 1.0)
    now = player(chain)
    view = View(now, CLOCK)
    now = now.advance(70 * FRAME)
    view.draw(now, CLOCK)
    picture, places = view.picture, LENGTH_M * now.positions
    centres = [block.get_x() + block.get_width() / 2 for block in picture.blocks]
    assert np.allclose(centres, places, rtol=0, atol=1e-12)
    colours = [block.get_edgecolor()[:3] for block in picture.blocks]
    expected = [look.STUCK if one == 0 else look.SLIPPING for one in now.directions]
    assert colours == [to_rgb(colour) for colour in expected]
    for shape, direction in (("s", 0), ("<", -1), (">", 1)):
        assert np.allclose(picture.signs[shape].get_xdata(), places[now.directions == direction])
    white = [block.get_facecolor()[:3] == (1, 1, 1) for block in picture.blocks]
    assert white == [False] * (n_blocks - 1) + [True]
    pull = -FORCE_N * spring_force(chain_deformations(now.positions, chain), chain)
    assert np.allclose(picture.springs.get_array(), pull)
    ends = np.array([line[[0, -1], 0] for line in picture.springs.get_segments()])
    assert np.allclose(ends[:, 1], places - BLOCK_ALONG / 2)
    assert np.allclose(ends[:, 0], np.append(0, places[:-1] + BLOCK_ALONG / 2))
    time, length = view.strips.length.get_data()
    assert time[-1] == 0 and length[-1] == places[-1]
    assert view.strips.disorder.get_ydata()[-1] == now.record.disorder_parameter
    assert f"r = {now.record.disorder_parameter:.3f}" in view.numbers.get_text()


def test_belt_marks_move_with_the_belt(later):
    view = View(later, CLOCK)
    first, spacing = marks(view)
    view.show(later.advance(1), CLOCK)
    turns = (marks(view)[0] - first - LENGTH_M * 15.0 * CLOCK.tick) / spacing
    assert turns == pytest.approx(round(turns), abs=1e-7)


def marks(view):
    """Place of the first mark, and the distance between two."""
    one, other = (line[0, 0] for line in view.picture.marks.get_segments()[:2])
    return one, other - one


def test_a_frame_drawn_over_the_last_one_is_that_drawn_afresh(later):
    one, other = View(later, CLOCK), View(later.advance(5 * FRAME), CLOCK)
    one.draw(later, CLOCK)
    before = one.pixels()
    one.draw(later.advance(5 * FRAME), CLOCK)
    other.draw(later.advance(5 * FRAME), CLOCK)
    assert np.array_equal(one.pixels(), other.pixels())
    assert not np.array_equal(one.pixels(), before)


def test_the_white_block_is_where_it_is_in_the_pixels(later):
    """A film can be measured: the block is white, alone, and at its place by the tape."""
    view = View(later, CLOCK)
    view.draw(later, CLOCK)
    zero, row = view.picture.rim.axes.transData.transform((0.0, 0.0))
    for ticks in (0, 37, 111, 250, 400):
        now = later.advance(ticks)
        view.draw(now, CLOCK)
        line = view.pixels()[-1 - round(row) - 30].min(axis=1).astype(float)  # beside the spring
        line[: round(zero)] = 0.0  # the wall
        white = np.maximum(line - 100, 0.0)  # the coloured edges have less of some colour
        middle = (white * (np.arange(len(line)) + 0.5)).sum() / white.sum()
        place = (middle - zero) * view.metres_per_pixel
        assert place == pytest.approx(LENGTH_M * now.positions[-1], abs=0.2 * view.metres_per_pixel)


# --- the window -----------------------------------------------------------------------------------


@pytest.fixture
def window(later):
    figure = Figure(figsize=(8, 5))
    FigureCanvasAgg(figure)
    return Window(later, CLOCK, figure)


def press(window, key):
    KeyEvent("key_press_event", window.view.canvas, key)._process()


def test_a_window_goes_on_in_real_time(window, later):
    # regular frames, none, and some at other times than planned
    for frames, seconds, late in ((6, 1 / 24, 1e-9), (1, 0.0, 1e-9), (7, 0.011, CLOCK.tick)):
        before = window.player.time
        for _ in range(frames):
            window.tick(seconds)
        shown = window.player.time - before
        assert shown == pytest.approx(2.0 * frames * seconds / TIME_S, abs=late)
    before = window.player.time
    window.tick(100.0)  # the machine slept: no leap
    assert window.player.time - before < 2.0 * 0.3 / TIME_S


@pytest.mark.thorough
def test_keys(window):
    press(window, " ")
    before = window.player.time
    window.tick(0.1)
    assert window.player.time == before and "paused" in window.view.settings.get_text()
    press(window, "right")
    assert window.player.time - before == pytest.approx(FRAME * CLOCK.tick)
    for key in (" ", "up"):
        press(window, key)
    assert window.clock.shown_speed == 4.0 and not window.clock.paused
    for key in ("down", "down", "right", "x"):  # the last is no key of the window
        press(window, key)
    assert "speed × 1" in window.view.settings.get_text() and window.clock.paused
    assert window.player.record.count > 1
    press(window, "c")
    assert window.player.record.count == 1 and window.player.record.since == window.player.time


def test_sliders_act_at_once_and_keep_the_positions(window):
    assert (window.velocity.val, window.noise.val) == (15.0, 1.0)
    before = window.player
    window.velocity.set_val(31.5)
    window.noise.set_val(0.0)
    window.tick(0.0)
    assert window.player.parameters == replace(CHAIN, belt_velocity=31.5, noise=0.0)
    assert np.allclose(window.player.positions, before.positions, rtol=0, atol=CUT)
    assert "u = 31.5" in window.view.settings.get_text()


def test_a_chain_that_cannot_go_on_says_so(window, monkeypatch):
    def fail(self, ticks):
        raise ModelStateError("blocks passed through each other")

    monkeypatch.setattr(Player, "advance", fail)
    window.tick(0.1)
    assert window.clock.paused
    assert window.complaint.get_text() == "blocks passed through each other"


# --- films ----------------------------------------------------------------------------------------


@pytest.mark.thorough
def test_an_mp4_has_its_frames_and_duration(tmp_path, later):
    path, clock = tmp_path / "a.mp4", replace(CLOCK, frames_per_second=25.0)
    begin = Player.begin(later.state, clock.tick)
    shares = []
    view = write_film(path, begin, clock, 0.32, shares.append)
    with av.open(str(path)) as film:
        (stream,) = film.streams
        frames = list(film.decode(video=0))
        assert (stream.width, stream.height) == (1280, 720)
        assert float(stream.duration * stream.time_base) == pytest.approx(0.32)
    assert [frame.time for frame in frames] == pytest.approx(np.arange(8) / 25)
    assert shares == [(number + 1) / 8 for number in range(8)]
    view.draw(begin.advance(7 * clock.ticks_of_frame), clock)
    shown = frames[-1].to_ndarray(format="rgb24").astype(float)
    assert np.abs(shown - view.pixels()).mean() < 3  # the last frame, as far as the codec keeps it


@pytest.mark.slow
@pytest.mark.parametrize("n_blocks", [5, 10])
def test_a_core_draws_24_frames_in_a_second(n_blocks):
    clock = Clock()
    player = begin(ChainParameters(n_blocks, 15.3, 1.0), clock, 250.0, 1)
    figure = Figure(figsize=(12.8, 7.2))
    FigureCanvasAgg(figure)
    window = Window(player, clock, figure)
    window.tick(1 / 24)  # draws all, the next ones what moves
    start = time.process_time()
    for _ in range(48):
        window.tick(1 / 24)
    assert time.process_time() - start < 2.0


def test_the_command_opens_a_window_on_the_chain_that_it_is_told(monkeypatch):
    opened = []
    monkeypatch.setattr(watch, "check_display", lambda: None)
    monkeypatch.setattr(watch, "open_window", lambda *shown: opened.append(shown))
    words = ["--n-blocks=3", "--belt-velocity=15", "--noise=1", "--friction-ratio=0.3"]
    words += ["--transient=40", "--seed=4", "--speed=2", "--fps=12"]
    assert cli.main(["watch", *words]) == 0
    ((shown, clock),) = opened
    chain = replace(CHAIN, friction_ratio=0.3)
    assert clock == Clock(speed=2.0, frames_per_second=12.0)
    run = simulate(chain, duration=40, seed=4, sample_interval=None)
    np.testing.assert_array_equal(shown.positions, run.final_state.positions)
    assert (shown.parameters, shown.time, shown.tick) == (chain, 40, clock.tick)


def test_the_command_writes_a_film(tmp_path, capsys):
    path = tmp_path / "a.mp4"
    words = ["watch", "--n-blocks=2", "--belt-velocity=15", "--fps=10", "--duration=0.3"]
    assert cli.main([*words, "--transient=30", f"--output={path}"]) == 0
    said = capsys.readouterr()
    assert said.out.startswith(f"{path}: ") and said.err == ""
    with av.open(str(path)) as film:
        assert len(list(film.decode(video=0))) == 3


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
    monkeypatch.setenv("MPLBACKEND", "agg")
    settings = {"n-blocks": "2", "belt-velocity": "15"} | changes
    assert cli.main(["watch", *(f"--{name}={value}" for name, value in settings.items())]) == 2
    said = capsys.readouterr()
    assert said.out == "" and message in said.err and len(said.err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_toolkit_without_a_display_is_one_line(capsys, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with matplotlib.rc_context({"backend": "agg"}):
        matplotlib.rcParams["backend"] = "tkagg"
        status = cli.main(["watch", "--n-blocks=2", "--belt-velocity=15"])
    said = capsys.readouterr()
    assert status == 2 and "no display" in said.err and len(said.err.splitlines()) == 1


@pytest.mark.parametrize(
    ("u", "noise", "ends"), [(15.0, 1.0, (50.0, 10.0)), (80.0, 10.5, (80.0, 10.5))]
)
def test_sliders_reach_over_the_scans_of_the_paper_and_to_the_chain(u, noise, ends):
    figure = Figure()
    FigureCanvasAgg(figure)
    window = Window(player(ChainParameters(3, u, noise)), CLOCK, figure)
    assert (window.velocity.valmax, window.noise.valmax) == ends


def test_the_belt_holds_a_chain_each_of_whose_springs_pulls_all_blocks_behind_it():
    chain = ChainParameters(3, 15.0, static_friction=(40.0, 70.0, 130.0))
    extensions = spring_extension(np.array([40 + 70 + 130, 70 + 130, 130.0]), chain)
    assert spring_force(extensions, chain) == pytest.approx([-240, -200, -130])
    longest = LENGTH_M * (150 + extensions.sum())
    assert longest < visible_length(chain) < 1.1 * longest
    other = replace(chain, static_friction=(130.0, 70.0, 40.0))
    assert visible_length(other) < visible_length(chain)

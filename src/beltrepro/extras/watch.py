"""One chain seen from above, in real time: in a window, or as a film."""

import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.widgets import Slider

from beltrepro.base import checks
from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.model.spring import chain_deformations, spring_extension, spring_force
from beltrepro.model.units import FORCE_N, LENGTH_M, TIME_S, VELOCITY_M_S
from beltrepro.replication.camera.scene import Scene
from beltrepro.replication.camera.video import Frame, write_video
from beltrepro.simulation import picture
from beltrepro.simulation.run import Run
from beltrepro.simulation.trajectories import simulate

NO_DISPLAY = "no display to open a window on: write a film with --output chain.mp4"
KEYS = "space: pause     →: one step     ↑ ↓: faster, slower     c: r from here on     q: close"
SCENE = Scene()  # sizes of what lies on the belt, m
KEPT = 30.0 / TIME_S  # model time of the curves: thirty seconds of the belt
FASTEST = 16.0  # of the speed at the start, by keys
_WALL, _LINES = 0.02, 0.1  # m: width of the wall, distance of the lines across the belt
_CORNERS = np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]]) / 2
_CORNERS *= [SCENE.block_length, SCENE.block_width]
_ROOM_BEYOND = 1.05  # of the length at which the springs balance static friction
_WIDEST = 0.25  # m across the belt on each side; a longer chain is not to scale across
# Okabe and Ito's palette: distinct for colour-blind readers, by the direction of the slip.
STATES = {0: ("stuck to the belt", "#56b4e9"), -1: ("slips back over the belt", "#e69f00"),
          1: ("slips forward", "#cc79a7")}  # fmt: skip
_ROOM, _BELT, _MARKS, _TEXT = "#0d0f12", "#24282d", "#33383e", "#d5d9de"
_SPRINGS = LinearSegmentedColormap.from_list("springs", ("#b57bff", "#e8e8e8", "#22c48b"))
_COLOURS = {"figure.facecolor": _ROOM, "axes.facecolor": _ROOM, "text.color": _TEXT}
_STYLE: list[Any] = ["default", "dark_background", _COLOURS]
_SIZE = 12.8, 7.2  # inches


class Watched:
    """A chain at the instant that is shown, and the way of its last block up to it."""

    def __init__(self, state: ChainState) -> None:
        self.state, self.belt = state, 0.0  # how far the belt has moved, model length
        self.seen = np.empty((0, 3))  # time, x_N and r up to then, of the last thirty seconds
        self.begin_anew()

    def begin_anew(self) -> None:
        """Let r and <x_N> begin with what is shown now."""
        self.since = self.state.time
        self._lengths: list[float] = []
        self._see()

    def _see(self) -> None:
        self._lengths.append(float(self.state.positions[-1]))
        self.mean_length = float(np.mean(self._lengths))
        self.disorder_parameter = float(np.std(self._lengths)) / self.mean_length
        recent = self.seen[self.seen[:, 0] >= self.state.time - KEPT]
        row = self.state.time, self._lengths[-1], self.disorder_parameter
        self.seen = np.vstack([recent, row])

    def advance(self, duration: float, under: ChainParameters | None = None) -> None:
        """Go on by a model time; under other parameters r and <x_N> begin anew."""
        if under not in (None, self.state.parameters):
            self.state = self.state.under(under)
            self.begin_anew()
        if duration > 0:
            self.state = _run(self.state, duration).final_state
            self.belt += duration * self.state.parameters.belt_velocity
            self._see()


def begin(parameters: ChainParameters, transient: float, seed: int) -> Watched:
    """A chain to watch after a transient from undeformed springs (Sec. III), which r leaves out."""
    state = ChainState.at_rest(parameters, seed=seed)
    if checks.not_negative("transient", transient) > 0:
        state = _run(state, transient).final_state
    return Watched(state)


def _run(state: ChainState, duration: float) -> Run:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # r of so short a run is asked by nobody
        how: Any = {"initial_state": state, "sample_interval": None}
        run = simulate(state.parameters, duration=duration, **how)
    assert isinstance(run, Run)  # as it was one chain
    return run


class View:
    """Draws a chain. What stands still is drawn once, the rest again for each frame."""

    def __init__(self, chain: Watched, figure: Figure, words: str, foot: float = 0.0) -> None:
        self.figure = figure
        self._still: Any = None  # what stands still, drawn
        parameters = chain.state.parameters
        with matplotlib.style.context(_STYLE):
            belt, length, disorder = (
                figure.add_axes((0.06, foot + place * (1 - foot), 0.91, height * (1 - foot)))
                for place, height in ((0.54, 0.31), (0.27, 0.2), (0.08, 0.16))
            )
            self.numbers = figure.text(0.06, 0.955, "", fontsize=13)
            self._draw_belt(belt, parameters)
            for axes, word in ((length, "$x_N$ (m)"), (disorder, "$r$")):
                axes.set(xlim=(-TIME_S * KEPT, 0), ylabel=word)
                axes.grid(alpha=0.2)
            rest = LENGTH_M * parameters.rest_positions[-1]
            length.set(ylim=(0.6 * rest, visible_length(parameters)))
            length.tick_params(labelbottom=False)
            disorder.set(ylim=(0, 0.25), xlabel="seconds of the chain before now")
            self.curves = [axes.plot([], [], color=_TEXT, lw=1.2)[0] for axes in (length, disorder)]
        self._disorder = disorder
        self._moving = [self.marks, self.springs, self.blocks, *self.curves, self.numbers]
        for artist in self._moving:
            artist.set_animated(True)
        figure.canvas.mpl_connect("draw_event", self._draw_moving)
        self.draw(chain, words)

    def _draw_belt(self, axes, chain):
        """The belt to scale; a short chain leaves some of it free, so that it fills the axes."""
        box = axes.bbox
        fills = 1.5 * SCENE.block_width * box.width / box.height - _WALL
        self.end = max(visible_length(chain), fills)
        self.metres_per_pixel = (self.end + _WALL) / box.width
        across = min(self.metres_per_pixel * box.height / 2, _WIDEST)
        axes.set(xlim=(-_WALL, self.end), ylim=(-across, across), yticks=[], facecolor=_BELT)
        axes.set_xlabel("m", loc="right", labelpad=-8)
        axes.axvspan(-_WALL, 0, facecolor=_ROOM, edgecolor="0.6", hatch="////", lw=0)
        # full colour at the kinetic friction of all blocks
        ratio = np.maximum(chain.friction_ratio, 0.1)
        strong = FORCE_N * (chain.by_block("static_friction") * ratio).sum()
        self.marks = LineCollection([], colors=_MARKS, linewidths=1.5)
        self.springs = LineCollection([], cmap=_SPRINGS, norm=Normalize(-strong, strong), lw=1.5)
        # only the last block is white, so that a tracker finds it
        faces = ["black"] * (chain.n_blocks - 1) + ["white"]
        edge = np.clip(0.1 * SCENE.block_length / self.metres_per_pixel, 1.0, 2.5)
        self.blocks = PolyCollection([], facecolors=faces, linewidths=edge, snap=False)
        for order, artist in enumerate((self.marks, self.springs, self.blocks), start=2):
            artist.set_zorder(order)
            axes.add_collection(artist, autolim=False)
        states = [
            Patch(facecolor="black", edgecolor=c, label=words) for words, c in STATES.values()
        ]
        axes.legend(
            handles=states, ncols=3, loc="lower right", bbox_to_anchor=(1, 1), frameon=False
        )
        scale = self.figure.add_axes((0.06, 0.88, 0.2, 0.014))
        self.figure.colorbar(self.springs, cax=scale, orientation="horizontal")
        scale.set_title("pull of a spring (N): below 0 compressed", fontsize=9, pad=3, loc="left")

    def draw(self, chain: Watched, words: str) -> None:
        """Draw a frame on the canvas."""
        state, parameters = chain.state, chain.state.parameters
        places = LENGTH_M * state.positions
        marks = np.arange(LENGTH_M * chain.belt % _LINES, self.end, _LINES)
        self.marks.set_segments([[(mark, -_WIDEST), (mark, _WIDEST)] for mark in marks])
        self.springs.set_segments(list(_zigzags(places)))
        pulls = -spring_force(chain_deformations(state.positions, parameters), parameters)
        self.springs.set_array(FORCE_N * pulls)
        self.blocks.set_verts(_CORNERS + np.array([places, 0 * places]).T[:, None])
        self.blocks.set_edgecolor([STATES[int(way)][1] for way in np.sign(state.directions)])
        time_s, length, disorder = chain.seen.T * [[TIME_S], [LENGTH_M], [1.0]]
        for curve, values in zip(self.curves, (length, disorder), strict=True):
            curve.set_data(time_s - TIME_S * state.time, values)
        means = f"r = {chain.disorder_parameter:.3f}, mean {LENGTH_M * chain.mean_length:.3f} m"
        self.numbers.set_text(
            f"t = {TIME_S * state.time:.1f} s    since {TIME_S * chain.since:.1f} s: {means}    "
            f"N = {parameters.n_blocks}    u = {parameters.belt_velocity:.4g} "
            f"({VELOCITY_M_S * parameters.belt_velocity:.2f} m/s)    σ = {parameters.noise:.3g}    "
            f"{words}"
        )
        canvas: Any = self.figure.canvas
        if self._still is None or disorder.max() > self._disorder.get_ylim()[1]:
            self._disorder.set_ylim(0, max(0.25, 1.2 * disorder.max()))
            canvas.draw()  # calls _draw_moving
        else:
            canvas.restore_region(self._still)
            self._draw_moving()
            canvas.blit(self.figure.bbox)

    def _draw_moving(self, event: Any = None) -> None:
        """Draw it over what stands still, which is kept after a full drawing."""
        if event:
            self._still = event.canvas.copy_from_bbox(self.figure.bbox)
        for artist in self._moving:
            self.figure.draw_artist(artist)


def visible_length(chain: ChainParameters) -> float:
    """Length of belt that a chain needs, in metres."""
    pulls = np.cumsum(chain.by_block("static_friction")[::-1])[::-1]
    stretched = (chain.by_block("rest_length") + spring_extension(pulls, chain)).sum()
    return float(LENGTH_M * stretched * _ROOM_BEYOND)


def _zigzags(places: np.ndarray) -> np.ndarray:
    """Lines (N, points, 2) from the wall to the first block, and from block to block."""
    far = places - SCENE.block_length / 2
    near = np.append(0.0, places[:-1] + SCENE.block_length / 2)
    along = np.concatenate([[0.0], np.linspace(0.1, 0.9, 2 * SCENE.coils), [1.0]])
    lines = np.zeros((len(places), len(along), 2))
    lines[:, :, 0] = near[:, None] + (far - near)[:, None] * along
    lines[:, 2:-2, 1] = SCENE.spring_width * (-1.0) ** np.arange(len(along) - 4)
    return lines


def write_film(
    path: Path, chain: Watched, speed: float, frames_per_second: float, duration: float,
    progress: Callable[[float], None] | None = None,
) -> View:  # fmt: skip
    """Write a film of a chain from now on; the file appears under its name when it is complete."""
    count = round(duration * frames_per_second)
    if checks.positive("duration", duration) and count < 1:
        least = f"a film of at least one frame needs {1 / frames_per_second:.3g} s"
        raise InputError(f"duration = {duration:g}: {least}")
    figure, words = Figure(figsize=_SIZE, dpi=100, facecolor=_ROOM), f"speed × {speed:g}"
    canvas = FigureCanvasAgg(figure)
    view = View(chain, figure, words)

    def frames() -> Iterator[Frame]:
        for number in range(count):
            chain.advance(speed / frames_per_second / TIME_S if number else 0.0)
            view.draw(chain, words)
            pixels = np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
            yield Frame(number / frames_per_second, pixels)
            if progress:
                progress((number + 1) / count)

    write_video(path, frames(), frames_per_second=frames_per_second, preset="medium")
    return view


class Window:
    """A view that goes on by itself, with keys and sliders."""

    def __init__(
        self, chain: Watched, speed: float, frames_per_second: float, figure: Figure
    ) -> None:
        self.chain, self.speed, self.paused = chain, speed, False
        self.complaint = ""  # why the chain cannot go on
        self._range = speed / FASTEST, speed * FASTEST
        self._frame = 1 / frames_per_second
        self.view = View(chain, figure, "", foot=0.12)
        parameters = chain.state.parameters
        figure.text(0.06, 0.02, KEYS, color=_TEXT)
        # up to the ends of the scans of the paper
        velocity = 0.16, "belt velocity u", 0.1, max(50.0, parameters.belt_velocity)
        noise = 0.62, "noise σ", 0.0, max(10.0, parameters.noise)
        self.velocity = _slider(figure, *velocity, parameters.belt_velocity)
        self.noise = _slider(figure, *noise, parameters.noise)
        figure.canvas.mpl_connect("key_press_event", self._key)
        self._last = time.monotonic()

    def on_timer(self) -> None:
        """Go on by the time since the last call, but not by a time that the machine slept."""
        now = time.monotonic()
        seconds, self._last = now - self._last, now
        self.show(0.0 if self.paused else min(seconds, 0.25))

    def show(self, seconds: float) -> None:
        """Go on by a time of the real world under what the sliders say, and draw."""
        now = self.chain.state.parameters
        under = replace(now, belt_velocity=self.velocity.val, noise=self.noise.val)
        try:
            self.chain.advance(seconds * self.speed / TIME_S, under)
        except ModelStateError as error:
            self.paused, self.complaint = True, str(error)
        state = "paused" if self.paused else f"speed × {self.speed:g}"
        self.view.draw(self.chain, self.complaint or state)

    def _key(self, event: Any) -> None:
        if event.key == "c":
            self.chain.begin_anew()
        elif event.key in (" ", "right"):
            self.paused, self.complaint = event.key == "right" or not self.paused, ""
        elif event.key in ("up", "down"):
            faster = self.speed * (2.0 if event.key == "up" else 0.5)
            self.speed = float(np.clip(faster, *self._range))
        self.show(self._frame if event.key == "right" else 0.0)


def _slider(figure: Figure, left: float, name: str, low: float, high: float, now: float) -> Slider:
    axes = figure.add_axes((left, 0.065, 0.3, 0.03))
    colours: Any = {"color": STATES[0][1], "track_color": _BELT, "initcolor": "none"}
    slider = Slider(axes, name, low, high, valinit=now, valfmt="%.2f", **colours)
    for text in (slider.label, slider.valtext):
        text.set_color(_TEXT)
    return slider


def open_window(chain: Watched, speed: float, frames_per_second: float) -> None:
    """Show a chain in a window until it is closed."""
    import matplotlib.pyplot as plt

    if picture.display() != "window":
        raise InputError(NO_DISPLAY)
    # the keys of the window are its own
    keys: Any = {name: [] for name in matplotlib.rcParams if name.startswith("keymap.")}
    keys |= {"keymap.quit": ["q"], "toolbar": "None"}
    with matplotlib.rc_context(keys):
        figure = plt.figure("beltrepro watch", figsize=_SIZE, facecolor=_ROOM)
        window = Window(chain, speed, frames_per_second, figure)
        timer = figure.canvas.new_timer(interval=round(1000 / frames_per_second))
        timer.add_callback(window.on_timer)
        figure.canvas.mpl_connect("close_event", lambda event: timer.stop())
        timer.start()
        plt.show()

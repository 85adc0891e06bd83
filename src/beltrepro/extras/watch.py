"""One chain seen from above, in real time: in a window, or as a film."""

import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.widgets import Slider

from beltrepro.base import checks
from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.model.spring import chain_deformations, spring_extension, spring_force
from beltrepro.model.units import FORCE_N, LENGTH_M, TIME_S
from beltrepro.replication.camera.scene import Scene
from beltrepro.replication.camera.video import Frame, write_video
from beltrepro.simulation import picture
from beltrepro.simulation.run import Run
from beltrepro.simulation.trajectories import simulate

KEYS = "space: pause   →: one step   ↑ ↓: faster, slower   q: close"
SPEEDS = 0.05, 50.0
FRAME_S = 1 / 24  # between frames, in the window and in a film
# Okabe and Ito's palette: distinct for colour-blind readers, by the direction of the slip.
STATES = {0: ("stuck to the belt", "#56b4e9"), -1: ("slips back over the belt", "#e69f00"),
          1: ("slips forward", "#cc79a7")}  # fmt: skip
_SIZE = 12.8, 7.2  # inches
_STYLE: list[Any] = ["default", "dark_background"]
_HALF, _ACROSS = Scene().block_length / 2, Scene().block_width / 2  # of a block, m
_CORNERS = np.array([[-_HALF, -_ACROSS], [-_HALF, _ACROSS], [_HALF, _ACROSS], [_HALF, -_ACROSS]])
_LINES = 0.1  # m between lines across the belt
_LONGEST_S = 3600.0  # of a film; each second takes a second or two to draw
_CURVE = 30  # seconds of the chain in the curve of x_N
_SAMPLE_INTERVAL = 0.1  # of x_N in the curve and for r, at most; model time


class Watched:
    """A chain at the instant that is shown, and the way of its last block up to it."""

    def __init__(self, parameters: ChainParameters, transient: float, seed: int) -> None:
        self.state = ChainState.at_rest(parameters, seed=seed)
        if checks.not_negative("transient", transient) > 0:
            self._run(transient)
        self.belt = 0.0  # how far the belt has moved, model length
        self.seen = np.array([[self.state.time], [self.state.positions[-1]]])  # (2, S) t and x_N
        self._begin_anew()

    def _begin_anew(self) -> None:
        """r is of x_N from here on, by the integrals of its powers about where it is now."""
        self._origin, self._powers = self.seen[1, -1], np.zeros(3)

    @property
    def disorder_parameter(self) -> float:
        """Of x_N since the belt velocity or the noise changed."""
        mean, square = self._powers[1:] / max(self._powers[0], np.finfo(float).tiny)
        return float(np.sqrt(max(square - mean**2, 0.0)) / (self._origin + mean))

    def advance(self, duration: float, **changed: Any) -> None:
        """Go on by a model time, if wanted with another belt velocity or noise."""
        parameters = replace(self.state.parameters, **changed)
        if parameters != self.state.parameters:
            self.state = self.state.under(parameters)
            self._begin_anew()
        if duration > 0:
            run = self._run(duration, _SAMPLE_INTERVAL if duration > _SAMPLE_INTERVAL else None)
            self.belt += duration * parameters.belt_velocity
            now = [[self.state.time], [self.state.positions[-1]]]
            passed = np.array([run.time, run.positions[:, -1]])
            away = (passed if passed.size else np.array(now))[1] - self._origin
            self._powers += duration * np.array([1.0, away.mean(), (away**2).mean()])
            seen = np.hstack([self.seen, passed, now])
            self.seen = seen[:, seen[0] >= self.state.time - _CURVE / TIME_S]

    def _run(self, duration: float, sample_interval: float | None = None) -> Run:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # r of so short a run is asked by nobody
            how: Any = {"initial_state": self.state, "sample_interval": sample_interval}
            run = simulate(self.state.parameters, duration=duration, **how)
        assert isinstance(run, Run)  # as it was one chain
        self.state = run.final_state
        return run


class View:
    """Draws a chain: the length to scale, the width of belt and blocks not."""

    @matplotlib.style.context(_STYLE)
    def __init__(self, chain: Watched, figure: Figure) -> None:
        self.chain, self.figure, parameters = chain, figure, chain.state.parameters
        figure.set_facecolor("black")
        pulls = np.cumsum(parameters.by_block("static_friction")[::-1])[::-1]
        longest = (parameters.by_block("rest_length") + spring_extension(pulls, parameters)).sum()
        self._end = 1.05 * LENGTH_M * longest  # all there is when springs balance static friction
        belt = figure.add_axes((0.06, 0.5, 0.91, 0.33), facecolor="#24282d")
        belt.set(xlim=(0, self._end), ylim=(-2 * _ACROSS, 2 * _ACROSS), yticks=[], xlabel="m")
        states = [Patch(fc="black", ec=colour, label=words) for words, colour in STATES.values()]
        belt.legend(handles=states, ncols=3, loc="lower right", bbox_to_anchor=(1, 1))
        self._lines = LineCollection([], colors="#33383e", linewidths=1.5)
        # full colour at the kinetic friction of all blocks
        ratio = np.maximum(parameters.friction_ratio, 0.1)
        strong = FORCE_N * (parameters.by_block("static_friction") * ratio).sum()
        norm = Normalize(-strong, strong)
        self._springs = LineCollection([], cmap="coolwarm", norm=norm, linewidths=3)
        scale = figure.add_axes((0.06, 0.92, 0.2, 0.014))
        figure.colorbar(self._springs, cax=scale, orientation="horizontal")
        scale.set_title("pull of a spring (N): below 0 compressed", fontsize=9, loc="left")
        # only the last block is white, as in the experiment
        faces = ["black"] * (parameters.n_blocks - 1) + ["white"]
        self.blocks = PolyCollection([], facecolors=faces, linewidths=2)
        length = figure.add_axes((0.06, 0.08, 0.91, 0.34))
        rest = LENGTH_M * parameters.rest_positions[-1]
        length.set(xlim=(-_CURVE, 0), ylim=(0.6 * rest, self._end), ylabel="$x_N$ (m)")
        length.set_xlabel("seconds of the chain before now")
        (self.curve,) = length.plot([], [], color="white", lw=1.2)
        self.numbers = length.text(0.01, 0.92, "", transform=length.transAxes)
        self.moving = [self._lines, self._springs, self.blocks, self.curve, self.numbers]
        for order, artist in enumerate((self._lines, self._springs, self.blocks), start=2):
            artist.set_zorder(order)
            belt.add_collection(artist, autolim=False)

    def draw(self, words: str) -> None:
        """Put all that moves where it is now."""
        state, parameters = self.chain.state, self.chain.state.parameters
        places, width = LENGTH_M * state.positions, 2 * _ACROSS
        lines = np.arange(LENGTH_M * self.chain.belt % _LINES, self._end, _LINES)
        self._lines.set_segments([[(line, -width), (line, width)] for line in lines])
        begins = np.append(0.0, places[:-1] + _HALF)
        ends = zip(begins, places - _HALF, strict=True)
        self._springs.set_segments([[(begin, 0.0), (end, 0.0)] for begin, end in ends])
        pulls = -spring_force(chain_deformations(state.positions, parameters), parameters)
        self._springs.set_array(FORCE_N * pulls)
        self.blocks.set_verts(_CORNERS + np.array([places, 0 * places]).T[:, None])
        self.blocks.set_edgecolor([STATES[int(way)][1] for way in np.sign(state.directions)])
        times, lengths = self.chain.seen
        self.curve.set_data(TIME_S * (times - state.time), LENGTH_M * lengths)
        about = f"{parameters.describe()}    r = {self.chain.disorder_parameter:.3f}"
        self.numbers.set_text(f"t = {TIME_S * state.time:.1f} s    {about}    {words}")


def write_film(
    path: Path,
    chain: Watched,
    speed: float,
    duration: float,
    progress: Callable[[float], None] | None = None,
) -> int:
    """Write a film of a chain from now on, and return the number of its frames."""
    count = round(checks.within("duration", duration, ge=FRAME_S, le=_LONGEST_S) / FRAME_S)
    canvas = FigureCanvasAgg(Figure(figsize=_SIZE, dpi=100))
    view = View(chain, canvas.figure)

    def frames() -> Iterator[Frame]:
        for number in range(count):
            chain.advance(speed * FRAME_S / TIME_S if number else 0.0)
            view.draw(f"speed × {speed:g}")
            canvas.draw()
            pixels = np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
            yield Frame(number * FRAME_S, pixels)
            if progress:
                progress((number + 1) / count)

    return write_video(path, frames(), frames_per_second=1 / FRAME_S, preset="medium")


class Window(View):
    """A view that goes on by itself, with keys and sliders."""

    @matplotlib.style.context(_STYLE)
    def __init__(self, chain: Watched, figure: Figure, speed: float) -> None:
        super().__init__(chain, figure)
        self.speed, self._last = speed, time.monotonic()
        self.paused, self._complaint = False, ""  # why the chain cannot go on
        velocity, noise = chain.state.parameters.belt_velocity, chain.state.parameters.noise
        # up to the ends of the scans of the paper
        ends = min(0.1, velocity), max(50.0, velocity)
        axes = [figure.add_axes((left, 0.92, 0.18, 0.03)) for left in (0.42, 0.74)]
        self.velocity = Slider(axes[0], "belt velocity u", *ends, valinit=velocity)
        self.noise = Slider(axes[1], "noise σ", 0.0, max(10.0, noise), valinit=noise)
        figure.canvas.mpl_connect("key_press_event", self._key)

    def start(self) -> None:
        """Go on with time."""
        how: Any = {"interval": round(1000 * FRAME_S), "cache_frame_data": False}
        self._animation = FuncAnimation(self.figure, self.on_timer, blit=True, **how)

    def on_timer(self, _: int) -> list:
        """Go on by the time since the last call; returns what is to be drawn again."""
        now = time.monotonic()
        seconds, self._last = min(now - self._last, 0.25), now  # not by a time the machine slept
        self.show(0.0 if self.paused else seconds)
        return self.moving

    def show(self, seconds: float) -> None:
        """Go on by a time of the real world, under what the sliders say."""
        changed = {"belt_velocity": self.velocity.val, "noise": self.noise.val}
        try:
            self.chain.advance(seconds * self.speed / TIME_S, **changed)
        except ModelStateError as error:
            self.paused, self._complaint = True, str(error)
        self.draw(self._complaint or ("paused" if self.paused else f"speed × {self.speed:g}"))

    def _key(self, event: Any) -> None:
        if event.key in (" ", "right"):
            self.paused, self._complaint = event.key == "right" or not self.paused, ""
        elif event.key in ("up", "down"):
            faster = self.speed * (2.0 if event.key == "up" else 0.5)
            self.speed = float(np.clip(faster, *SPEEDS))
        self.show(FRAME_S if event.key == "right" else 0.0)


def open_window(chain: Watched, speed: float) -> None:
    """Show a chain in a window until it is closed."""
    import matplotlib.pyplot as plt

    if picture.display() != "window":
        raise InputError("no display to open a window on: write a film with --output chain.mp4")
    # the keys of the window are its own
    keys: Any = {name: [] for name in matplotlib.rcParams if name.startswith("keymap.")}
    keys |= {"keymap.quit": ["q"], "toolbar": "None"}
    with matplotlib.rc_context(keys):
        figure = plt.figure(f"beltrepro watch    {KEYS}", figsize=_SIZE)
        window = Window(chain, figure, speed)  # lives as long as it is shown
        window.start()
        plt.show()

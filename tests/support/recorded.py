"""Made-up recordings of the virtual experiment: runs, their tracks and films, without a simulation.

x_5 is irregular and swings widely, but for one stretch in which it is small and periodic and no
block sticks.
"""

from functools import partial

import numpy as np

from beltrepro.base.store import Dataset
from beltrepro.model.units import LENGTH_M, TIME_S, VELOCITY_M_S
from beltrepro.replication.camera.camera import Framing, Movement, pictures
from beltrepro.replication.camera.scene import Camera, Scene
from beltrepro.replication.camera.track import Track

RATE = 24.0
EVENTS = [("time", "f8"), ("block", "i8"), ("kind", "U5")]
FUNDAMENTAL = 0.6  # Hz
PIXEL = 0.0021
CAMERA = Camera(metres_per_pixel=PIXEL, width=640, height=80, angle=0.7)
ZERO = Framing.of(Movement(*np.zeros((3, 1, 1))), Scene(), CAMERA).zero


def swaying(seconds, *, n_blocks=5, farthest=0.6):
    """Blocks that stick for a while at 0.2 m/s and slip back within 0.4 s, in SI."""
    time = np.arange(round(seconds * RATE)) / RATE
    period, back = 1.3, 0.4
    part = time % period
    way = 0.2 * (period - back)
    stuck = part < period - back
    turn = np.pi * (part - (period - back)) / back
    shape = np.where(stuck, 0.2 * part, way * (1 + np.cos(turn)) / 2)
    speed = np.where(stuck, 0.2, -way * np.pi / back * np.sin(turn) / 2)
    share = np.arange(1, n_blocks + 1) / n_blocks
    rest = (farthest - way) * share
    return Movement(time, rest + shape[:, np.newaxis] * share, speed[:, np.newaxis] * share)


def place(seconds, calm, seed):
    """x_5 (T,) in metres: a smooth random motion, and a periodic one within `calm`."""
    time = np.arange(round(seconds * RATE)) / RATE
    random = np.random.default_rng(seed)
    noise = random.normal(size=time.size)
    x = np.zeros(time.size)
    for index in range(1, time.size):
        x[index] = 0.93 * x[index - 1] + 0.37 * noise[index]
    x = 0.7 + 0.1 * np.clip(x, -3, 3)
    if calm:
        inside = (time >= calm[0]) & (time < calm[1])
        turn = 2 * np.pi * FUNDAMENTAL * time[inside]
        waves = sum(np.cos(k * turn + k**2) / k**2 for k in range(1, 7))
        x[inside] = 0.7 + 0.01 * waves + random.normal(0, 2e-6, inside.sum())
    return time, x


def run(speed, noise, *, seconds=1000.0, calm=None, seed=1, transient=2616.0):
    """A series of one point as `io.load` gives it; blocks stick twice a second but for calm."""
    time, x = place(seconds, calm, seed)
    share = np.arange(1, 6) / 5
    velocity = speed / VELOCITY_M_S
    positions = x[:, np.newaxis] * share / LENGTH_M
    velocities = np.gradient(positions, 1 / RATE / TIME_S, axis=0)
    arrays = {
        "time": transient + time / TIME_S,
        "positions": positions,
        "velocities": velocities,
        "events": _events(seconds, calm, transient),
        "disorder_parameter": np.float64(x.std() / x.mean()),
    }
    attributes = {
        "kind": "series",
        "method": "event",
        "preset": "smoke",
        "n_blocks": 5,
        "belt_velocity": velocity,
        "noise": noise,
        "sample_interval": 1 / RATE / TIME_S,
        "time_step": 0.001,
        "transient": transient,
        "duration": transient + seconds / TIME_S,
        "seed": 1,
        "code_version": "0.0+gabc",
    }
    return Dataset(arrays, attributes)


def _events(seconds, calm, transient):
    """Every half second all blocks stick for a tenth of a second, one after the other."""
    rows = []
    for instant in np.arange(0.25, seconds, 0.5):
        if calm and calm[0] <= instant < calm[1]:
            continue
        for block in range(1, 6):
            stick = transient + (instant + 0.02 * block) / TIME_S
            rows += [(stick, block, "stick"), (stick + 0.1 / TIME_S, block, "slip")]
    return np.sort(np.array(rows, EVENTS), order="time")


def track(of):
    """What a tracker would make of a run."""
    x = of.arrays["positions"][:, -1] * LENGTH_M
    noise = np.random.default_rng(20).normal(0, 1e-4, x.size)
    time = np.arange(x.size) / RATE
    return Track(time, x + noise, np.empty((0, 2)), PIXEL, zero=ZERO, angle=CAMERA.angle)


def film(of, *, frames=260):
    """A film as `io.load` gives it: a function that yields the first frames."""
    arrays = of.arrays
    seen = Movement(
        np.arange(frames) / RATE,
        arrays["positions"][:frames] * LENGTH_M,
        arrays["velocities"][:frames] * VELOCITY_M_S,
    )
    return partial(pictures, seen, camera=CAMERA)


def recordings(*, seconds=1000.0, calm=(400.0, 520.0)):
    """Runs, tracks and films by the names that figures, tables and claims ask for."""
    runs = {
        "belt_022": run(0.22, 1.0, seconds=seconds, calm=calm, seed=1),
        "belt_028": run(0.28, 1.0, seconds=seconds, calm=calm, seed=2),
        "belt_035": run(0.35, 2.2, seconds=seconds, calm=calm, seed=3),
    }
    made = runs | {f"{name}_track": track(one) for name, one in runs.items()}
    return made | {"belt_028_film": film(runs["belt_028"])}

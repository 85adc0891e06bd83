"""A movement for films of tests, made without a simulation."""

import numpy as np

from beltrepro.replication.camera.camera import Movement

FRAMES_PER_SECOND = 24.0


def swaying(seconds=3.0, *, n_blocks=5, farthest=0.6, frames_per_second=FRAMES_PER_SECOND):
    """Blocks that stick for a while at 0.2 m/s and slip back within 0.4 s, in SI."""
    time = np.arange(round(seconds * frames_per_second)) / frames_per_second
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

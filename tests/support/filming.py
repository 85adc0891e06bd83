"""Films for tests: a movement without a simulation, and a renderer that is not the package's."""

import cv2
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


class OtherRenderer:
    """Draws with OpenCV polygons, in colour and at its own scale, turned by an angle.

    The picture also has a bright frame of a treadmill, a round glare and a lamp's reflection.
    """

    SCALE = 0.00123  # metres per pixel
    SIZE = (700, 260)
    FINE = 3  # pixels drawn for each pixel of the picture

    def __init__(self, angle=2.0, *, tape=True, whites=1):
        self.angle, self._tape, self._whites = angle, tape, whites

    def pixels(self, x, y):
        """Place of a point given in metres from the support and from the middle of the chain."""
        turn = np.radians(self.angle)
        column, row = 25 + x / self.SCALE, 95 + y / self.SCALE
        column, row = column - self.SIZE[0] / 2, row - self.SIZE[1] / 2
        return (
            self.SIZE[0] / 2 + np.cos(turn) * column - np.sin(turn) * row,
            self.SIZE[1] / 2 + np.sin(turn) * column + np.cos(turn) * row,
        )

    def picture(self, blocks):
        """One frame (H, W, 3), with the middles of the blocks in metres."""
        width, height = (self.FINE * side for side in self.SIZE)
        self._canvas = np.full((height, width, 3), (70, 52, 38), np.uint8)
        self._bar(-1, 3, 0.10, 0.14, (150, 150, 150))
        if self._tape:
            self._bar(0, 3, 0.055, 0.08, (60, 215, 235))
            for mark in range(100):
                length = 0.02 if mark % 10 == 0 else 0.012
                self._bar(0.01 * mark - 0.0006, 0.01 * mark + 0.0006, 0.055, 0.055 + length, 0)
        self._bar(0, blocks[-1], -0.004, 0.004, (110, 110, 120))
        for number, middle in enumerate(blocks, 1):
            white = number > len(blocks) - self._whites
            colour = (225, 240, 245) if white else (20, 15, 35)
            self._bar(middle - 0.02, middle + 0.02, -0.04, 0.04, colour)
        for centre, radius in (((0.3, 0.02), 0.012), ((0.72, -0.06), 0.01)):
            place = [round(self.FINE * pixel) for pixel in self.pixels(*centre)]
            cv2.circle(self._canvas, place, round(self.FINE * radius / self.SCALE), (255,) * 3, -1)
        return cv2.resize(self._canvas, self.SIZE, interpolation=cv2.INTER_AREA)

    def _bar(self, left, right, top, bottom, colour):
        corners = [(left, top), (right, top), (right, bottom), (left, bottom)]
        points = np.array([self.pixels(*corner) for corner in corners]) * self.FINE
        colour = colour if colour else (10, 10, 10)
        cv2.fillPoly(self._canvas, [np.rint(16 * points).astype(np.int32)], colour, shift=4)

    def film(self, positions, path, *, frames_per_second=30.0):
        """Write a film with OpenCV's own encoder."""
        code = cv2.VideoWriter.fourcc(*"mp4v")
        writer = cv2.VideoWriter(str(path), code, frames_per_second, self.SIZE)
        for blocks in positions:
            writer.write(self.picture(blocks))
        writer.release()

"""Films of a treadmill from optics alone: a pinhole anywhere above the belt, its lens and light.

Nothing here shares a formula with the package's camera or tracker; sizes and colours are those of
its `Scene`. In metres: x along the belt from the support, y across it from the middle of the chain
towards the tape, z up. Belt and tape lie at z = 0, and so do the tops of the blocks unless
`block_height` lifts them: then they look farther from the foot of the camera, by the share
z / (height of the camera - z).

Each pixel averages what it covers. Edges of blocks are exact along the belt, also while they move;
belt and tape are a picture of their own, sampled where the pixels look. Brightness is mixed as
light, and becomes what a screen is told (`gamma`) at the end.
"""

import functools
from dataclasses import dataclass, replace

import cv2
import numpy as np

from beltrepro import ChainParameters, simulate
from beltrepro.model.units import TIME_S
from beltrepro.replication.camera.camera import Movement
from beltrepro.replication.camera.scene import Scene
from beltrepro.replication.camera.video import Frame, write_video

FRAMES_PER_SECOND = 24.0
_TEXEL = 0.0005  # metres, of the picture of belt and tape
_FROM, _TO = (-0.4, -0.25), (1.8, 0.25)  # its corners, x and y
_NUMBER_EVERY = 10  # marks
_PLAIN = Scene()


@dataclass(frozen=True)
class Shot:
    """How a film is taken; angles in degrees, lengths on the belt in metres, others in pixels."""

    width: int = 640
    height: int = 120
    metres_per_pixel: float = 0.00195  # in the middle of the picture
    focal: float = 0.8  # in widths: a phone sees some 64 degrees
    aim: tuple[float, float] = (0.57, 0.015)  # x and y in the middle of the picture
    along: float = 0.0  # tilt along the belt, across it, and about the line of sight
    across: float = 0.0
    roll: float = 0.0
    barrel: float = 0.0  # share by which the end of the middle row moves inwards
    aspect: float = 1.0  # height of a pixel over its width
    block_height: float = 0.0
    blur: float = 0.6
    exposure: float = 0.008  # seconds
    gamma: float = 2.2
    noise: float = 2.0  # of 255 levels
    unevenness: float = 0.1  # share of the light, from the middle to one end
    vignetting: float = 0.0  # share of the light that the corners lack
    shake: float = 0.0  # at each frame anew: standard deviation; also turns
    bump: float = 0.0  # in mid-film, for good
    zoom: float = 0.0  # share, from the first frame to the last
    hands: bool = False
    scene: Scene = _PLAIN
    things: tuple = ()  # what else lies there, from (x, y) to (x, y), with its level of 255
    jpeg: int | None = None  # quality
    mirrored: bool = False
    portrait: bool = False
    dropped: float = 0.0  # share of the frames
    compression: int = 18
    seed: int = 1


DISTURBANCES = {
    "clean": Shot(),
    "mirrored": Shot(mirrored=True),
    "vignetted": Shot(vignetting=0.6),
    "jpeg": Shot(jpeg=15),
    "hands": Shot(hands=True),
    "along 1": Shot(along=1.0),
    "along 2": Shot(along=2.0),
    "along -2": Shot(along=-2.0),
    "across 3": Shot(across=3.0),
    "shaken": Shot(shake=2.0),
    "bumped": Shot(bump=15.0),
    "portrait": Shot(portrait=True),
    "zooming": Shot(zoom=0.02),
    "barrel 1": Shot(barrel=0.01),
    "barrel 2": Shot(barrel=0.02),
    "dropped": Shot(dropped=0.1),
}

# What lies over the middle of the tape, over its beginning, over that to a long mark, and a white
# block that nobody moves.
_CLOTH = ((0.3, 0.05), (0.8, 0.1), 60.0)
_LEAF = ((-0.1, 0.05), (0.14, 0.1), 28.0)
_TEN = ((-0.1, 0.05), (0.095, 0.1), 28.0)
_SPARE = ((0.1, -0.04), (0.14, 0.04), 235.0)
_PALE = Scene(white_block=190)  # as bright as the tape
_DIM = Scene(white_block=150, tape=120)
# A bright edge of the treadmill, and two reflections of lamps.
_LIGHTS = (
    ((-0.2, -0.125), (1.6, -0.105), 150.0),
    ((0.3, 0.0), (0.32, 0.02), 255.0),
    ((0.72, -0.07), (0.74, -0.05), 255.0),
)
NO_TAPE = Shot(things=(((-0.1, 0.05), (1.8, 0.1), 28.0),))
_SMALL = Shot(width=320, height=60, metres_per_pixel=0.0039)
COMBINED = {
    "roll -6 lights": Shot(roll=-6.0, height=200, things=_LIGHTS),
    "along 4": Shot(along=4.0),
    "along -4": Shot(along=-4.0),
    "along 2 across 3 roll 2": Shot(along=2.0, across=3.0, roll=2.0),
    "along 1 shaken": Shot(along=1.0, shake=1.0),
    "along 1 hands": Shot(along=1.0, hands=True),
    "along 1 mirrored jpeg": Shot(along=1.0, mirrored=True, jpeg=15),
    "along 1 dim": Shot(along=1.0, noise=8.0, unevenness=0.4, scene=_DIM),
    "along 1 near": Shot(along=1.0, focal=0.55),
    "barrel along -1 vignetted": Shot(barrel=0.01, along=-1.0, vignetting=0.5),
    "bumped hands": Shot(bump=15.0, hands=True),
    "cloth": Shot(things=(_CLOTH,)),
    "cloth along 1": Shot(things=(_CLOTH,), along=1.0),
    "zero hidden": Shot(things=(_LEAF,)),
    "zero hidden to a ten": Shot(things=(_TEN,)),
    "tape 2 cm deeper": Shot(block_height=0.02),
    "pale block": Shot(scene=_PALE),
    "pale block along 1": Shot(scene=_PALE, along=1.0),
    "two white blocks": Shot(things=(_SPARE,)),
    "cut": Shot(aim=(0.69, 0.015)),
    "small": _SMALL,
    "small along 1": replace(_SMALL, along=1.0),
    "tall pixels": Shot(aspect=1.1),
}


@functools.cache
def chain_motion(frames=240, belt_velocity=15.3):
    """Five blocks with noise, as the exact integrator moves them, at the instants of the frames."""
    interval, start = 1 / FRAMES_PER_SECOND / TIME_S, 200.0
    run = simulate(
        ChainParameters(5, belt_velocity, 1.0), method="event", transient=start,
        duration=start + (frames - 0.5) * interval, sample_interval=interval, sample_start=start,
    )  # fmt: skip
    return Movement.of(run)


def film(movement, path, shot):
    """Write the film and return the instants of its frames and where the last block was, (T,)."""
    frames = list(pictures(movement, shot))
    kept = [index for index, _ in frames]
    time = movement.time_s[kept] - movement.time_s[0]
    film = [Frame(t, picture) for t, (_, picture) in zip(time, frames, strict=True)]
    write_video(path, film, frames_per_second=FRAMES_PER_SECOND, compression=shot.compression)
    return time, movement.x_m[kept, -1]


def pictures(movement, shot):
    """Numbers of the samples that become frames, and their pictures (H, W), 8 bit."""
    random = np.random.default_rng(shot.seed)
    ground, light = _ground(shot), _light(shot)
    noise = random.normal(0, shot.noise, (8, shot.height, shot.width)).astype(np.float32)
    way = movement.v_m_s * shot.exposure
    count, pose, view = len(movement.time_s), None, None
    for index in range(count):
        held = Pose.of(shot, index / max(count - 1, 1), random)
        if held != pose:
            pose, view = held, View(held, shot, ground)
        if index and random.random() < shot.dropped:
            continue
        picture = view.light_from(movement.x_m[index], way[index]) * light
        if shot.blur:
            picture = cv2.GaussianBlur(picture, (0, 0), shot.blur)
        if shot.hands:
            picture = _with_hands(picture, index / count, shot)
        picture = 255 * np.clip(picture, 0, 1) ** np.float32(1 / shot.gamma) + noise[index % 8]
        yield index, _developed(np.clip(np.rint(picture), 0, 255).astype(np.uint8), shot)


@dataclass(frozen=True)
class Pose:
    """A pinhole and how it is held: metres, radians, and pixels of its focal length."""

    x: float
    y: float
    height: float
    along: float
    across: float
    roll: float
    focal: float

    @classmethod
    def of(cls, shot, share, random):
        """The pose after a share of the film. Who shakes or bumps a camera turns it."""
        focal = shot.focal * shot.width
        along, across, roll = np.radians([shot.along, shot.across, shot.roll])
        distance = focal * shot.metres_per_pixel
        x, y, down = distance * _turned(along, across, roll)[:, 2]
        if shot.bump and share > 0.5:
            along, across = along + shot.bump / focal, across + 0.2 * shot.bump / focal
        if shot.shake:
            turns = random.normal(0, shot.shake / focal, 3)
            along, across, roll = along + turns[0], across + turns[1], roll + turns[2]
        place = shot.aim[0] - x, shot.aim[1] - y, down
        return cls(*map(float, (*place, along, across, roll, focal * (1 + shot.zoom * share))))

    def slopes(self, shot):
        """Metres along and across the belt for each metre down, seen by each pixel: 2 (H, W)."""
        u = (np.arange(shot.width) + 0.5 - shot.width / 2)[np.newaxis, :]
        v = (np.arange(shot.height) + 0.5 - shot.height / 2)[:, np.newaxis] * shot.aspect
        stretch = 1 + shot.barrel * (u**2 + v**2) / (shot.width / 2) ** 2
        u, v = u * stretch / self.focal, v * stretch / self.focal
        turn = _turned(self.along, self.across, self.roll)
        x, y, down = (row[0] * u + row[1] * v + row[2] for row in turn)
        return (x / down).astype(np.float32), (y / down).astype(np.float32)


def _turned(along, across, roll):
    """Axes of the camera as columns: to its right, to its lower edge, and its line of sight."""
    (s, c), (sa, ca), (sr, cr) = ((np.sin(a), np.cos(a)) for a in (along, across, roll))
    about_y = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    about_x = np.array([[1, 0, 0], [0, ca, sa], [0, -sa, ca]])
    about_sight = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    return about_y @ about_x @ about_sight


class View:
    """What a camera at one pose sees."""

    def __init__(self, pose, shot, ground):
        self._pose, self._shot, self._scene = pose, shot, shot.scene
        self._slopes = pose.slopes(shot)
        # ways of a pixel's longer and shorter side along and across the belt, for each metre down
        sides = [[np.abs(side) for side in np.gradient(slope)] for slope in self._slopes]
        self._sides = [(np.maximum(*pair), np.minimum(*pair)) for pair in sides]
        x, y = (self._seen(axis, 0.0) for axis in (0, 1))
        self._ground = cv2.remap(
            ground, (x - _FROM[0]) / _TEXEL - 0.5, (y - _FROM[1]) / _TEXEL - 0.5, cv2.INTER_LINEAR
        )
        self._floors = np.linspace(0, shot.block_height, 5 if shot.block_height else 1)
        self._lanes = {z: self._band(1, z, shot.scene.block_width / 2) for z in self._floors}
        self._thread = self._band(1, shot.block_height / 2, shot.scene.spring_width / 2)
        rows = np.flatnonzero(np.max([*self._lanes.values()], axis=(0, 2)))
        self._rows = slice(rows[0], rows[-1] + 1)  # of the picture, which show the chain
        # what the columns see there, at the most: along the belt, for each metre down
        self._columns = [
            extreme(self._slopes[0][self._rows], axis=0) for extreme in (np.min, np.max)
        ]

    def light_from(self, blocks, ways):
        """Light (H, W) that comes in while blocks at these middles go these ways."""
        scene, picture = self._scene, self._ground.copy()
        half, z = scene.block_length / 2, self._shot.block_height / 2
        for left, right in zip([0.0, *blocks[:-1] + half], blocks - half, strict=True):
            if left < right:
                part = self._part(left, right)
                share = self._coils(left, right, z, part) * self._thread[part]
                _paint(picture[part], share, self._lit("spring"))
        for number, (middle, way) in enumerate(zip(blocks, np.abs(ways), strict=True), 1):
            part = self._part(middle - half - way, middle + half + way)
            for floor in self._floors:  # the top, and below it the sides
                top = number == len(blocks) and floor == self._floors[-1]
                share = self._band(0, floor, half, middle, way, part) * self._lanes[floor][part]
                _paint(picture[part], share, self._lit("white_block" if top else "block"))
        return picture

    def _lit(self, name):
        return _linear(getattr(self._scene, name), self._shot)

    def _part(self, left, right):
        """Rows and columns of the picture that show what lies there, give or take some pixels."""
        heights = self._pose.height - self._floors[[0, -1]]
        low, high = (np.outer(heights, slope) + self._pose.x for slope in self._columns)
        columns = np.flatnonzero((high.max(axis=0) > left) & (low.min(axis=0) < right))
        if not columns.size:
            return self._rows, slice(0)
        return self._rows, slice(max(columns[0] - 3, 0), columns[-1] + 4)

    def _seen(self, axis, z, part=np.s_[:]):
        """x or y of what the pixels see at a height, (H, W)."""
        place = (self._pose.x, self._pose.y)[axis]
        return np.float32(place) + np.float32(self._pose.height - z) * self._slopes[axis][part]

    def _band(self, axis, z, half, middle=0.0, way=0.0, part=np.s_[:]):
        """Share of each pixel within a band, over an exposure in which the band goes a way."""
        long, short = (np.float32(self._pose.height - z) * side[part] for side in self._sides[axis])
        way = np.float32(way)
        long, short = np.maximum(long, way), np.maximum(np.minimum(long, way), short)
        seen = self._seen(axis, z, part) - np.float32(middle)
        return _step(seen + np.float32(half), long, short) - _step(
            seen - np.float32(half), long, short
        )

    def _coils(self, left, right, z, part):
        """Share of each pixel that the turns of a stretched spring cover, were it wide enough."""
        pitch = (right - left) / self._scene.coils
        turns = (self._seen(0, z, part) - np.float32(left)) / np.float32(pitch)
        half = self._sides[0][0][part] * np.float32((self._pose.height - z) / (2 * pitch))
        ends = (np.clip(turns + sign * half, 0, self._scene.coils) for sign in (1, -1))
        after, before = (np.floor(end) / 2 + np.minimum(end % 1, 0.5) for end in ends)
        return (after - before) / (2 * half)


def _paint(picture, share, light):
    picture += share * (np.float32(light) - picture)


def _step(x, long, short):
    """The step at 0, averaged over two intervals about x, one after the other."""
    short = np.maximum(short, np.float32(0.01) * long)
    x = np.clip(x, -long, long)  # beyond, the ramps differ by all or nothing

    def ramp(y):  # integral of the step averaged over the long interval
        return np.maximum(y - long / 2, 0) + np.clip(y + long / 2, 0, long) ** 2 / (2 * long)

    return (ramp(x + short / 2) - ramp(x - short / 2)) / short


def _linear(level, shot):
    """The light that becomes a level of 255."""
    return (np.asarray(level, np.float32) / 255) ** shot.gamma


def _ground(shot):
    """Light of belt, support and tape from straight above, blurred by the size of a pixel."""
    scene = shot.scene
    shape = [round((end - begin) / _TEXEL) for begin, end in zip(_FROM, _TO, strict=True)]
    level, ink = np.full(shape[::-1], scene.belt, np.float32), np.zeros(shape[::-1], np.uint8)
    edge = scene.block_width / 2 + scene.tape_gap
    _bar(level, (-0.03, 0.0), (-0.05, 0.05), scene.support)
    _bar(level, (-0.005, 9.0), (edge, edge + scene.tape_width), scene.tape)
    for mark in range(int(_TO[0] / scene.mark_spacing)):
        x, length = mark * scene.mark_spacing, scene.mark_length
        if mark % _NUMBER_EVERY == 0:
            length = scene.long_mark_length
            places = zip((x + 0.002, edge + 0.018), _FROM, strict=True)
            corner = [round((place - begin) / _TEXEL) for place, begin in places]
            cv2.putText(ink, str(mark), corner, cv2.FONT_HERSHEY_SIMPLEX, 0.6, 255, 2, cv2.LINE_AA)
        half = scene.mark_width / 2
        _bar(level, (x - half, x + half), (edge, edge + length), scene.mark)
    _paint(level, ink / np.float32(255), scene.mark)
    for begin, end, brightness in shot.things:
        _bar(level, *zip(begin, end, strict=True), brightness)
    sigma = shot.metres_per_pixel / _TEXEL / np.sqrt(12)
    return cv2.GaussianBlur(_linear(level, shot), (0, 0), sigma)


def _bar(level, x, y, brightness):
    """A rectangle, by the share of each texel that it covers."""
    covered = []
    for (begin, end), first, count in zip((x, y), _FROM, level.shape[::-1], strict=True):
        places = np.arange(count)
        ends = np.clip((np.array([begin, end])[:, np.newaxis] - first) / _TEXEL - places, 0, 1)
        covered.append(ends[1] - ends[0])
    rows, columns = (np.flatnonzero(c) for c in covered[::-1])
    part = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    _paint(level[part], np.outer(*covered[::-1]).astype(np.float32)[part], brightness)


def _light(shot):
    """Share of the light that reaches each pixel, (H, W)."""
    x = np.linspace(-1, 1, shot.width)[np.newaxis, :]
    y = np.linspace(-1, 1, shot.height)[:, np.newaxis] * shot.height / shot.width
    corner = 1 + (shot.height / shot.width) ** 2
    light = (1 + shot.unevenness * x) * (1 - shot.vignetting * (x**2 + y**2) / corner)
    return light.astype(np.float32)


def _with_hands(picture, share, shot):
    """A forearm that reaches in from above or below the chain, twice in a film."""
    for begin, column, below in ((0.2, 0.75, False), (0.6, 0.4, True)):
        reach = np.sin(np.pi * (share - begin) / 0.15) if begin < share < begin + 0.15 else 0
        if reach:
            tip = 0.8 * reach * shot.height
            rows = (shot.height, shot.height - tip) if below else (0, tip)
            ends = [(int(column * shot.width + 0.3 * row), int(row)) for row in rows]
            level = _linear(150, shot).item()
            cv2.line(picture, *ends, level, round(0.04 * shot.width), cv2.LINE_AA)
            cv2.circle(picture, ends[1], round(0.03 * shot.width), level, -1, cv2.LINE_AA)
    return picture


def _developed(picture, shot):
    """What the camera makes of a picture before it becomes a frame of the film."""
    if shot.jpeg is not None:
        coded = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, shot.jpeg])[1]
        picture = cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE)
    if shot.mirrored:
        picture = picture[:, ::-1]
    if shot.portrait:
        picture = np.rot90(picture)
    return np.ascontiguousarray(picture)

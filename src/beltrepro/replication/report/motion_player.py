"""The chain in motion: short runs, carried by the page, and a player for them."""

import base64

import numpy as np

from beltrepro.base.store import Dataset
from beltrepro.model.units import TIME_S
from beltrepro.replication.plan import files
from beltrepro.replication.report.material import Material

_WORDS = {  # title, and what to see
    "play_u1": ("Avalanches", "The blocks ride on the belt for long and slip back in avalanches."),
    "play_u17": (
        "Intermittency",
        "Swings, large and small, are now and then broken by long slips of the last block.",
    ),
    "play_u25": (
        "Continuous slip",
        "The motion is irregular at first, until the last block slips without a stop.",
    ),
    "play_n10": (
        "Ten blocks",
        "A longer chain: slips run along it, and only some reach the last one.",
    ),
}
NEEDS = tuple(_WORDS)

_SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
_FASTEST_FIRST = 25.0  # belt velocity; slower belts are first shown at a higher speed
_LEVELS = 2**16 - 1
_ROOM = 1.04  # of the greatest position


def gather(material: Material) -> dict:
    """What the player is given: a motion for each dataset."""
    return {
        "motions": [_motion(name, files.read_any(material.file(name))) for name in NEEDS],
        "speeds": _SPEEDS,
    }


def _motion(name: str, dataset: Dataset) -> dict:
    """A dataset of one run as plain values; positions in 16 bits, signs a letter each."""
    arrays, about = dataset.arrays, dataset.attributes
    positions, time = arrays["positions"][0], arrays["time"]
    velocity = float(about["belt_velocity"])
    directions = np.sign(arrays["velocities"][0] - velocity)  # of a stuck block exactly 0
    low, high = positions.min(), positions.max()
    levels = np.round(_LEVELS * (positions - low) / (high - low))
    last = positions[:, -1]
    noise = f"σ = {about['noise']:g}" if about["noise"] else "no noise"
    chain = f"N = {about['n_blocks']:g}, u = {velocity:g}, {noise}."
    title, words = _WORDS[name]
    # a telling still: the first sample in which most blocks slip and others are stuck
    slipping = np.count_nonzero(directions, axis=1)
    mixed = np.where(slipping < directions.shape[1], slipping, 0)
    return {
        "title": f"{title}, u = {velocity:g}",
        "words": f"{chain} {words} {_longest(directions[:, -1], time)}",
        "n_blocks": int(about["n_blocks"]),
        "u": velocity,
        "rest": float(about["rest_length"]),
        "begin": float(time[0]),
        "interval": float(about["sample_interval"]),
        "second": TIME_S,
        "speed": _speed(velocity),
        "samples": len(time),
        "still": int(np.argmax(mixed)),
        "visible": float(_ROOM * high),
        "range": [float(last.min()), float(last.max())],
        "low": float(low),
        "step": float((high - low) / _LEVELS),
        "positions": base64.b64encode(levels.astype("<u2").tobytes()).decode(),
        "signs": "".join(np.array(["<", "s", ">"])[directions.astype(int).ravel() + 1]),
    }


def _longest(directions: np.ndarray, time: np.ndarray) -> str:
    """How long the last block slips without a stop in this piece, at most."""
    slips = np.concatenate([[0], directions != 0, [0]])
    begins, ends = (np.flatnonzero(np.diff(slips) == sign) for sign in (1, -1))
    if not len(begins):
        return "Here the last block does not slip."
    longest = np.argmax(ends - begins)
    begin, end = time[begins[longest]], time[ends[longest] - 1]
    return f"The longest slip of the last block here lasts from t = {begin:.0f} to {end:.0f}."


def _speed(velocity: float) -> float:
    """The first of the speeds at which a belt this slow moves as fast as others in real time."""
    wanted = min(_FASTEST_FIRST / velocity, max(_SPEEDS))
    return max(speed for speed in _SPEEDS if speed <= max(wanted, 1.0))

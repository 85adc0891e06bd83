"""What tests draw and measure from made-up data is what it was: a few numbers and a word for each.

A fingerprint changes with any number, order, colour or letter of a thing, and not with rounding.
`tests/data/fingerprints.json` lists them by test, so it shows what a change of code alters, wanted
or not. It cannot tell right from wrong: the tests themselves do. To write it anew after a change
that is meant:

    rm tests/data/fingerprints.json
    FINGERPRINTS=write make test ARGS="-m 'not slow'"
"""

import contextlib
import fcntl
import functools
import hashlib
import json
import os
from itertools import zip_longest
from numbers import Number
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.collections import Collection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text

from beltrepro.stats.estimates import Estimate

LIST = Path(__file__).parent.parent / "data" / "fingerprints.json"
WRITING = os.environ.get("FINGERPRINTS") == "write"
STEP = 0.6180339887  # of weights that repeat nowhere
_seen: list = []
_written: dict = {}


def see(thing, within=1e-9):
    """Take the fingerprint of a thing; within : share by which rounding may change its numbers."""
    _seen.append([*of(thing), within])


@contextlib.contextmanager
def of_test(name):
    """Collect what a test sees; what it yields compares it with the list."""

    def check():
        if not _seen:
            return
        if WRITING:
            _written[name] = list(_seen)
            return
        listed = _listed().get(name)
        assert listed is not None, f"no fingerprints of {name}: write them, see {__file__}"
        differing = [
            number
            for number, (one, other) in enumerate(zip_longest(_seen, listed), start=1)
            if one is None or other is None or not same(one, other)
        ]
        assert not differing, f"other than it was: number {differing} of {len(listed)} things seen"

    _seen.clear()
    yield check
    _seen.clear()


def write():
    """Write the list anew, if that is asked for; entries of tests that did not run stay."""
    if not _written:
        return
    with LIST.open("a+", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # workers end at the same time
        file.seek(0)
        text = json.dumps(json.loads(file.read() or "{}") | _written, sort_keys=True)
        file.truncate(0)
        file.write(text.replace("]], ", "]],\n") + "\n")


@functools.cache
def _listed():
    return json.loads(LIST.read_text(encoding="utf-8"))


def of(thing):
    """[sum of all numbers with weights of their own, sum of their sizes, digest of all words]."""
    numbers, words = [], []
    for part in _parts(thing):
        (words if isinstance(part, str) else numbers).append(part)
    flat = np.concatenate([np.ravel(np.asarray(part, dtype=float)) for part in numbers] or [[]])
    kept = np.where(np.isfinite(flat), flat, 0.0)
    words += [f"{np.isnan(flat).sum()} {np.isinf(flat).sum()} of {flat.size}"]
    sizes = np.arcsinh(kept)  # tells changes of small numbers beside large ones
    weights = 1 + np.mod(STEP * np.arange(1, flat.size + 1), 1)
    digest = hashlib.sha256("\n".join(words).encode()).hexdigest()[:12]
    return [round(float(value), 12) for value in (sizes @ weights, abs(sizes) @ weights)] + [digest]


def same(one, other):
    """Whether two fingerprints agree but for rounding."""
    return one[2:] == other[2:] and abs(one[0] - other[0]) <= other[3] * (1 + other[1])


def _parts(thing):
    """Numbers and words of a thing, in its order."""
    if isinstance(thing, dict):
        for name, value in thing.items():
            yield str(name)
            yield from _parts(value)
    elif isinstance(thing, pd.DataFrame):
        yield from _parts({name: thing[name].to_numpy() for name in thing})
    elif isinstance(thing, Estimate):
        yield from _parts([thing.value, thing.low, thing.high, thing.runs or 0])
    elif isinstance(thing, np.ndarray) and thing.dtype.names:
        yield from _parts({name: thing[name] for name in thing.dtype.names})
    elif isinstance(thing, np.ndarray) and thing.dtype.kind in "biuf":
        yield thing
    elif isinstance(thing, (list, tuple, np.ndarray)):
        for value in thing:
            yield from _parts(value)
    elif isinstance(thing, Number) and not isinstance(thing, bool):
        yield thing
    elif isinstance(thing, Figure):
        yield from _parts([thing.get_size_inches(), *map(_legend, thing.legends)])
        yield from _parts([*map(_artist, thing.texts), *map(_panel, thing.axes)])
    else:
        yield str(thing)


def _panel(axes):
    """What a panel shows: its axes, and each artist that was put into it."""
    title = [axes.get_title(loc=place) for place in ("left", "center", "right")]
    frame = [axes.get_xlabel(), axes.get_ylabel(), *title, axes.get_xscale(), axes.get_yscale()]
    limits = [axes.get_xlim(), axes.get_ylim(), axes.get_position(original=True).bounds]
    ticks = [[_ticks(axis), axis.get_ticklocs()] for axis in (axes.xaxis, axes.yaxis)]
    frames = [axes.patch, *axes.spines.values()]
    artists = [artist for artist in axes.get_children() if isinstance(artist, SHOWN)]
    drawn = [_artist(artist) for artist in artists if artist not in frames]
    return [frame, limits, ticks, _legend(axes.get_legend()), drawn]


def _ticks(axis):
    formatter = axis.get_major_formatter()
    offset = str(formatter.get_useOffset()) if hasattr(formatter, "get_useOffset") else ""
    return [type(formatter).__name__, offset]


def _legend(legend):
    if legend is None:
        return []
    return [legend._ncols, legend._get_loc(), *map(_artist, legend.get_texts())]


SHOWN = (Line2D, Collection, Patch, Text, AxesImage)


def _artist(artist):
    """Words and numbers of one artist."""
    if isinstance(artist, Text):
        look = [artist.get_text(), to_hex(artist.get_color(), keep_alpha=True)]
        ends = getattr(artist, "xy", ())  # what an arrow points at
        place = [artist.get_fontsize(), artist.get_position(), ends]
        return [*look, *place] if look[0] or ends else []
    if isinstance(artist, Line2D):
        look = [to_hex(artist.get_color()), artist.get_marker(), artist.get_linestyle()]
        look += [to_hex(artist.get_markerfacecolor()), to_hex(artist.get_markeredgecolor())]
        look += [artist.get_markersize(), artist.get_linewidth(), artist.get_zorder()]
        return [_label(artist), *look, *[np.asarray(data) for data in artist.get_data()]]
    if isinstance(artist, AxesImage | QuadMesh):
        values = np.ma.filled(np.ma.asarray(artist.get_array(), dtype=float), np.nan)
        box = artist.get_coordinates() if isinstance(artist, QuadMesh) else artist.get_extent()
        return [artist.get_cmap().name, artist.get_clim(), np.asarray(box), values]
    if isinstance(artist, Collection):
        paths = [path.vertices for path in artist.get_paths()]
        sizes = artist.get_sizes() if hasattr(artist, "get_sizes") else []
        look = [artist.get_facecolor(), artist.get_edgecolor(), artist.get_linewidth(), sizes]
        return [_label(artist), *map(np.asarray, look), np.asarray(artist.get_offsets()), paths]
    corners = artist.get_path().transformed(artist.get_patch_transform()).vertices
    return [_label(artist), to_hex(artist.get_facecolor(), keep_alpha=True), np.asarray(corners)]


def _label(artist):
    """The label of an artist; Matplotlib counts those that have none."""
    label = str(artist.get_label())
    return "" if label.startswith("_") else label

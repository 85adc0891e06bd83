"""What a figure shows, read off its artists as plain values that can be compared.

For tests and for anyone who wants the numbers behind a picture:

    for panel in content(draw(data, caption)).panels:
        print(panel.xlabel, [curve.label for curve in panel.curves])
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection, QuadMesh
from matplotlib.colors import LogNorm, to_hex
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch, Rectangle
from matplotlib.text import Annotation
from matplotlib.ticker import FixedLocator


@dataclass(frozen=True, eq=False)
class Curve:
    """Points of one line or set of markers, in the units of the axes."""

    label: str
    x: np.ndarray
    y: np.ndarray
    error: np.ndarray | None
    colour: str
    marker: str
    line: str


@dataclass(frozen=True, eq=False)
class Band:
    """A shaded band between two curves over the same x."""

    x: np.ndarray
    low: np.ndarray
    high: np.ndarray
    colour: str


@dataclass(frozen=True, eq=False)
class Image:
    """Values (Y, X) in colours, on cells between x_edges (X + 1,) and y_edges (Y + 1,)."""

    x_edges: np.ndarray
    y_edges: np.ndarray
    values: np.ndarray
    scale: str
    limits: tuple[float, float]
    label: str


@dataclass(frozen=True, eq=False)
class Panel:
    """One panel with its insets."""

    titles: tuple[str, str, str]
    xlabel: str
    ylabel: str
    xscale: str
    yscale: str
    xlim: tuple[float, float]
    ylim: tuple[float, float]
    xticks: tuple[str, ...]
    legend: tuple[str, ...]
    curves: tuple[Curve, ...]
    bands: tuple[Band, ...]
    guides: tuple[tuple[str, float], ...]
    spans: tuple[tuple[str, float, float], ...]
    arrows: tuple
    bars: tuple
    images: tuple[Image, ...]
    texts: tuple[str, ...]
    pointers: tuple[tuple[str, tuple[float, float]], ...]
    insets: tuple["Panel", ...]


@dataclass(frozen=True, eq=False)
class Content:
    """Panels of a figure, words of its common legend and at its top, and its small print."""

    panels: tuple[Panel, ...]
    legend: tuple[str, ...]
    top: str
    caption: str


def content(figure: Figure) -> Content:
    """What the figure shows."""
    bars = {image.colorbar.ax for axes in figure.axes for image in _meshes(axes) if image.colorbar}
    return Content(
        panels=tuple(_panel(axes) for axes in figure.axes if axes not in bars),
        legend=tuple(words for legend in figure.legends for words in _words(legend.get_texts())),
        top=figure.get_suptitle(),
        caption="\n".join(
            words for words in _words(figure.texts) if words != figure.get_suptitle()
        ),
    )


def _panel(axes: Axes) -> Panel:
    legend = axes.get_legend()
    return Panel(
        titles=tuple(axes.get_title(loc=place) for place in ("left", "center", "right")),
        xlabel=axes.get_xlabel(),
        ylabel=axes.get_ylabel(),
        xscale=axes.get_xscale(),
        yscale=axes.get_yscale(),
        xlim=axes.get_xlim(),
        ylim=axes.get_ylim(),
        xticks=_ticks_by_hand(axes),
        legend=_words(legend.get_texts()) if legend else (),
        curves=tuple(_curves(axes)),
        bands=tuple(_bands(axes)),
        guides=tuple(_guides(axes)),
        spans=tuple(_spans(axes)),
        arrows=tuple(_arrows(axes)),
        bars=tuple(_bars(axes)),
        images=(*map(_image, _meshes(axes)), *map(_picture, axes.images)),
        texts=_words(axes.texts),
        pointers=tuple(
            (*_words([each]), tuple(map(float, each.xy)))
            for each in axes.texts
            if isinstance(each, Annotation) and each.arrow_patch and each.get_text()
        ),
        insets=tuple(_panel(inner) for inner in axes.child_axes),
    )


def _words(texts) -> tuple[str, ...]:
    return tuple(" ".join(text.get_text().split()) for text in texts)


def _ticks_by_hand(axes) -> tuple[str, ...]:
    by_hand = isinstance(axes.xaxis.get_major_locator(), FixedLocator)
    return _words(axes.get_xticklabels()) if by_hand else ()


def _in_data(axes, transform) -> tuple[bool, bool]:
    """Whether x and y of an artist are data, not shares of the panel."""
    return transform.contains_branch_seperately(axes.transData)


def _curves(axes):
    bars = {each.lines[0]: each for each in axes.containers if isinstance(each, ErrorbarContainer)}
    for line in axes.lines:
        x, y = (np.asarray(values, dtype=float) for values in line.get_data())
        if x.size and all(_in_data(axes, line.get_transform())):
            error = _error(bars[line]) if line in bars else None
            yield _curve(line, str(bars.get(line, line).get_label()), x, y, error)


def _curve(line: Line2D, label, x, y, error) -> Curve:
    marker = "" if line.get_marker() in ("None", "none", "", " ") else line.get_marker()
    shape = "" if line.get_linestyle() in ("None", "none", "", " ") else line.get_linestyle()
    # Open markers have no face: their edge tells the colour.
    colour = line.get_markeredgecolor() if marker else line.get_color()
    return Curve(
        label="" if label.startswith("_") else label,
        x=x,
        y=y,
        error=error,
        colour=to_hex(colour),
        marker=marker,
        line=shape,
    )


def _error(container) -> np.ndarray:
    (bars,) = container.lines[2]
    return np.array([(end[1] - begin[1]) / 2 for begin, end in bars.get_segments()])


def _bands(axes):
    """Those of `fill_between`: an outline runs along one curve and back along the other."""
    for filled in axes.collections:
        if isinstance(filled, PolyCollection):
            colour = to_hex(filled.get_facecolor()[0])
            for outline in filled.get_paths():
                corners = np.asarray(outline.vertices)[:-1]  # the last one closes it
                count = len(corners) // 2 - 1
                below, above = corners[1 : count + 1], corners[count + 2 :][::-1]
                yield Band(x=below[:, 0], low=below[:, 1], high=above[:, 1], colour=colour)


def _guides(axes):
    for line in axes.lines:
        match _in_data(axes, line.get_transform()):
            case (True, False):
                yield "x", float(line.get_xdata()[0])
            case (False, True):
                yield "y", float(line.get_ydata()[0])


def _spans(axes):
    for patch in axes.patches:
        if not isinstance(patch, Rectangle):
            continue
        match _in_data(axes, patch.get_data_transform()):
            case (True, False):
                yield "x", patch.get_x(), patch.get_x() + patch.get_width()
            case (False, True):
                yield "y", patch.get_y(), patch.get_y() + patch.get_height()


def _arrows(axes):
    for patch in axes.patches:
        if isinstance(patch, FancyArrowPatch):
            yield tuple(tuple(map(float, end)) for end in patch._posA_posB)


def _bars(axes):
    containers = [each for each in axes.containers if isinstance(each, ErrorbarContainer)]
    errors = [line for each in containers for line in each.lines[2]]
    for lines in axes.collections:
        if isinstance(lines, LineCollection) and lines not in errors:
            yield from (tuple(map(tuple, segment)) for segment in lines.get_segments())


def _meshes(axes) -> list[QuadMesh]:
    return [each for each in axes.collections if isinstance(each, QuadMesh)]


def _image(mesh: QuadMesh) -> Image:
    corners = mesh.get_coordinates()
    shape = corners.shape[0] - 1, corners.shape[1] - 1
    return Image(
        x_edges=np.asarray(corners[0, :, 0]),
        y_edges=np.asarray(corners[:, 0, 1]),
        values=np.ma.filled(np.ma.asarray(mesh.get_array(), dtype=float), np.nan).reshape(shape),
        scale="log" if isinstance(mesh.norm, LogNorm) else "linear",
        limits=(float(mesh.norm.vmin), float(mesh.norm.vmax)),
        label=_bar_words(mesh.colorbar.ax) if mesh.colorbar else "",
    )


def _bar_words(axes) -> str:
    """Words at a colour bar, upright or lying."""
    return axes.get_ylabel() or axes.get_xlabel()


def _picture(image) -> Image:
    """A picture whose first row is at its top."""
    values = np.asarray(image.get_array())
    left, right, bottom, top = image.get_extent()
    return Image(
        x_edges=np.linspace(left, right, values.shape[1] + 1),
        y_edges=np.linspace(top, bottom, values.shape[0] + 1),
        values=values,
        scale="linear",
        limits=(float(image.norm.vmin), float(image.norm.vmax)),
        label="",
    )

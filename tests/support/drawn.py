"""Which numbers a figure draws, read off its artists: a Panel for each of its axes."""

import itertools
from types import SimpleNamespace

import numpy as np
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import LogNorm, to_hex
from matplotlib.container import ErrorbarContainer
from matplotlib.patches import Rectangle


class Curve(SimpleNamespace):
    """A line or a set of marks: columns x, y and, if there are error bars, their ends.

    label, colour, line style, and its look: whatever tells it from other curves.
    """

    @property
    def x(self):
        return self.points[:, 0]

    @property
    def y(self):
        return self.points[:, 1]

    def __repr__(self):
        return f"{self.label!r} of {len(self.points)} points from {self.points[:1].tolist()}"


def panels_of(figure):
    """Panels in the order in which they were made, without colour bars."""
    bars = {mesh.colorbar.ax for axes in figure.axes for mesh in _meshes(axes) if mesh.colorbar}
    panels = [axes for axes in figure.axes if axes not in bars]
    places = {axes.get_position(original=True).bounds: axes.get_position(True) for axes in panels}
    for one, other in itertools.combinations(places.values(), 2):
        shared = one.intersection(one, other)
        assert shared is None or shared.width * shared.height < 1e-9, "panels lie on one another"
    return [Panel(axes) for axes in panels]


def plain(texts):
    return [" ".join(text.get_text().split()) for text in texts]


class Panel:
    def __init__(self, axes):
        legend = axes.get_legend()
        self.axes = axes
        self.xlabel, self.ylabel = axes.get_xlabel(), axes.get_ylabel()
        self.title = "|".join(axes.get_title(loc=place) for place in ("left", "center", "right"))
        self.legend = plain(legend.get_texts()) if legend else []
        self.texts = plain(axes.texts)
        self.curves = list(_curves(axes))
        # (axis, value) of straight lines and (axis, low, high) of strips across the panel
        self.guides = [_guide(axes, line) for line in axes.lines if _across(axes, line)]
        self.spans = [span for patch in axes.patches if (span := _span(axes, patch))]
        self.images = [*map(_mesh, _meshes(axes))]

    def draws(self, xlabel, ylabel, *curves, scales="linear linear", more=0):
        """Assert axes, scales, and just these curves (x, y[, label[, error]]), in any order.

        Points may come in any order too. more : how many curves there are besides.
        """
        axes = self.axes
        assert (self.xlabel, self.ylabel) == (xlabel, ylabel)
        assert f"{axes.get_xscale()} {axes.get_yscale()}" == scales
        left = list(self.curves)
        for x, y, *words in curves:
            same = [curve for curve in left if _same(curve, x, y, *words)]
            assert same, f"{words[:1] or 'curve'} not drawn at {list(x)[:2]}, {y[:2]}: {left}"
            left = [curve for curve in left if curve is not same[0]]
        assert len(left) == more, f"also drawn: {left}"

    def is_trace(self, xlabel, ylabel, x, y):
        """Assert that the one curve is of these samples: all, or the extremes in narrow columns."""
        assert (self.xlabel, self.ylabel) == (xlabel, ylabel)
        (envelope,) = [one for one in self.axes.collections if isinstance(one, PolyCollection)]
        corners = envelope.get_paths()[0].vertices
        assert (corners[:, 1].min(), corners[:, 1].max()) == (y.min(), y.max())
        for value in (y.argmin(), y.argmax()):
            near = np.abs(corners[:, 0] - x[value]) < np.ptp(x) / 200
            assert corners[near, 1].min() <= y[value] <= corners[near, 1].max()

    def curve(self, label):
        """The one curve of this label, or of one that begins so."""
        same = [curve for curve in self.curves if curve.label == label]
        (curve,) = same or [curve for curve in self.curves if curve.label.startswith(label)]
        return curve


def _same(curve, x, y, label=None, error=None):
    wanted = _rows([x, y] if error is None else [x, y, *ends(y, error)])
    drawn = _rows(curve.points.T[: wanted.shape[1]])
    return (
        (label is None or curve.label == label)
        and wanted.shape == drawn.shape
        and np.allclose(wanted, drawn, rtol=1e-6, atol=0, equal_nan=True)
    )


def ends(y, error):
    """Ends of error bars of these half lengths, or of these lengths below and above."""
    below, above = np.broadcast_to(error, (2, len(y)))
    return y - below, y + above


def _rows(columns):
    """Columns as rows in a fixed order."""
    rows = np.column_stack([np.asarray(column, dtype=float) for column in columns])
    return rows[np.lexsort(rows.T[::-1])]


def _in_data(axes, transform):
    """Whether x and y of an artist are data, not shares of the panel."""
    return transform.contains_branch_seperately(axes.transData)


def _across(axes, line):
    return sum(_in_data(axes, line.get_transform())) == 1


def _guide(axes, line):
    if _in_data(axes, line.get_transform())[0]:
        return "x", float(line.get_xdata()[0])
    return "y", float(line.get_ydata()[0])


def _span(axes, patch):
    if isinstance(patch, Rectangle):
        match _in_data(axes, patch.get_data_transform()):
            case (True, False):
                return "x", patch.get_x(), patch.get_x() + patch.get_width()
            case (False, True):
                return "y", patch.get_y(), patch.get_y() + patch.get_height()
    return None


def _curves(axes):
    bars = {bar.lines[0]: bar for bar in axes.containers if isinstance(bar, ErrorbarContainer)}
    for line in axes.lines:
        columns = [np.asarray(values, dtype=float) for values in line.get_data()]
        if not columns[0].size or _across(axes, line):
            continue
        if line in bars and len(bars[line].lines[2]) == 1:
            # a bar without length (NaN) has no ends
            segments = bars[line].lines[2][0].get_segments()
            ends = np.array([bar if len(bar) == 2 else np.full((2, 2), np.nan) for bar in segments])
            columns += [ends[:, 0, 1], ends[:, 1, 1]]
        label = str(bars.get(line, line).get_label())
        marker, dash = (
            "" if look in ("None", "none", " ") else look
            for look in (line.get_marker(), line.get_linestyle())
        )
        # open markers have no face: their edge tells the colour
        colour = to_hex(line.get_markeredgecolor() if marker else line.get_color())
        label = "" if label.startswith("_") else " ".join(label.split())
        look = colour, marker, dash, to_hex(line.get_markerfacecolor())
        points = np.column_stack(columns)
        yield Curve(label=label, points=points, colour=colour, line=dash, look=look)


def corners(shade):
    """Places of a filled area, and the least and greatest y at each."""
    points = np.concatenate([path.vertices for path in shade.get_paths()])
    place = np.unique(points[:, 0])
    at = [points[points[:, 0] == x, 1] for x in place]
    return place, np.array([y.min() for y in at]), np.array([y.max() for y in at])


def _meshes(axes):
    return [mesh for mesh in axes.collections if isinstance(mesh, QuadMesh)]


def _mesh(mesh):
    corners = mesh.get_coordinates()
    shape = corners.shape[0] - 1, corners.shape[1] - 1
    words = mesh.colorbar.ax if mesh.colorbar else None
    return SimpleNamespace(
        x_edges=np.asarray(corners[0, :, 0]),
        y_edges=np.asarray(corners[:, 0, 1]),
        values=np.ma.filled(np.ma.asarray(mesh.get_array(), dtype=float), np.nan).reshape(shape),
        scale="log" if isinstance(mesh.norm, LogNorm) else "linear",
        limits=(float(mesh.norm.vmin), float(mesh.norm.vmax)),
        label=words.get_ylabel() or words.get_xlabel() if words else "",
    )

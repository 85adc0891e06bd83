"""What pictures are made of: envelopes, bands and densities, drawn into given axes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, to_hex
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from beltrepro.base.names import SYMBOLS
from beltrepro.model.units import UNIT_OF
from beltrepro.stats import sections

# Okabe and Ito's palette: distinct for colour-blind readers. Its yellow is too pale for lines.
BLACK, GREY = "#000000", "#7f7f7f"
BLUE, VERMILION, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"
SKY, PURPLE = "#56b4e9", "#cc79a7"
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
SHADES = ListedColormap(colormaps["magma_r"](np.linspace(0.18, 1, 256)))  # none is pale in print
DECADES = 3  # range of the colours of a density below the largest one, at most
RASTER_FROM = 5000  # more points than this are an image in a PDF
_FEW = 30  # places of a curve that have marks
_PER_DECADE = 20  # medians of a spectrum
_PER_CELL, _CELLS = 40, (64, 320)  # points, about, of a density; least and most along an axis


# --- words and colours ----------------------------------------------------------------------------

_SYMBOLS = {name: symbol for symbol, name in SYMBOLS.items()}
_SYMBOLS |= {"mean_length": r"\langle x_N \rangle", "largest_multiplier": r"|\mu|"}


def symbol(name: str) -> str:
    """A constant of a chain or an array of results, as the paper writes it or in words."""
    if name not in _SYMBOLS:
        return name.replace("_", " ")
    text = re.sub("^(sigma|eta|Delta)_?", r"\\\1 ", _SYMBOLS[name]).strip()
    return "$" + re.sub("_([A-Za-z0-9]+)", r"_{\1}", text) + "$"


def label(words: str, unit: str = "1") -> str:
    """Words at an axis, with the unit."""
    of_model = f"1 / model {unit[2:]}" if unit.startswith("1/") else f"model {unit}"
    return words if unit == "1" else f"{words} ({of_model})"


TIME = label("$t$", "time")


def label_of(name: str) -> str:
    """The label of a constant of a chain, or of an array of results."""
    return label(symbol(name), UNIT_OF.get(name, "1"))


def valued(name: str, value: Any, form: str = "g") -> str:
    """A quantity with its value, as a legend has it."""
    return f"{symbol(name)} = {value if isinstance(value, str) else format(value, form)}"


def form_of(values: Iterable[Any]) -> str:
    """A format in which each of the numbers has its own text, of six digits if these do."""
    numbers = {value for value in values if not isinstance(value, str)}
    forms = {form: {format(value, form) for value in numbers} for form in ("g", ".12g")}
    return next((form for form, texts in forms.items() if len(texts) == len(numbers)), ".17g")


def shades(count: int) -> list[str]:
    """Colours of an ordered quantity, dark to light: they keep their order in grey."""
    return [to_hex(colormaps["viridis"](place)) for place in np.linspace(0, 0.8, count)]


def plain_log(axis: Any, subs: Sequence[float] = (1, 2, 5)) -> None:
    """Label a logarithmic axis of one or two decades with plain numbers."""
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


# --- curves ---------------------------------------------------------------------------------------


def envelope(axes: Axes, x: np.ndarray, y: np.ndarray, **look: Any) -> Any:
    """A curve; of more points than the axes have pixels the least and greatest y in each column."""
    look = {"color": BLUE, "linewidth": 0.7} | look
    columns = max(1, int(axes.bbox.width))
    if x.size <= columns:
        return axes.plot(x, y, **look)[0]
    finite = np.isfinite(x)  # what lies between parts of a curve has none
    edges = np.linspace(x[finite][0], x[finite][-1], columns + 1)
    column = np.clip(np.searchsorted(edges, x[finite], side="right") - 1, 0, columns - 1)
    ends = np.full((2, columns), np.nan)
    for extreme, end in zip((np.fmin, np.fmax), ends, strict=True):
        extreme.at(end, column, y[finite])
    colour = look.pop("color")
    face = {"facecolor": (colour, 0.35), "edgecolor": colour}
    return axes.fill_between((edges[1:] + edges[:-1]) / 2, *ends, **face, **look)


def band(axes: Axes, x: np.ndarray, y: np.ndarray, **look: Any) -> Any:
    """The mean of the y at each x, over a band of 10 to 90 % of them."""
    spread = sections.spread(x, y)
    mark = {"marker": "o", "markersize": 2.5} if spread.place.size <= _FEW else {}
    (line,) = axes.plot(spread.place, spread.mean, **{"linewidth": 1.0} | mark | look)
    if np.any(spread.high > spread.low):
        ends = spread.tenth, spread.ninetieth
        shade = {"color": line.get_color(), "alpha": 0.2, "linewidth": 0}
        axes.fill_between(spread.place, *ends, zorder=line.get_zorder() - 0.5, **shade)
    return line


# --- spectra and power laws -----------------------------------------------------------------------


def medians(frequency: np.ndarray, power: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places and medians of a spectrum in narrow bins."""
    bins = np.floor(_PER_DECADE * np.log10(frequency))
    places = 10 ** ((np.unique(bins) + 0.5) / _PER_DECADE)
    return places, np.array([np.median(power[bins == one]) for one in np.unique(bins)])


def spectrum(
    axes: Axes, frequency: np.ndarray, power: np.ndarray, middle: Any = None, **look: Any
) -> Any:
    """A spectrum, pale, and its medians: of what scatters the eye follows the upper end."""
    pale = {"color": look.get("color", SKY), "linewidth": 0.3, "alpha": 0.5, "rasterized": True}
    axes.loglog(frequency, power, **pale)
    look = {"color": BLUE, "linewidth": 0.9, "label": "median"} | look
    return axes.loglog(*(middle or medians(frequency, power)), **look)[0]


def power_law(axes: Axes, law: Any, **look: Any) -> None:
    """A fitted power law, over the range of the fit."""
    ends = np.array([law.low, law.high])
    axes.loglog(ends, law(ends), **({"color": VERMILION, "linewidth": 1.6} | look))


# --- densities ------------------------------------------------------------------------------------


def colour_limits(*densities: np.ndarray) -> dict[str, float]:
    """The colours of all positive values of some densities, of the largest three decades."""
    values = np.concatenate([one[one > 0] for one in densities])
    most = float(values.max())
    return {"vmin": max(float(values.min()), most / 10**DECADES), "vmax": most}


def density(axes: Axes, x: np.ndarray, y: np.ndarray, values: np.ndarray, **look: Any) -> Any:
    """Densities (Y, X) between edges x (X + 1,) and y (Y + 1,), in logarithmic colours."""
    look = {"cmap": SHADES, "norm": "log", "rasterized": True} | colour_limits(values) | look
    return axes.pcolormesh(x, y, np.where(values > 0, values, np.nan), **look)


def cells(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges x and y of cells as small as the number of points allows, and how many in each."""
    number = int(np.clip(np.sqrt(x.size / _PER_CELL) * 10, *_CELLS))
    count, *sides = np.histogram2d(x, y, number)
    return *sides, count.T


def plane(axes: Axes, x: np.ndarray, y: np.ndarray, **look: Any) -> Any:
    """The density of points."""
    *sides, count = cells(x, y)
    area = np.outer(np.diff(sides[1]), np.diff(sides[0]))
    return density(axes, *sides, count / (x.size * area), **look)


def colour_bar(meshes: Sequence[Any], axes: Any, words: str, **look: Any) -> Any:
    """One scale for some densities of equal colours, beside these axes."""
    least = min(mesh.get_array().min() for mesh in meshes)
    extend = "min" if least < meshes[0].norm.vmin else "neither"
    look = {"extend": extend, "pad": 0.02, "aspect": 30} | look
    return meshes[0].figure.colorbar(meshes[0], ax=axes, label=words, **look)


def edges(places: np.ndarray) -> np.ndarray:
    """Edges (P + 1,) of the columns of a density at some places: in the middle between them."""
    if places.size == 1:
        return places + np.array([-0.5, 0.5])
    steps = np.diff(places, prepend=2 * places[0] - places[1], append=2 * places[-1] - places[-2])
    return np.append(places - steps[:-1] / 2, places[-1] + steps[-1] / 2)

"""Look of the figures: colours, page with small print, files that are the same bytes every time."""

import functools
import json
import textwrap
from pathlib import Path

import matplotlib.style
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from beltrepro.base import provenance, seal
from beltrepro.base.atomic import replacing
from beltrepro.replication.plan.points import LAW

# Okabe and Ito's palette: distinct for colour-blind readers. Its yellow is too pale for lines.
BLACK, GREY = "#000000", "#7f7f7f"
BLUE, VERMILION, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"
SKY, PURPLE = "#56b4e9", "#cc79a7"
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
MARKERS = "osD^vXP"
DASHES = ("-", "--", "-.", ":")

WIDTH = 7.2  # inches
_PRINT_SIZE = 6.0  # points
_LINE_HEIGHT = 1.35 * _PRINT_SIZE / 72  # inches
_LETTERS_PER_INCH = 20  # at the print size
_CANVASES = {"png": FigureCanvasAgg, "pdf": FigureCanvasPdf, "svg": FigureCanvasSVG}
_SHEET = ["default", str(Path(__file__).with_name("beltrepro.mplstyle"))]


def styled(draw):
    """Decorator: run with the style of this project, whatever the user's matplotlib settings."""

    @functools.wraps(draw)
    def with_style(*args, **kwargs):
        with matplotlib.style.context(_SHEET):
            return draw(*args, **kwargs)

    return with_style


@styled
def page(caption, height) -> Figure:
    """Empty figure of full width and the given height in inches, with the caption at the foot."""
    dpi = matplotlib.rcParams["savefig.dpi"]
    figure = Figure(figsize=(WIDTH, height), dpi=dpi, layout="constrained")
    width = int(WIDTH * _LETTERS_PER_INCH)
    lines = [part for line in caption.splitlines() for part in textwrap.wrap(line, width)]
    foot = (len(lines) + 0.5) * _LINE_HEIGHT / height if lines else 0.0
    figure.get_layout_engine().set(rect=(0, foot, 1, 1 - foot), w_pad=0.06, h_pad=0.05)
    look = {"size": _PRINT_SIZE, "color": "0.35", "va": "bottom", "linespacing": 1.2}
    figure.text(0.008, 0.3 * _LINE_HEIGHT / height, "\n".join(lines), **look)
    return figure


def font(size):
    """Context in which all words of a figure have one size, in points."""
    names = ("font.size", "axes.titlesize", "axes.labelsize", "xtick.labelsize", "ytick.labelsize")
    return matplotlib.rc_context(dict.fromkeys((*names, "legend.fontsize"), size))


def shades(count) -> list[str]:
    """Colours of an ordered quantity, dark to light: they keep their order in grey."""
    return [to_hex(matplotlib.colormaps["viridis"](place)) for place in np.linspace(0, 0.9, count)]


def line_style(index) -> dict:
    """Colour, marker and dashes of the curve of this number."""
    return {
        "color": COLOURS[index % len(COLOURS)],
        "marker": MARKERS[index % len(MARKERS)],
        "linestyle": DASHES[index % len(DASHES)],
    }


def small_print(datasets, preset) -> str:
    """What a figure rests on, in a few lines: preset, code version, seed; parameters and method.

    datasets : list of `store.Dataset`, may be empty.  preset : name of the preset.
    """
    # A dataset that was made in parts by several versions lists them all.
    listed = [data.attributes.get("code_version") for data in datasets]
    versions = {version for text in listed if text for version in text.split(", ")}
    versions = versions or {provenance.code_version()}
    first = [f"beltrepro {', '.join(sorted(versions))}", f"preset {preset}"]
    seeds = _parameter(datasets, "seed")
    if seeds.size:
        first.append(f"seed {_span(seeds)}")
    groups: dict[tuple, list] = {}
    for dataset in datasets:
        how = map(dataset.attributes.get, ("kind", "method", "duration", "transient"))
        groups.setdefault(tuple(how), []).append(dataset)
    lines = [_describe(group, *how) for how, group in groups.items()]
    return "\n".join([", ".join(first), *(lines or ["no simulation: drawn from the model itself"])])


@styled
def save(figure, png, pdf, source="", lineage=None) -> None:
    """Write the figure as PNG and PDF, with `source` and `lineage` from `plan.inputs`."""
    # Once, so that both files have the same layout.
    figure.get_layout_engine().execute(figure)
    figure.set_layout_engine("none")
    write(figure, png, Path(png).stem, source, lineage)
    write(figure, pdf, Path(png).stem, source, lineage)


def write(figure, path, title, source="", lineage=None) -> None:
    """Write a figure as PNG, PDF or SVG, by the ending, with its title, source and origin.

    The origin is JSON: code, libraries and processor that drew it, and what made its data.
    """
    kind = Path(path).suffix.lower()[1:]
    version = provenance.code_version()
    # Libraries that draw, and the processor: its rounding can move a pixel.
    libraries = provenance.library_versions() | {"matplotlib": matplotlib.__version__}
    drawn = {"code_version": version, "library_versions": libraries}
    drawn |= {"processor": provenance.processor(), "lineage": lineage or {}}
    made_by, words = f"beltrepro {version}", json.dumps(drawn)
    about = {
        "png": {"Source": source, "Author": made_by, "Description": words},
        "pdf": {"Subject": source, "Author": made_by, "Keywords": words, "CreationDate": None},
        "svg": {"Source": source, "Creator": made_by, "Description": words, "Date": None},
    }
    # `figure.savefig` draws all twice, the first time for the layout.
    canvas, dpi = _CANVASES[kind](figure), figure.dpi
    with replacing(path) as unfinished:
        getattr(canvas, f"print_{kind}")(unfinished, metadata={"Title": title} | about[kind])
        if kind != "svg":  # nothing may follow the end of XML
            seal.put(unfinished)
    figure.set_dpi(dpi)  # that of a PDF is 72


def _describe(datasets, kind, method, duration, transient):
    """One line on datasets made the same way; with constants that differ from the paper's."""
    spans = {
        symbol: _span(values)
        for symbol, name in (("N", "n_blocks"), ("u", "belt_velocity"), ("σ", "noise"))
        if (values := _parameter(datasets, name)).size
    }
    for quantity in LAW:
        values = _parameter(datasets, quantity.name)
        if np.any(values != quantity.default):
            spans[quantity.symbol] = _span(values)
    parts = [f"{symbol} = {span}" for symbol, span in spans.items()]
    parts += [f"method {method}", f"dt = {_span(_parameter(datasets, 'time_step'))}"]
    parts.append(f"t = {_number(duration)}")
    if transient is not None:
        parts.append(f"t_trans = {_number(transient)}")
    return f"{kind}: {', '.join(parts)}"


def _parameter(datasets, name):
    """Values of a quantity in all points of all datasets."""
    values = [
        np.atleast_1d(dataset.arrays[name] if name in dataset.arrays else dataset.attributes[name])
        for dataset in datasets
        if name in dataset.arrays or name in dataset.attributes
    ]
    return np.unique(np.concatenate(values)) if values else np.array([])


def _span(values):
    if values.size <= 7:
        return ", ".join(f"{value:g}" for value in values)
    return f"{values[0]:g} to {values[-1]:g} ({values.size} values)"


def _number(value):
    return f"{value:.10g}" if isinstance(value, int | float) else str(value)

"""Look of the figures: colours, page, files that are the same bytes every time."""

import functools
import json
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
from beltrepro.simulation.artists import COLOURS, GREY, shades  # noqa: F401

BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK = COLOURS
PAPER = {"color": BLACK, "linestyle": "--", "linewidth": 1.0}  # what the paper prints
HERE = {"color": VERMILION, "linewidth": 1.4}  # the same, as found here
MARKERS = "osD^vXP"
DASHES = ("-", "--", ":", "-.")
_LONG_CHAIN = (0, (5, 1, 1, 1, 1, 1))  # dashes from eight blocks on

WIDTH = 8.6 / 2.54  # inches: a column of the paper
WIDE = 17.8 / 2.54  # both columns
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
def page(height, *, wide=False) -> Figure:
    """Empty figure of one column, or of both, and the given height in inches."""
    dpi = matplotlib.rcParams["savefig.dpi"]
    figure = Figure(figsize=(WIDE if wide else WIDTH, height), dpi=dpi, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.03, h_pad=0.03)
    return figure


def colour_of_size(n_blocks) -> str:
    """Colour of a number of blocks, in all figures."""
    return to_hex(matplotlib.colormaps["plasma"](np.clip((n_blocks - 2) / 10, 0, 0.9)))


def look_of_size(n_blocks) -> dict:
    """Colour, marker and dashes of a number of blocks, in all figures; told apart in grey."""
    marker = MARKERS[(n_blocks + n_blocks // 8) % 7]
    dashes = DASHES[(n_blocks - 5) % 4] if n_blocks < 8 else _LONG_CHAIN
    return {"color": colour_of_size(n_blocks), "marker": marker, "linestyle": dashes}


def look_of_noise(noise) -> dict:
    """Colour and dashes of a noise, in all figures: dark and solid without noise, light at 10."""
    place = min(np.log1p(noise) / np.log(11), 1)
    colour = to_hex(matplotlib.colormaps["viridis"](0.9 * place))
    return {"color": colour, "linestyle": DASHES[round(4 * place) % 4]}


def line_style(index) -> dict:
    """Colour, marker and dashes of the curve of this number."""
    return {
        "color": COLOURS[index % len(COLOURS)],
        "marker": MARKERS[index % len(MARKERS)],
        "linestyle": DASHES[index % len(DASHES)],
    }


@styled
def save(figure, png, pdf, sources) -> None:
    """Write the figure as PNG and PDF, with the datasets behind it, see `plan.io.load`."""
    # Once, so that both files have the same layout.
    figure.get_layout_engine().execute(figure)
    figure.set_layout_engine("none")
    write(figure, png, Path(png).stem, sources)
    write(figure, pdf, Path(png).stem, sources)


@styled
def write(figure, path, title, sources=None) -> None:
    """Write a figure as PNG, PDF or SVG, by the ending, with its title and origin.

    The origin is JSON: code, libraries and processor that drew it, and the datasets behind it.
    """
    kind = Path(path).suffix.lower()[1:]
    # matplotlib draws, and the rounding of the processor can move a pixel
    origin = provenance.origin() | {"matplotlib": matplotlib.__version__, "sources": sources or {}}
    made_by, words = f"beltrepro {origin['code_version']}", json.dumps(origin)
    about = {
        "png": {"Author": made_by, "Description": words},
        "pdf": {"Author": made_by, "Keywords": words, "CreationDate": None},
        "svg": {"Creator": made_by, "Description": words, "Date": None},
    }
    # `figure.savefig` draws all twice, the first time for the layout.
    canvas, dpi = _CANVASES[kind](figure), figure.dpi
    with replacing(path) as unfinished:
        getattr(canvas, f"print_{kind}")(unfinished, metadata={"Title": title} | about[kind])
        seal.put(unfinished)
    figure.set_dpi(dpi)  # that of a PDF is 72

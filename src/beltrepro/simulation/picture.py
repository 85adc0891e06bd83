"""One run at a glance: x_N(t), r and slips; `Run.plot` and `beltrepro plot` draw it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.backends.registry import BackendFilter, backend_registry
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from beltrepro.base import checks
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.base.names import SYMBOLS

SUFFIXES = (".png", ".pdf", ".svg")
NO_DISPLAY = f"no display to show the figure on: name a file that ends in {', '.join(SUFFIXES)}"
LOOK: dict[str, Any] = {
    "font.size": 8.5,
    "axes.titlesize": 8.5,
    "axes.linewidth": 0.7,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "savefig.dpi": 200,
    "agg.path.chunksize": 20000,
}
_BLUE, _VERMILION, _GREEN = "#0072b2", "#d55e00", "#009e73"  # told apart by colour-blind readers
_MEAN = {"color": _VERMILION, "linewidth": 0.8, "linestyle": "--"}
_RASTER_FROM = 5000  # more samples than this are an image in a PDF
_SLIPS_SHOWN = 200.0  # model time of the panel of slips: some ten slips of each block
_BAR = 0.7  # height of the bar of a slip; blocks are 1 apart
_USUAL_ROWS = 12  # blocks for which there is room on the usual page
_ROW = 0.12  # inches for each block beyond


def put(draw: Callable[[], Figure], path: str | Path | None, title: str) -> Figure:
    """Write the figure that a function draws to a file, or show it."""
    if path is not None:
        path = checks.path("path", path, SUFFIXES)
    where = display() if path is None else "file"
    if not where:
        raise InputError(NO_DISPLAY)
    figure = draw()
    if path is not None:
        with matplotlib.style.context(LOOK), replacing(path) as unfinished:
            figure.savefig(unfinished, metadata={"Title": title})
    elif where == "window":
        _open_window(figure)
    return figure


def _open_window(figure):
    import matplotlib.pyplot as plt

    plt.figure("beltrepro", FigureClass=lambda *_, **__: figure)
    plt.show()


def display() -> str:
    """Where a figure can be shown: "window", "notebook", which shows it by itself, or nowhere."""
    import matplotlib.pyplot as plt

    try:
        plt.switch_backend(matplotlib.get_backend())
    except ImportError:  # a backend for windows, and no display
        return ""
    backend = matplotlib.get_backend().lower()
    for kind, where in ((BackendFilter.INTERACTIVE, "window"), (BackendFilter.NON_INTERACTIVE, "")):
        if backend in backend_registry.list_builtin(kind):
            return where
    return "notebook"


def draw(run: Any) -> Figure:
    """x_N(t) and r up to t over the whole run; below, who slips when at its end."""
    begin, end = run.initial_state.time, run.final_state.time
    n_blocks = run.parameters.n_blocks
    rows_beyond = max(0, n_blocks - _USUAL_ROWS)
    with matplotlib.style.context(["default", LOOK]):
        figure = Figure(figsize=(7.2, 5.2 + _ROW * rows_beyond), layout="constrained")
        ratios = [2, 1, 1.6 + 0.04 * rows_beyond]
        length, disorder, slips = figure.subplots(3, 1, height_ratios=ratios)
        _draw_length(length, run)
        length.axvspan(begin, begin + run.transient, color="0.5", alpha=0.2, linewidth=0)
        length.set(xlim=(begin, end), ylabel="$x_N$")
        length.tick_params(labelbottom=False)
        _draw_disorder(disorder, run)
        disorder.sharex(length)
        disorder.set(xlabel="$t$", ylabel=r"$r$ up to $t$")
        left = max(begin, end - _SLIPS_SHOWN)
        for block in range(1, n_blocks + 1):
            bars = [(low, high - low) for low, high in slips_of(run, block) if high > left]
            slips.broken_barh(bars, (block - _BAR / 2, _BAR), color=_GREEN, linewidth=0)
        slips.set(xlim=(left, end), ylim=(0.4, n_blocks + 0.6), xlabel="$t$")
        slips.set_ylabel("slipping block")
        slips.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    return figure


def _draw_length(axes, run):
    many = run.time.size > _RASTER_FROM
    axes.plot(run.time, run.positions[:, -1], color=_BLUE, linewidth=0.5, rasterized=many)
    title = _title(run.parameters)
    if np.isfinite(run.mean_length):
        axes.axhline(run.mean_length, **_MEAN)
        mean = rf"$\langle x_N \rangle$ = {run.mean_length:.4g}"
        title += rf":  $r$ = {run.disorder_parameter:.4g},  {mean}"
    axes.set_title(title)


def _title(chain):
    """The chain, with the constants of its law that differ from those of the paper."""
    text = chain.describe()
    for symbol, name in SYMBOLS.items():
        text = text.replace(f"{name}=", f"{symbol}=")
    return text.replace("sigma", "σ")


def _draw_disorder(axes, run):
    """r of the samples from the transient up to each instant; level if the run is long enough."""
    later = run.time >= run.initial_state.time + run.transient
    time, length = run.time[later], run.positions[later, -1]
    count = np.arange(1, time.size + 1)
    # about the first one, as a small variance of large numbers has no digits
    offset = length - length[:1]
    mean = np.cumsum(offset) / count
    variance = np.maximum(np.cumsum(offset**2) / count - mean**2, 0.0)
    axes.plot(time, np.sqrt(variance) / (length[:1] + mean), color=_BLUE, linewidth=0.9)
    if np.isfinite(run.disorder_parameter):
        axes.axhline(run.disorder_parameter, **_MEAN)
    axes.set_ylim(bottom=0)


def slips_of(run: Any, block: int) -> list[tuple[float, float]]:
    """When a block slips, pairs (begin, end); cut where the run begins or ends."""
    events = run.events[run.events["block"] == block]
    begins, ends = (events["time"][events["kind"] == kind].tolist() for kind in ("slip", "stick"))
    if run.initial_state.directions[block - 1]:
        begins = [run.initial_state.time, *begins]
    if len(begins) > len(ends):
        ends.append(run.final_state.time)
    return list(zip(begins, ends, strict=True))

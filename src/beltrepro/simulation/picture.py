"""One run at a glance: x_N(t), r and slips; `Run.plot` and `beltrepro plot` draw it."""

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.backends.registry import BackendFilter, backend_registry
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

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
_MOST_ROWS = 12  # blocks for which there is room on the usual page
_ROW = 0.12  # inches for each block beyond


def plot(run: Any, path: str | Path | None = None) -> Figure:
    """Draw a run; write the figure to a file, or show it."""
    return put(lambda: draw(run), path, f"{run!r}, beltrepro {run.version}")


def put(draw: Callable[[], Figure], path: str | Path | None, title: str) -> Figure:
    """Write the figure that a function draws to a file, or show it."""
    if path is not None and Path(path).suffix.lower() not in SUFFIXES:
        raise InputError(f"path = {path}: must end in {', '.join(SUFFIXES)}")
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
    except ImportError:
        return ""
    backend = matplotlib.get_backend().lower()
    if backend in backend_registry.list_builtin(BackendFilter.INTERACTIVE):
        return "window"
    return (
        ""
        if backend in backend_registry.list_builtin(BackendFilter.NON_INTERACTIVE)
        else "notebook"
    )


def draw(run: Any) -> Figure:
    """x_N(t) and r up to t over the whole run; below, who slips when at its end."""
    rows_beyond = max(0, run.parameters.n_blocks - _MOST_ROWS)
    with matplotlib.style.context(["default", LOOK]):
        figure = Figure(figsize=(7.2, 5.2 + _ROW * rows_beyond), layout="constrained")
        ratios = [2, 1, 1.6 + 0.04 * rows_beyond]
        length, disorder, slips = figure.subplots(3, 1, height_ratios=ratios)
        _draw_length(length, run)
        _draw_disorder(disorder, run)
        disorder.sharex(length)
        length.tick_params(labelbottom=False)
        _draw_slips(slips, run)
    return figure


def _span(run):
    """Model time at which the run began and ended."""
    return run.initial_state.time, run.final_state.time


def _draw_length(axes, run):
    begin, end = _span(run)
    many = run.time.size > _RASTER_FROM
    axes.plot(run.time, run.positions[:, -1], color=_BLUE, linewidth=0.5, rasterized=many)
    axes.set(xlim=(begin, end), ylabel="$x_N$")
    if not run.time.size:
        _note(axes, "no samples")
    axes.axvspan(begin, begin + run.transient, color="0.5", alpha=0.2, linewidth=0)
    title = _title(run.parameters)
    if np.isfinite(run.mean_length):
        axes.axhline(run.mean_length, **_MEAN)
        title += rf":  $r$ = {run.disorder_parameter:.4g},  $\langle x_N \rangle$ = "
        title += f"{run.mean_length:.4g}"
    axes.set_title(title)


def _title(chain):
    """The chain, with the constants of its law that differ from those of the paper."""
    symbols = {name: symbol for symbol, name in SYMBOLS.items()}
    parts = [chain.describe().replace("sigma", "σ")]
    for field in fields(chain)[3:]:
        symbol, value = symbols[field.name], getattr(chain, field.name)
        if value != field.default:
            parts.append(
                f"{symbol} by block" if isinstance(value, tuple) else f"{symbol}={value:g}"
            )
    return ", ".join(parts)


def _draw_disorder(axes, run):
    """r of the samples from the transient up to each instant; level if the run is long enough."""
    later = run.time >= run.initial_state.time + run.transient
    time, length = run.time[later], run.positions[later, -1]
    count = np.arange(1, time.size + 1)
    # about the first one, as a small variance of large numbers has no digits
    offset = length - (length[0] if time.size else 0.0)
    mean = np.cumsum(offset) / count
    variance = np.maximum(np.cumsum(offset**2) / count - mean**2, 0.0)
    axes.plot(time, np.sqrt(variance) / (length - offset + mean), color=_BLUE, linewidth=0.9)
    if np.isfinite(run.disorder_parameter):
        axes.axhline(run.disorder_parameter, **_MEAN)
    axes.set(xlabel="$t$", ylabel=r"$r$ up to $t$")
    axes.set_ylim(bottom=0)
    if not time.size:
        _note(axes, "no samples after the transient")


def _draw_slips(axes, run):
    begin, end = _span(run)
    left = max(begin, end - _SLIPS_SHOWN)
    for block in range(1, run.parameters.n_blocks + 1):
        slips = [(low, high - low) for low, high in slips_of(run, block) if high > left]
        axes.broken_barh(slips, (block - _BAR / 2, _BAR), color=_GREEN, linewidth=0)
    axes.set(xlim=(left, end), ylim=(0.4, run.parameters.n_blocks + 0.6))
    axes.set(xlabel="$t$", ylabel="slipping block")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def slips_of(run: Any, block: int) -> list[tuple[float, float]]:
    """When a block slips, pairs (begin, end); cut where the run begins or ends."""
    events = run.events[run.events["block"] == block]
    begins, ends = (events["time"][events["kind"] == kind] for kind in ("slip", "stick"))
    begin, end = _span(run)
    if run.initial_state.directions[block - 1]:
        begins = np.concatenate([[begin], begins])
    if len(begins) > len(ends):
        ends = np.concatenate([ends, [end]])
    return list(zip(begins.tolist(), ends.tolist(), strict=True))


def _note(axes, text):
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", style="italic")

"""Pictures as files and on screens; and one run at a glance: x_N(t), r and slips."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.artist import ArtistInspector
from matplotlib.axes import Axes
from matplotlib.backends.registry import BackendFilter, backend_registry
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from beltrepro.base import checks, names
from beltrepro.base.atomic import replacing
from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError
from beltrepro.base.names import SYMBOLS
from beltrepro.simulation.artists import BLUE, GREEN, RASTER_FROM, VERMILION

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
# One panel has the width of a column of a journal, and letters that are legible there.
PANEL: dict[str, Any] = {
    "figure.figsize": (8.6 / 2.54, 2.6),
    "figure.dpi": 300,
    "savefig.dpi": "figure",
    "font.size": 8,
    "legend.fontsize": 7,
    "ytick.right": True,
}
_MEAN = {"color": VERMILION, "linewidth": 0.8, "linestyle": "--"}
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
        with matplotlib.style.context(LOOK):
            _write(figure, path, title)
    elif where == "window":
        _open_window(figure)
    return figure


def panel(
    draw: Callable[[Axes], Any], path: str | Path | None, axes: Axes | None, title: str
) -> Axes:
    """Draw into axes, or into those of a new figure, which is written to a file or shown."""
    if path is not None:
        path = checks.path("path", path, SUFFIXES)
    if not isinstance(axes, Axes | None):
        raise InputError(f"ax = {shown(axes)}: one Axes of matplotlib is needed")
    given = axes is not None
    with nullcontext() if given else matplotlib.style.context(["default", LOOK, PANEL]):
        axes = axes or Figure(layout="constrained").subplots()
        draw(axes)
        figure = axes.figure.canvas.figure  # also of the axes of a part of a figure
        if path is not None:
            _write(figure, path, title)
        elif not given and (where := display()):
            _open_window(figure) if where == "window" else _put_into_notebook(figure)
    return axes


def keywords(title: str, given: Mapping[str, Any], arguments: Sequence[str]) -> dict[str, Any]:
    """Keywords that are arguments of a function, or by their long names what it draws has."""
    kinds = [ArtistInspector(kind) for kind in (Line2D, PolyCollection, QuadMesh)]
    long = {short: name for kind in kinds for name, all_ in kind.aliasd.items() for short in all_}
    allowed = [*arguments, "cmap", "norm", "vmin", "vmax", *long]
    allowed += [name for kind in kinds for name in kind.get_setters()]
    for name in given:
        if name not in allowed:
            meant = names.hint(name, allowed) or f": its own are {', '.join(arguments)}"
            raise InputError(f"{title} has no argument {name!r}{meant}")
    return {long.get(name, name): value for name, value in given.items()}


def _write(figure, path, title):
    with replacing(path) as unfinished:
        figure.savefig(unfinished, metadata={"Title": title})


def _put_into_notebook(figure):
    from IPython.display import display as show_now

    show_now(figure)


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
    """x_N(t) and r up to t over all that has samples; below, who slips when at its end."""
    begin, end = run.initial_state.time, run.final_state.time
    n_blocks = run.parameters.n_blocks
    rows_beyond = max(0, n_blocks - _USUAL_ROWS)
    with matplotlib.style.context(["default", LOOK]):
        figure = Figure(figsize=(7.2, 5.2 + _ROW * rows_beyond), layout="constrained")
        ratios = [2, 1, 1.6 + 0.04 * rows_beyond]
        length, disorder, slips = figure.subplots(3, 1, height_ratios=ratios)
        _draw_length(length, run)
        length.axvspan(begin, begin + run.transient, color="0.5", alpha=0.2, linewidth=0)
        sampled = begin + run.sample_start if run.time.size else begin
        length.set(xlim=(sampled, end), ylabel="$x_N$")
        length.tick_params(labelbottom=False)
        _draw_disorder(disorder, run)
        disorder.sharex(length)
        late = run.sample_start > run.transient  # r of the run is that from the transient on
        since = f"\nfrom {sampled:.4g} on" * late
        disorder.set(xlabel="$t$", ylabel=f"$r$ up to $t${since}")
        draw_slips(slips, run, end - _SLIPS_SHOWN)
        slips.set_xlabel("$t$")
    return figure


def draw_slips(axes: Axes, run: Any, since: float, **look: Any) -> None:
    """Which blocks slip when: a row for each, with a bar for each slip; the end is shown."""
    begin, end, n_blocks = run.initial_state.time, run.final_state.time, run.parameters.n_blocks
    how: dict[str, Any] = {"color": GREEN, "linewidth": 0} | look
    for block in range(1, n_blocks + 1):
        bars = [(low, high - low) for low, high in slips_of(run, block) if high > since]
        axes.broken_barh(bars, (block - _BAR / 2, _BAR), **how)
    axes.set(xlim=(max(begin, end - _SLIPS_SHOWN), end), ylim=(0.4, n_blocks + 0.6))
    axes.set_ylabel("slipping block")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def _draw_length(axes, run):
    many = run.time.size > RASTER_FROM
    axes.plot(run.time, run.positions[:, -1], color=BLUE, linewidth=0.5, rasterized=many)
    more = f", then {len(run.changes)} other u" if run.changes else ""
    title = _title(run.parameters) + more
    if np.isfinite(run.mean_length):
        axes.axhline(run.mean_length, **_MEAN)
        mean = rf"$\langle x_N \rangle$ = {run.mean_length:.4g}"
        of_all = " of all" if run.changes else ""
        title += rf":  $r${of_all} = {run.disorder_parameter:.4g},  {mean}"
    axes.set_title(title)


def _title(chain):
    """The chain, with the constants of its law that differ from those of the paper."""
    text = chain.describe()
    for symbol, name in SYMBOLS.items():
        text = text.replace(f"{name}=", f"{symbol}=")
    return text.replace("sigma", "σ")


def _draw_disorder(axes, run):
    """r of the samples after the transient up to each instant; level if the run is long enough."""
    later = run.time >= run.initial_state.time + run.transient
    time, length = run.time[later], run.positions[later, -1]
    count = np.arange(1, time.size + 1)
    # about the first one, as a small variance of large numbers has no digits
    offset = length - length[:1]
    mean = np.cumsum(offset) / count
    variance = np.maximum(np.cumsum(offset**2) / count - mean**2, 0.0)
    axes.plot(time, np.sqrt(variance) / (length[:1] + mean), color=BLUE, linewidth=0.9)
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

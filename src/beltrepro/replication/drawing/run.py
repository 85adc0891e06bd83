"""One run at a glance: x_N(t), r and slips; `Run.plot` and `beltrepro plot` call it."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.backends.registry import BackendFilter, backend_registry
from matplotlib.ticker import MaxNLocator

from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.quantities import LAW

SUFFIXES = (".png", ".pdf", ".svg")
NO_DISPLAY = f"no display to show the figure on: name a file that ends in {', '.join(SUFFIXES)}"
_SLIPS_SHOWN = 200.0  # model time of the panel of slips: some ten slips of each block
_BAR = 0.7  # height of the bar of a slip; blocks are 1 apart
_MOST_ROWS = 12  # blocks for which there is room on the usual page
_ROW = 0.12  # inches for each block beyond


def plot(run, path=None):
    """Draw a run; write the figure to a file, or show it.

    run : `beltrepro.Run`.  path : .png, .pdf or .svg; None to show it.

    Raises InputError for another ending, or if there is nowhere to show it.
    """
    if path is None:
        toolkit = _toolkit()
        figure = draw_run(run)
        if toolkit:
            _open_window(figure)
        return figure
    check_suffix("path", path)
    figure = draw_run(run)
    save(figure, path)
    return figure


def check_suffix(name, path):
    """Refuse a file that matplotlib would not write as a figure."""
    if Path(path).suffix.lower() not in SUFFIXES:
        raise InputError(f"{name} = {path}: must end in {', '.join(SUFFIXES)}")


@style.styled
def save(figure, path):
    """Write a figure; the file appears under its name when it is complete."""
    with replacing(path) as unfinished:
        figure.savefig(unfinished)


def can_be_shown():
    """Whether there is a display, or a notebook, to show a figure on."""
    try:
        _toolkit()
    except InputError:
        return False
    return True


def _toolkit():
    """Whether windows can be opened; False in a notebook, which shows the figure by itself."""
    interactive = backend_registry.list_builtin(BackendFilter.INTERACTIVE)
    silent = backend_registry.list_builtin(BackendFilter.NON_INTERACTIVE)
    import matplotlib.pyplot as plt

    try:
        plt.switch_backend(matplotlib.get_backend())
    except ImportError as error:
        raise InputError(f"{NO_DISPLAY} ({error})") from None
    backend = matplotlib.get_backend().lower()
    if backend in silent:
        raise InputError(NO_DISPLAY)
    return backend in interactive


def _open_window(figure):
    import matplotlib.pyplot as plt

    plt.figure("beltrepro", FigureClass=lambda *_, **__: figure)
    plt.show()


@style.styled
def draw_run(run):
    """x_N(t) and r up to t over the whole run; below, who slips when at its end."""
    blocks = run.parameters.n_blocks
    height = 5.2 + _ROW * max(0, blocks - _MOST_ROWS)
    figure = style.page(_small_print(run), height)
    length, disorder, slips = figure.subplots(
        3, 1, height_ratios=[2, 1, 1.6 + 0.04 * max(0, blocks - _MOST_ROWS)]
    )
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
    panels.trace(axes, run.time, run.positions[:, -1], ylabel=panels.POSITION)
    axes.set_xlim(begin, end)
    axes.axvspan(begin, begin + run.transient, color=style.GREY, alpha=0.2, linewidth=0)
    words = run.parameters.describe().replace("sigma", "σ")
    if np.isfinite(run.mean_length):
        axes.axhline(run.mean_length, color=style.VERMILION, linewidth=0.8, linestyle="--")
        words += rf":  $r$ = {run.disorder_parameter:.4g},  $\langle x_N \rangle$ = "
        words += f"{run.mean_length:.4g}"
    axes.set_title(words)


def _draw_disorder(axes, run):
    """r of the samples from the transient up to each instant; level if the run is long enough."""
    begin, _ = _span(run)
    later = run.time >= begin + run.transient
    time, length = run.time[later], run.positions[later, -1]
    count = np.arange(1, time.size + 1)
    # about the first one, as a small variance of large numbers has no digits
    offset = length - (length[0] if time.size else 0.0)
    mean = np.cumsum(offset) / count
    variance = np.maximum(np.cumsum(offset**2) / count - mean**2, 0.0)
    axes.plot(time, np.sqrt(variance) / (length - offset + mean), color=style.BLUE, linewidth=0.9)
    if np.isfinite(run.disorder_parameter):
        axes.axhline(run.disorder_parameter, color=style.VERMILION, linewidth=0.8, linestyle="--")
    axes.set(xlabel=panels.TIME, ylabel=r"$r$ up to $t$")
    axes.set_ylim(bottom=0)
    if not time.size:
        panels.note(axes, "no samples after the transient")


def _draw_slips(axes, run):
    begin, end = _span(run)
    left = max(begin, end - _SLIPS_SHOWN)
    for block in range(1, run.parameters.n_blocks + 1):
        slips = [(low, high - low) for low, high in slips_of(run, block) if high > left]
        axes.broken_barh(slips, (block - _BAR / 2, _BAR), color=style.GREEN, linewidth=0)
    axes.set(xlim=(left, end), ylim=(0.4, run.parameters.n_blocks + 0.6))
    axes.set(xlabel=panels.TIME, ylabel="slipping block")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    axes.tick_params(axis="y", right=False)


def slips_of(run, block):
    """When a block slips, pairs (begin, end); cut where the run begins or ends."""
    own = run.events[run.events["block"] == block]
    begins, ends = (own["time"][own["kind"] == kind] for kind in ("slip", "stick"))
    begin, end = _span(run)
    if run.initial_state.directions[block - 1]:
        begins = np.concatenate([[begin], begins])
    if len(begins) > len(ends):
        ends = np.concatenate([ends, [end]])
    return list(zip(begins.tolist(), ends.tolist(), strict=True))


def _small_print(run):
    chain = run.parameters
    begin, end = _span(run)
    first = [f"beltrepro {run.version}", f"method {run.method}", f"dt = {run.time_step:g}"]
    first += [f"t = {begin:g} to {end:g}", f"transient {run.transient:g} (grey)"]
    first += [f"seed {run.seed}", f"replicate {run.replicate}"]
    own = [(each.symbol, getattr(chain, each.name), each.default) for each in LAW]
    law = [f"{symbol} = {value:g}" for symbol, value, default in own if value != default]
    second = "Model units: time 0.0765 s, length 1.4 mm. Dashed: values of the run."
    return "\n".join([", ".join(first + law), second])

"""Parts that several figures share: curves, diagrams, traces, spectra, words on panels."""

import functools
import re
import string
import textwrap
from contextlib import contextmanager
from dataclasses import dataclass, field
from numbers import Real

import numpy as np
from matplotlib.patches import Patch

from beltrepro.base.errors import InputError, NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.drawing import style
from beltrepro.simulation import artists
from beltrepro.simulation.artists import plain_log, power_law  # noqa: F401
from beltrepro.stats import sections, spectra, states

# What the axes of the paper show, in its symbols (model units).
BELT_VELOCITY, NOISE, TIME = "$u$", r"$\sigma$", "$t$"
POSITION, VELOCITY, RELATIVE_VELOCITY = "$x_N$", "$v_N$", "$v_{rN}$"
DISORDER = "$r$"

CHECK = "_check"  # suffix of a scan with some of the points by the other integrator
METHODS = {"event": "exact motion", "verlet": "paper's scheme"}
_SPECTRUM_TO = 2.0  # highest frequency shown: beyond it lies only the smoothness of slips
_COLUMNS = 5000  # of a thinned curve: a page has 1000 pixels
EXCERPT = "excerpt"  # in place of the kind of a dataset
_SHORTAGE = "shortage"  # name of the words on it, in place of arrays


# --- data -----------------------------------------------------------------------------------------


def draws(figures):
    """Decorator of the function that draws the figure of its name: in style, with all its data."""

    def decorated(draw):
        entry = figures[draw.__name__]

        @style.styled
        @functools.wraps(draw)
        def draw_from(data):
            missing = [name for name in entry.uses if name not in data and not name.endswith(CHECK)]
            if missing:
                there = ", ".join(data) or "none"
                raise InputError(f"figure needs the dataset {', '.join(missing)}; given: {there}")
            return draw(data)

        return draw_from

    return decorated


@dataclass(frozen=True)
class Excerpt(Dataset):
    """A dataset that keeps what is drawn of it, or has nothing else."""

    drawn: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)


_REDUCED: dict[str, str] = {}  # modules of what reduces datasets, by name


def reduced(reduce):
    """Decorator of what reduces a large dataset to the few arrays, by name, that a figure draws.

    Its arguments are the dataset, then words and numbers, then what else it reads. What it returns
    is published in place of the dataset, under its name and these words and numbers
    (`report/excerpts.py`).
    """
    name, module = reduce.__name__.strip("_"), reduce.__module__
    if _REDUCED.setdefault(name, module) != module:
        raise ValueError(f"{name} of {module} would be taken for that of {_REDUCED[name]}")

    @functools.wraps(reduce)
    def reduced_to(dataset, *arguments):
        drawn = dataset.drawn if isinstance(dataset, Excerpt) else {}
        place = " ".join([name, *(f"{one}" for one in arguments if isinstance(one, str | Real))])
        if place not in drawn:
            if dataset.attributes.get("kind") == EXCERPT:
                raise InputError(
                    f"{dataset.attributes['dataset']}: its excerpt has no {place!r}; "
                    "this is drawn from the dataset"
                )
            try:
                drawn[place] = reduce(dataset, *arguments)
            except NotEnoughDataError as reason:
                drawn[place] = {_SHORTAGE: np.array(str(reason))}
        if _SHORTAGE in drawn[place]:
            raise NotEnoughDataError(str(drawn[place][_SHORTAGE]))
        return drawn[place]

    return reduced_to


def thinned(x, y):
    """Of a curve of many points its ends, and the least and greatest y in each of many columns."""
    if x.size <= 2 * _COLUMNS:
        return x, y
    column = np.digitize(x, np.linspace(x[0], x[-1], _COLUMNS + 1)[1:-1])
    order = np.lexsort((y, column))
    first = np.flatnonzero(np.diff(column[order], prepend=-1))
    kept = np.unique([*order[first], *order[first - 1], 0, x.size - 1])
    return x[kept], y[kept]


def levels(scan, name):
    """Distinct values of n_blocks, belt_velocity or noise in a scan, rising."""
    return np.unique(scan.arrays[name])


def last_block(series):
    """(time, x_N, v_rN) of a sampled series."""
    arrays = series.arrays
    relative = arrays["velocities"][:, -1] - series.attributes["belt_velocity"]
    return arrays["time"], arrays["positions"][:, -1], relative


# --- which estimates an artist shows --------------------------------------------------------------

SEPARATOR = " :: "


def shows(artist, claim, *names, variant=""):
    """Mark an artist as one that shows these estimates of a claim, for a test that compares them.

    A line or errorbar shows them by its places along one axis, in the order of its points, a span
    by its two ends, a text by the numbers in it. Containers are marked at their first line.
    """
    first = artist[0] if isinstance(artist, tuple | list) else artist
    first.set_gid(SEPARATOR.join((f"{claim}: {variant}" if variant else claim, *names)))


# --- words on a panel -----------------------------------------------------------------------------


def true_minus(text):
    """A text whose negative numbers have the sign of minus in place of a hyphen."""
    return re.sub(r"-(?=\d)", "\N{MINUS SIGN}", text)


def page(height, layout, **how):
    """A page with lettered panels: `layout` is "aa;bc" as of `Figure.subplot_mosaic`."""
    figure = style.page(height)
    places = figure.subplot_mosaic(layout, **how)
    letters(*places.values())
    return figure, list(places.values())


def letters(*panels):
    """A letter above the upper left corner of each panel, in their order."""
    for axes, text in zip(panels, string.ascii_lowercase, strict=False):
        axes.set_title(f"{text}.", loc="left", weight="bold")


def remark(axes, text):
    """What is to be known of a panel, small, above its upper right corner."""
    return axes.set_title(text, loc="right", color="0.35")


def heading(figure, about, names=("n_blocks", "belt_velocity", "noise")):
    """Above a figure what all of it is of: attributes of a dataset."""
    figure.suptitle(", ".join(artists.valued(name, about[name]) for name in names), color="0.35")


def note(axes, text, *, place=(0.5, 0.5), width=24):
    """A remark in the middle of a panel, or at `place` in its coordinates; `width` in letters."""
    look = {"ha": "center", "va": "center", "style": "italic", "color": "0.25", "zorder": 9}
    look["bbox"] = {"boxstyle": "round", "facecolor": "white", "edgecolor": "0.8", "alpha": 0.9}
    words = textwrap.fill(text, width)
    axes.text(*place, words, transform=axes.transAxes, **look).set_in_layout(False)


@contextmanager
def shortage_on(axes, **where):
    """Where an estimator lacks data within this block, the panel says so."""
    try:
        yield
    except NotEnoughDataError as reason:
        note(axes, str(reason), **where)


def legend_above(axes, **changes):
    """Legend over a panel, beside its letter, if anything in the panel has words."""
    if axes.get_legend_handles_labels()[1]:
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 4}
        place |= {"frameon": False, "borderaxespad": 0.1, "borderpad": 0.1}
        axes.legend(**place | changes)


SQUARES = style.BLUE, style.ORANGE


def squares(figure, *words):
    """Squares of two colours, and perhaps an empty one, with their words, above a figure."""
    colours = zip((*SQUARES, "none"), words, strict=False)
    handles = [Patch(facecolor=one, label=label) for one, label in colours]
    figure.legend(handles=handles, loc="outside upper center", ncols=3, handlelength=0.8)


# --- ranges, enlarged parts, spectra --------------------------------------------------------------


def make_room(axes, *, above):
    """Widen the y range, without more ticks, so that the data leave this share of it free."""
    low, high = axes.get_ylim()
    wider = low, high + above * ((high - low) / (1 - above))
    axes.set_ylim(wider)
    axes.set_yticks([tick for tick in axes.get_yticks() if low <= tick <= high])
    axes.set_ylim(wider)


def zoom(axes, inner, time, values, window):
    """Draw a trace within `window` = (begin, end) in `inner`, and shade the window in `axes`."""
    axes.axvspan(*window, color=style.ORANGE, alpha=0.35, linewidth=0, zorder=0)
    inside = (time >= window[0]) & (time <= window[1])
    inner.plot(time[inside], values[inside], color=style.BLUE, linewidth=0.8)
    inner.set_xlim(*window)
    inner.ticklabel_format(axis="x", useOffset=False)
    inner.locator_params(axis="x", nbins=4)
    for spine in inner.spines.values():
        spine.set_color(style.ORANGE)
    inner.set_title("enlarged", color="0.35")


def spectrum(axes, series, shown=np.asarray, *, ylabel=r"$S(\nu)$"):
    """Power spectrum of x_N after the transient, or what a function makes of it."""
    axes.set(xlabel=r"$\nu$", ylabel=ylabel)
    with shortage_on(axes):
        drawn = _spectrum(series)
        frequency, power = drawn["frequency"], shown(drawn["power"])
        artists.spectrum(axes, frequency, power, (drawn["places"], shown(drawn["medians"])))
        axes.set_xlim(frequency[0], min(_SPECTRUM_TO, frequency[-1]))
        axes.set_ylim(shown(drawn["low"]), 5 * power.max())


@reduced
def _spectrum(series):
    """The spectrum, its medians in narrow bins, and the lower end of its axis."""
    time, position, _ = last_block(series)
    chosen = time >= series.attributes["transient"]
    interval = float(np.median(np.diff(time[chosen]))) if chosen.sum() > 1 else np.nan
    frequency, power = spectra.power_spectrum(position[chosen], interval)
    places, medians = artists.medians(frequency, power)
    low = np.quantile(power[frequency <= _SPECTRUM_TO], 0.02)
    logs, power = thinned(np.log(frequency), power)
    curve = {"frequency": np.exp(logs), "power": power}
    return curve | {"places": places, "medians": medians, "low": low}


def printed_slope(axes, law, exponent):
    """A line with the exponent that the paper prints, through the middle of a fitted law."""
    ends = np.array([law.low, law.high])
    middle = np.sqrt(law.low * law.high)
    line = law(middle) * (ends / middle) ** exponent
    label = true_minus(f"paper: {exponent:g}")
    axes.loglog(ends, line, label=label, zorder=5, **style.PAPER)


def beside(axes, place, height, words, *, left=False, **look):
    """Words right or left of a place on the abscissa, at a height in shares of the panel."""
    look |= {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "va": "center"}
    look |= {"xytext": (-3 if left else 3, 0), "ha": "right" if left else "left"}
    return axes.annotate(words, (place, height), annotation_clip=True, **look)


def printed_range(axes, low, high, words, *, left=False):
    """A black strip over what the paper prints as a range of u, with words beside it."""
    axes.axvspan(low, high, 0.92, 0.95, color=style.BLACK, linewidth=0)
    beside(axes, low if left else high, 0.935, words, left=left)


# --- curves and diagrams --------------------------------------------------------------------------


def trace(axes, time, values, *, ylabel):
    """A sampled quantity against time."""
    artists.envelope(axes, time, values, linewidth=0.5)
    if not time.size:
        note(axes, "no samples")
    elif time.size > 1:
        axes.set_xlim(time[0], time[-1])
    axes.set_ylabel(ylabel)


def intervals(axes, place, value, low, high, **look):
    """A mark for each estimate, with its interval as a bar."""
    axes.errorbar(place, value, [value - low, high - value], **look)


def limits(axes, place, low, **look):
    """Arrows up from lower limits, as long as these are large."""
    if len(place):
        axes.errorbar(place, low, low, lolims=True, **look | {"linestyle": "none"})


def intervals_or_limits(axes, place, value, low, high, *, label="", **look):
    """Marks with intervals, and arrows up from the lower limits of what is not known to end."""
    ended = np.isfinite(high)
    if ended.any():
        numbers = (numbers[ended] for numbers in (place, value, low, high))
        intervals(axes, *numbers, label=label, linestyle="none", **look)
    label = "" if ended.any() else label
    look = {name: look[name] for name in look if not name.startswith("mark")}
    limits(axes, place[~ended], low[~ended], label=label, **look)


def finish_curves(axes, *, xlabel, **legend):
    """Axes and legend, above the panel, of r against something; says so when there is none."""
    axes.set(xlabel=xlabel, ylabel=DISORDER)
    if not axes.lines:
        note(axes, "no points in this scan")
        return
    axes.set_ylim(bottom=0)
    legend_above(axes, **legend)


WIDTH = 0.5  # of u, over which runs are taken together, at least
TOGETHER = 8  # velocities, at least


def together(velocities):
    """Middles of the ranges of u over which single runs are taken together as replicates."""
    width = max(WIDTH, TOGETHER * min(np.diff(np.unique(velocities)), default=0.0))
    return width * (np.ceil(velocities / width - 1e-9) - 0.5)


def band(axes, place, values, *, shaded=True, **look):
    """The mean at each place, where shaded over a band of 10 to 90 % of the values, if any."""
    spread = sections.spread(place, values)
    if spread.place.size:
        means = np.interp(place, spread.place, spread.mean)
        kept = np.isfinite(values)
        artists.band(axes, place[kept], np.where(shaded, values, means)[kept], **look)


REPLICATES = "n5_replicates", "size_replicates"
_ROW = 0.26  # height of a bar of `falls`


def independent_falls(table, column, value):
    """Rows of critical_velocities of independent runs that fall, with this value in a column."""
    independent = table["dataset"].isin(REPLICATES) & (table[column] == value)
    return table[independent & table["critical"].notna()]


def falls(axes, rows, column, colour_of, printed, reach=()):
    """Falls of r from 90 to 10 % and their middles by a column, and, black, those printed.

    reach : pairs of a level and the outer ends of the intervals of its fall.
    """
    reach = dict(reach)
    levels = sorted({*rows[column], *printed})
    for place, level in enumerate(levels):
        look = {"color": colour_of(level), "fmt": "o", "markersize": 2.5, "elinewidth": 0.9}
        low, high = reach.get(level, (np.nan, np.nan))
        axes.barh(place, high - low, _ROW, low, color=look["color"], alpha=0.35)
        for row in rows[rows[column] == level].itertuples():
            axes.barh(place, row.upper - row.lower, _ROW, row.lower, color=look["color"])
            bar = np.nan_to_num([[row.critical - row.low], [row.high - row.critical]])
            axes.errorbar(row.critical, place + _ROW, xerr=bar, **look)
        low, high = np.broadcast_to(printed.get(level, np.nan), 2)
        axes.barh(place + 2 * _ROW, high - low, _ROW, low, color=style.BLACK)
        if low == high:  # a printed middle
            look = {"color": style.BLACK, "markerfacecolor": "none", "markersize": 4}
            axes.plot(low, place + 2 * _ROW, "D", **look)
            look = {"textcoords": "offset points", "va": "center", "ha": "right"}
            axes.annotate(f"{low:g}", (low, place + 2 * _ROW), (-5, 0), **look)
    axes.set_yticks(np.arange(len(levels)) + _ROW, [f"{level:g}" for level in levels])
    axes.set(xlabel=BELT_VELOCITY, ylim=(len(levels) - _ROW, -2 * _ROW))
    axes.tick_params(axis="y", length=0)
    words = " (pale: its 95 % interval),\n" if reach else ", "
    remark(axes, f"bar: most runs go over{words}dot: $u_c$, black: paper")


def diagrams(scan, places, *, bar="bottom"):
    """Bifurcation diagrams: the density of v_N at the section at each u, in one scale of colours.

    places : pairs of axes and what is cut out of the scan.  bar : side at which the scale stands.
    """
    edges, maps = scan.arrays["section_bins"], []
    for axes, where in places:
        row = sections.cut(scan, **where)
        counts = row["belt_velocity"], row["section_histogram"]
        velocities, density = sections.density_at(*counts, edges)
        if np.nansum(density):
            across, density = _joined(artists.edges(velocities), density, axes.bbox.width)
            up, density = _joined(edges, density.T, axes.bbox.height)
            maps.append((axes, across, up, density.T))
        else:
            note(axes, "no crossing of the section in this scan")
    words = artists.label("density of $v_N$ at given $u$", "1/velocity")
    look = {"rare": "white", "location": bar, "format": "%g"}
    densities(maps, [axes for axes, _ in places], words, **look)
    for axes, *_ in maps:
        lowest = min(up[np.argmax(np.any(density > 0, axis=1))] for _, _, up, density in maps)
        axes.set_ylim(lowest, 0)
        axes.set_axisbelow(False)


def densities(maps, axes, words, *, rare=None, **bar):
    """Densities (axes, x, y, values) in one scale of colours beside `axes`, `rare` below it."""
    if maps:
        colours = artists.colour_limits(*(values for *_, values in maps))
        colours["cmap"] = artists.SHADES.with_extremes(under=rare)
        meshes = [artists.density(*one, **colours) for one in maps]
        artists.colour_bar(meshes, axes, words, aspect=40, **bar).minorticks_off()


def _joined(edges, values, pixels):
    """Edges and means of cells (.., C), together up to 1.5 pixels: of finer ones some are lost."""
    cells = np.shape(values)[-1]
    first = np.arange(0, cells, max(1, int(np.ceil(1.5 * cells / pixels))))
    weight = np.diff(edges) * np.isfinite(values)
    sums = np.add.reduceat(np.nan_to_num(values) * weight, first, axis=-1)
    with np.errstate(invalid="ignore"):
        return np.append(edges[first], edges[-1]), sums / np.add.reduceat(weight, first, axis=-1)


def section_name(row):
    """The section of a row in words: "section x_N = 615"; empty for an empty row."""
    positions = np.unique(row["section_position"])
    return f"section $x_N = {positions[0]:g}$" if positions.size else ""


# --- independent runs: a dot each, means where there is one branch -------------------------------

# Runs at a point lie on one branch if the largest value is at most this multiple of the least: the
# branches of r differ by factors of three and more.
ONE_BRANCH = 1.5


def draw_runs(axes, abscissa, values, index, *, label=None, apart=ONE_BRANCH, **changes):
    """A small mark for each run; a line of their means where they lie on one branch.

    apart : largest ratio of the values of one branch; infinite for what always has a mean, 0 for
    what never has.
    """
    spread = sections.spread(abscissa, values)
    if not spread.place.size:
        return
    look = style.line_style(index) | {"markersize": 2.6, "markeredgewidth": 0.3} | changes
    measured = np.isfinite(values)
    dots = {"markersize": 1.5, "markeredgewidth": 0, "zorder": 1.5, "alpha": 0.7}
    dots |= {name: look[name] for name in ("color", "marker")}
    place, value = np.asarray(abscissa)[measured], np.asarray(values)[measured]
    axes.plot(place, value, linestyle="none", **dots)
    joined = spread.mean
    if np.isfinite(apart):
        joined = np.where(spread.high <= apart * spread.low, joined, np.nan)
    axes.plot(spread.place, joined, label=label, **look)


def against_noise(axes, scan, places, *, ncols=3):
    """r against noise from columns of a scan: the mean of all runs over a band of 10 to 90 %.

    Without noise each run has a mark, since they end on several attractors.

    places : dict, look and label by (n_blocks, belt_velocity).
    """
    for (n_blocks, velocity), look in places.items():
        column = sections.cut(scan, n_blocks=n_blocks, belt_velocity=velocity)
        noise, disorder = column["noise"], column["disorder_parameter"]
        band(axes, noise[noise > 0], disorder[noise > 0], **look)
        marks = {"facecolor": "none", "edgecolor": look["color"], "linewidth": 0.6, "zorder": 3}
        axes.scatter(noise[noise == 0], disorder[noise == 0], 7, clip_on=False, **marks)
    finish_curves(axes, xlabel=NOISE, ncols=ncols, handlelength=2)
    axes.set_xlim(left=0)


# --- traces with their laminar phases -------------------------------------------------------------


@reduced
def _half_laminar(series, laminar_time, length):
    """x_N(t) in the part of this length, after the transient, nearest to half laminar.

    The earliest of several: of a run that has one motion only, the first. With all laminar phases.
    """
    start, stop = (float(series.attributes[name]) for name in ("transient", "duration"))
    begins = np.arange(start, max(stop - length, start) + 1e-6, length / 10)
    laminar = states.laminar_phases(series, laminar_time)
    first = begins[:, np.newaxis, np.newaxis]
    share = np.diff(np.clip(laminar, first, first + length), axis=2).sum(axis=(1, 2)) / length
    begin = float(begins[np.argmin(np.abs(share - 0.5).round(9))])
    time, position, _ = last_block(series)
    shown = (time >= begin) & (time <= begin + length)
    time, position = thinned(time[shown] - begin, position[shown])
    return {"begin": begin, "time": time, "position": position, "laminar": laminar}


def laminar_trace(axes, series, laminar_time, length):
    """x_N(t) where it is most nearly half laminar; laminar phases are shaded, in the title counted.

    The axis has the time since then.
    """
    drawn = _half_laminar(series, laminar_time, length)
    trace(axes, drawn["time"], drawn["position"], ylabel=POSITION)
    for begin, end in np.clip(drawn["laminar"] - drawn["begin"], 0, length):
        if end > begin:
            axes.axvspan(begin, end, color=style.ORANGE, alpha=0.3, linewidth=0, zorder=0)
    laminar, about = drawn["laminar"], series.attributes
    length = about["duration"] - about["transient"]
    share = np.diff(laminar, axis=1).sum() / length if length else 0.0
    many = "1 laminar phase" if len(laminar) == 1 else f"{len(laminar)} laminar phases"
    many = f"in all {many}, {100 * share:.0f} %"
    remark(axes, f"$u = {about['belt_velocity']:g}$; {many}")

"""Figs. 8 to 10: slips and avalanches at small belt velocity."""

import numpy as np

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.avalanches import measure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.simulation import artists
from beltrepro.simulation.observables import STUCK, avalanche_energies, slip_sizes
from beltrepro.stats.densities import Density, density
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.power_law import PowerLawFit
from beltrepro.stats.spectra import FIT_BAND, power_spectrum

FIGURES = {
    "fig08": Figure(uses=("u1",), number="8", shows={"spectrum-exponent": ("exponent",)}),
    "fig09": Figure(
        uses=("slips_u1",),
        number="9",
        shows={"slip-size-exponent": ("exponent",), "slip-energy-exponent": ("exponent",)},
    ),
    "fig10": Figure(uses=("section_u1", "section_u1_event"), number="10"),
    "avalanches": Figure(
        uses=("slips_n3", "slips_u1", "slips_n7", "slips_n10"),
        category="Further studies",
        shows={"soc-cutoff": ("energy: growth with N",)},
    ),
}


# --- Fig. 8: the last block at low belt velocity, without noise -----------------------------------

SHOWN = 3000.0  # last part of the series that is drawn
ZOOM = 30.0  # length of the enlarged part, around the fastest slip
_ROOM = 100_000  # factor by which the axis of the spectrum is longer, for the legend


@panels.draws(FIGURES)
def fig08(data):
    """a: x_N(t); b: v_rN(t); c: the spectrum of the whole series; d: the fastest slip of b."""
    series = data["u1"]
    last = _last_part(series)
    time, relative = last["time"], last["relative"]
    figure, (upper, lower, spectrum, enlarged) = panels.page(
        4.05, "aa;bb;cd", height_ratios=(1, 1, 1.9), width_ratios=(1.8, 1)
    )
    panels.trace(upper, time, last["position"], ylabel=panels.POSITION)
    panels.spectrum(spectrum, series, measure.as_amplitude, ylabel=r"amplitude $A(\nu)$")
    with panels.shortage_on(spectrum):
        _law(spectrum, series)
    panels.trace(lower, time, relative, ylabel=panels.RELATIVE_VELOCITY)
    lower.set_xlabel(panels.TIME)
    enlarged.set(xlabel=panels.TIME, ylabel=panels.RELATIVE_VELOCITY)
    middle = time[np.argmin(relative)]
    panels.zoom(lower, enlarged, time, relative, (middle - ZOOM / 2, middle + ZOOM / 2))
    enlarged.locator_params(axis="x", nbins=2)
    panels.heading(figure, series.attributes)
    return figure


@panels.reduced
def _last_part(series):
    """The last block in the last part of a series."""
    time, position, relative = panels.last_block(series)
    shown = time >= time[-1] - SHOWN
    time = time[shown] - time[shown][0]
    return {"time": time, "position": position[shown], "relative": relative[shown]}


@panels.reduced
def _fit(series):
    """The power law of the mean spectrum of the stretches of a series, and means in narrow bins."""
    fit = measure.spectral_law(series, amplitude=True).judged
    time, position, _ = panels.last_block(series)
    chosen = time >= series.attributes["transient"]
    frequency, power = power_spectrum(position[chosen], float(np.median(np.diff(time))))
    bins = np.floor(10 * np.log10(frequency))
    bins[(frequency < FIT_BAND[0]) | (frequency > FIT_BAND[1])] = np.nan
    inside = np.unique(bins)[:-1]  # without the NaN of those outside
    means = measure.as_amplitude([power[bins == one].mean() for one in inside])
    numbers = {name: estimate.value for name, estimate in fit.items()}
    return numbers | {"places": 10 ** ((inside + 0.5) / 10), "means": means}


def _law(axes, series):
    """The fitted power law, beside the printed one, over the means that it is fitted to."""
    look = {"color": style.GREEN, "markersize": 3.5, "markerfacecolor": "none", "label": "means"}
    axes.plot(*(_fit(series)[name] for name in ("places", "means")), "o", **look)
    for numbers, words, look in (
        (_fit(series), "fit: ", {}),
        (printed("spectrum-exponent"), "paper: ", style.PAPER),
    ):
        law = PowerLawFit(numbers["exponent"], numbers["prefactor"], *FIT_BAND)
        label = rf"{words}${law.prefactor:.2g}\,\nu^{{{law.exponent:.2f}}}$"
        panels.power_law(axes, law, label=label, **look)
    axes.set_ylim(bottom=axes.get_ylim()[0] / _ROOM)
    *_, ours, _ = axes.legend(loc="lower left").get_texts()
    panels.shows(ours, "spectrum-exponent", "exponent")


# --- Fig. 9: sizes and energies of avalanches -----------------------------------------------------


FINE, COARSE = 40, 5  # bins a decade of the densities in grey and in blue
LOCAL = 9  # of these, neighbours whose slope is a local exponent
LEAST_IN_BIN = 5  # values, for a local exponent


@panels.draws(FIGURES)
def fig09(data):
    """Densities of a: slip sizes, b: energies of avalanches; c, d: their local exponents."""
    figure, grid = panels.page(4.05, "ab;cd", height_ratios=(1.7, 1))
    for (above, below), claim, symbol, what in (
        (grid[::2], "slip-size-exponent", r"\Delta x_s", "slips"),
        (grid[1::2], "slip-energy-exponent", r"\Delta E", "avalanches"),
    ):
        below.sharex(above)
        above.set(xscale="log", yscale="log", ylabel=f"$P({symbol})$")
        below.set(xlabel=f"${symbol}$", ylabel="local exponent")
        panels.remark(below, "a power law\nwould be level")
        try:
            _densities(above, below, data["slips_u1"], what, claim)
        except NotEnoughDataError as reason:
            for axes in (above, below):
                panels.note(axes, str(reason))
    entries = grid[0].get_legend_handles_labels()  # a line of each width of bins, and laws between
    figure.legend(*(entry[::3] for entry in entries), loc="outside upper center", ncols=2)
    return figure


_SAMPLES = {
    "slips": slip_sizes,
    "avalanches": avalanche_energies,
    "all avalanches": measure.all_energies,
}


@panels.reduced
def _binned(dataset, what, bins):
    """The density of a sample from a catalogue."""
    return vars(density(_SAMPLES[what](measure.catalogue_of(dataset)), bins))


def _densities(axes, below, dataset, what, claim):
    """Density of a sample in fine and in coarse bins, with a law through these and the paper's."""
    fine, coarse = (Density(**_binned(dataset, what, bins)) for bins in (FINE, COARSE))
    panels.remark(axes, f"{fine.count.sum()} {what}")
    height = np.where(fine.count > 0, fine.density, np.nan)
    look = {"color": "0.6", "linewidth": 0.7, "label": f"{FINE} bins a decade"}
    axes.plot(fine.centre, height, drawstyle="steps-mid", **look)
    look = {"color": style.BLUE, "markersize": 2.5, "label": f"{COARSE} bins a decade"}
    _density(axes, coarse, fmt="o", **look)
    law = coarse.law()
    label = f"here: ${law.exponent.value:.2f}$"
    panels.power_law(axes, law, zorder=4, label=label)
    panels.printed_slope(axes, law, printed(claim))
    panels.plain_log(axes.xaxis, subs=(1, 2, 5) if fine.centre[0] < 1000 else (1, 3))
    axes.tick_params(labelbottom=False)
    entries = axes.get_legend_handles_labels()
    ours, _ = axes.legend(*(laws[1:3] for laws in entries), loc="lower left").get_texts()
    panels.shows(ours, claim, "exponent")
    place, slope = measure.local_exponents(fine, LOCAL, LEAST_IN_BIN)
    below.plot(place, slope, color="0.4", linewidth=0.8)
    below.axhline(printed(claim), **style.PAPER)
    look = {"textcoords": "offset points", "ha": "right"}
    below.annotate(
        "paper", (1, printed(claim)), (-2, 2), xycoords=("axes fraction", "data"), **look
    )


def _density(axes, binned, **look):
    """Density with the standard errors that its chains tell."""
    filled = binned.count > 0
    height, error = binned.density[filled], np.nan_to_num(binned.error[filled])
    # where one chain alone fills a bin both are equal, and the bar must not end just above zero
    error = np.where(np.isclose(error, height, atol=0), height, error)
    axes.errorbar(binned.centre[filled], height, error, **look)


# --- Fig. 10: natural distribution on a Poincaré section ------------------------------------------

MAGNIFIED = (560.0, 600.0)  # x_N, as in the paper


@panels.draws(FIGURES)
def fig10(data):
    """Density of section points with v_rN < 0 in the plane (x_N, v_rN); c: a part of a, larger."""
    figure, (scheme, exact, magnified) = panels.page(4.05, "ab;cc", height_ratios=(1, 0.9))
    maps = []
    for axes, name, part in (
        (scheme, "section_u1", ()),
        (exact, "section_u1_event", ()),
        (magnified, "section_u1", MAGNIFIED),
    ):
        about = data[name].attributes
        axes.set_xlabel(f"{panels.POSITION} at {_place(about)}")
        with panels.shortage_on(axes, width=16):
            cells = _cells(data[name], *part)
            edges = cells["position"], cells["relative"]
            area = np.outer(*(np.diff(edge) for edge in reversed(edges)))
            maps.append((axes, *edges, cells["count"] / (cells["points"] * area)))
            if not part:
                words = f"{panels.METHODS[about['method']]},\n{cells['points']} points"
                panels.remark(axes, words)
    words = f"density of ({panels.POSITION}, {panels.RELATIVE_VELOCITY}) (model units)"
    panels.densities(maps, [scheme, exact, magnified], words, location="bottom")
    exact.sharex(scheme)
    exact.sharey(scheme)
    scheme.set_ylabel(panels.RELATIVE_VELOCITY)
    magnified.set_ylabel(panels.RELATIVE_VELOCITY)
    scheme.axvspan(*MAGNIFIED, fill=False, linewidth=0.8, linestyle="--")
    panels.heading(figure, about)
    return figure


@panels.reduced
def _cells(dataset, low=-np.inf, high=np.inf):
    """Points at which the last block slips, counted in cells of the plane (x_N, v_rN)."""
    points, velocity = dataset.arrays["crossings"], dataset.attributes["belt_velocity"]
    position, relative = points["position"], points["velocity"] - velocity
    slipping = relative < -STUCK
    chosen = slipping & (position > low) & (position < high)
    require(chosen.any(), "no section point at which the last block slips")
    *edges, count = artists.cells(position[chosen], relative[chosen])
    cells = {"count": count.astype(np.uint32), "position": edges[0], "relative": edges[1]}
    return cells | {"points": slipping.sum()}


def _place(about):
    return f"$x_{{{about['section_block']}}} = {about['section_position']:g}$"


# --- Not in the paper: avalanches of chains of several lengths ------------------------------------

BINS_PER_DECADE = 8
LEAST_FITTED = 5  # blocks


@panels.draws(FIGURES)
def avalanches(data):
    """a: density of the dissipated energy for each N; b: its cutoff; c: a, scaled by this."""
    figure, (left, right, scaled) = panels.page(4.05, "aa;bc", height_ratios=(1.3, 1))
    left.set(xlabel=r"$\Delta E$", ylabel=r"$P(\Delta E)$", xscale="log", yscale="log")
    right.set(xlabel="$N$", ylabel=r"$\Delta E$", xscale="log", yscale="log")
    catalogues = (data[name] for name in FIGURES["avalanches"].uses)
    by_size = {one.attributes["n_blocks"]: one for one in catalogues}
    densities = {}
    with panels.shortage_on(left):
        for index, (n_blocks, dataset) in enumerate(by_size.items()):
            binned = Density(**_binned(dataset, "all avalanches", BINS_PER_DECADE))
            label = f"$N = {n_blocks}$, {binned.count.sum()} avalanches"
            look = style.line_style(index) | style.look_of_size(n_blocks)
            look |= {"linewidth": 0.9, "markersize": 3, "elinewidth": 0.8}
            _density(left, binned, label=label, **look)
            densities[n_blocks] = binned
        left.legend(loc="lower left")
    scaled.set(xlabel=r"$\Delta E / N^p$", ylabel=r"$N^p P(\Delta E)$", xscale="log", yscale="log")
    try:
        _scaled(scaled, densities, _cutoffs(right, by_size))
    except NotEnoughDataError as reason:
        for axes in (right, scaled):
            panels.note(axes, str(reason), width=14)
    return figure


def _scaled(axes, densities, power):
    """Densities of the chains whose cutoffs are fitted, over energies in units of N^power."""
    for n_blocks in (n for n in densities if n >= LEAST_FITTED):
        binned, unit = densities[n_blocks], float(n_blocks) ** power
        height = np.where(binned.count > 0, unit * binned.density, np.nan)
        look = style.look_of_size(n_blocks) | {"markersize": 2, "linewidth": 0.7}
        axes.plot(binned.centre / unit, height, **look)


@panels.reduced
def _cutoff(dataset):
    """The cutoff of the energies of a catalogue as its logarithm, and the largest energy."""
    sample = measure.all_energies(measure.catalogue_of(dataset))
    return {"log": np.array(measure.log_cutoff(sample).numbers), "largest": sample.values.max()}


def _cutoffs(axes, by_size):
    """Cutoffs and their power of N, which is returned; without N = 3, whose motion is another."""
    ends = {n: _cutoff(dataset) for n, dataset in by_size.items()}
    logs = {n: Estimate(*end["log"]) for n, end in ends.items()}
    n_blocks, cutoffs, _ = measure.growth(logs)
    growth = measure.growth({n: log for n, log in logs.items() if n >= LEAST_FITTED})
    numbers = np.transpose([estimate.numbers for estimate in cutoffs])
    label = f"{measure.CUTOFF_QUANTILE:.0%} quantile"
    panels.intervals(axes, n_blocks, *numbers, fmt="o", color=style.BLUE, label=label)
    axes.plot(
        n_blocks, [end["largest"] for end in ends.values()], "^", color=style.GREY, label="largest"
    )
    look = {"color": style.VERMILION, "label": rf"$\propto N^{{{growth.power.value:.2f}}}$"}
    axes.plot(growth.n_blocks, growth.line(), **look)
    axes.set_xticks(n_blocks, [f"{n:g}" for n in n_blocks])
    axes.minorticks_off()
    panels.plain_log(axes.yaxis)
    axes.set_ylim(bottom=axes.get_ylim()[0] / 5)  # room for the legend
    for text in axes.legend(loc="lower right").get_texts():
        if "propto" in text.get_text():
            panels.shows(text, "soc-cutoff", "energy: growth with N")
    return growth.power.value

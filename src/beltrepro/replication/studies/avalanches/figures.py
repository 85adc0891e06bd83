"""Figs. 8 to 10: slips and avalanches at small belt velocity."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.avalanches import measure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.simulation import artists
from beltrepro.stats import sections
from beltrepro.stats.power_law import PowerLawFit
from beltrepro.stats.spectra import FIT_BAND

FIGURES = {
    "fig08": Figure(uses=("u1",), number="8", shows={"spectrum-exponent": ("exponent",)}),
    "fig09": Figure(
        uses=("slips_u1",),
        number="9",
        shows={"slip-size-exponent": ("exponent",), "slip-energy-exponent": ("exponent",)},
    ),
    "fig10": Figure(uses=("slips_u1", "slips_u1_event"), number="10"),
    "avalanches": Figure(
        uses=("slips_n3", "slips_u1", "slips_n7", "slips_n10"),
        category="Further studies",
        shows={"soc-cutoff": ("energy: growth with N",)},
    ),
}


# --- Fig. 8: the last block at low belt velocity, without noise -----------------------------------

SHOWN = 3000.0  # last part of the series that is drawn
ZOOM = 30.0  # length of the enlarged part, around the fastest slip
_ROOM = 5000  # factor by which the axis of the spectrum is longer, for the legend
_DASHED = {"linestyle": "--", "color": style.BLACK, "linewidth": 1.0}


@panels.draws(FIGURES)
def fig08(data):
    """a: x_N(t); b: v_rN(t); c: the spectrum of the whole series; d: the fastest slip of b."""
    series = data["u1"]
    time, position, relative = panels.last_block(series)
    shown = time >= time[-1] - SHOWN
    time, position, relative = time[shown], position[shown], relative[shown]
    figure, (upper, lower, spectrum, enlarged) = panels.page(
        4.2, "aa;bb;cd", height_ratios=(1, 1, 1.4)
    )
    panels.trace(upper, time, position, ylabel=panels.POSITION)
    panels.spectrum(spectrum, series, measure.as_amplitude, ylabel=r"amplitude $A(\nu)$")
    with panels.shortage_on(spectrum):
        _law(spectrum, series)
    panels.trace(lower, time, relative, ylabel=panels.RELATIVE_VELOCITY)
    lower.set_xlabel(panels.TIME)
    enlarged.set(xlabel=panels.TIME, ylabel=panels.RELATIVE_VELOCITY)
    middle = time[np.argmin(relative)]
    panels.zoom(lower, enlarged, time, relative, (middle - ZOOM / 2, middle + ZOOM / 2))
    return figure


def _law(axes, series):
    """The power law of the mean spectrum of its stretches, beside the printed one."""
    fit = measure.spectral_law(series, amplitude=True).judged
    ours = {name: estimate.value for name, estimate in fit.items()}
    for numbers, words, look in (
        (ours, "fit: ", {}),
        (printed("spectrum-exponent"), "paper: ", _DASHED),
    ):
        law = PowerLawFit(numbers["exponent"], numbers["prefactor"], *FIT_BAND)
        label = rf"{words}${law.prefactor:.2g}\,\nu^{{{law.exponent:.2f}}}$"
        panels.power_law(axes, law, label=label, **look)
    axes.set_ylim(bottom=axes.get_ylim()[0] / _ROOM)
    first, *_ = axes.legend(loc="lower left").get_texts()
    panels.shows(first, "spectrum-exponent", "exponent")


# --- Fig. 9: sizes and energies of avalanches -----------------------------------------------------


@panels.draws(FIGURES)
def fig09(data):
    """a: density of the slip sizes of the last block; b: of the energy dissipated in avalanches."""
    catalogue = data["slips_u1"]
    sizes, energies = measure.slip_sizes(catalogue), measure.avalanche_energies(catalogue)
    of_last = measure.last_block_energies(catalogue)
    in_belt = measure.slip_sizes(catalogue, "belt")
    figure, (left, right) = panels.page(4.4, "a;b")
    words = f"laboratory frame, {of_last.values.size} slips"
    _densities(left, (sizes, words), (in_belt, "frame of the belt"), "slip-size-exponent")
    left.set(xlabel=r"$\Delta x_s$", ylabel=r"$P(\Delta x_s)$")
    words = f"whole chain, {energies.values.size} avalanches"
    _densities(right, (energies, words), (of_last, "last block only"), "slip-energy-exponent")
    right.set(xlabel=r"$\Delta E$", ylabel=r"$P(\Delta E)$")
    return figure


def _densities(axes, first, other, claim):
    """Density of a sample with its power law, that of the paper, and another reading of it."""
    look = {"fmt": "o", "color": style.BLUE, "elinewidth": 0.9, "zorder": 3}
    pale = {"color": style.SKY, "markerfacecolor": "none", "markersize": 3.5, "zorder": 1}
    with panels.shortage_on(axes, place=(0.68, 0.66)):
        sample, label = first
        _density(axes, measure.Histogram.of(sample), label=label, **look)
        law, exponent = measure.density_law(sample)
        words = rf"$\alpha = {exponent.value:.2f}$"
        panels.power_law(axes, law, linewidth=1.8, zorder=2, label=words)
        panels.printed_slope(axes, law, printed(claim))
    with panels.shortage_on(axes, place=(0.68, 0.66)):
        sample, label = other
        histogram = measure.Histogram.of(sample)
        filled = histogram.count > 0
        axes.loglog(histogram.centre[filled], histogram.density[filled], "s", label=label, **pale)
    axes.set(xscale="log", yscale="log")
    if axes.lines:
        panels.plain_log(axes.xaxis)
        low, high = axes.get_ylim()
        axes.set_ylim(low, high * (high / low) ** 0.25)
        for text in axes.legend(loc="upper right").get_texts():
            if "alpha" in text.get_text():
                panels.shows(text, claim, "exponent")


def _density(axes, histogram, **look):
    """Density with the standard errors that its chains tell."""
    filled = histogram.count > 0
    density, error = histogram.density[filled], np.nan_to_num(histogram.error[filled])
    # where one chain alone fills a bin both are equal, and the bar must not end just above zero
    error = np.where(np.isclose(error, density, atol=0), density, error)
    axes.errorbar(histogram.centre[filled], density, error, **look)


# --- Fig. 10: natural distribution on a Poincaré section ------------------------------------------

STUCK = 1e-6  # a block slower than this relative to the belt is stuck
DENSITY_FROM = 20_000  # points: fewer are drawn one by one
BINS = (240, 240)


@panels.draws(FIGURES)
def fig10(data):
    """Section points with v_rN < 0 in the plane (x_N, v_rN): a density where there are many."""
    figure, grid = panels.page(2.6, "ab", sharex=True, sharey=True)
    for axes, name in zip(grid, FIGURES["fig10"].uses, strict=True):
        _section(axes, data[name])
    grid[0].set_ylabel(panels.RELATIVE_VELOCITY)
    return figure


def _section(axes, catalogue):
    about, points = catalogue.attributes, catalogue.arrays["section"]
    position = points["positions"][:, -1]
    relative = points["velocities"][:, -1] - about["belt_velocity"]
    again = sections.repeated(np.hstack([points["positions"], points["velocities"]]))
    slipping = relative < -STUCK
    new, old = slipping & ~again, slipping & again
    size = float(np.clip(160 / np.sqrt(max(slipping.sum(), 1)), 1.5, 5))
    look = {"markersize": size, "markeredgewidth": 0, "rasterized": True}
    if old.any():
        axes.plot(position[old], relative[old], ".", color=style.ORANGE, **look)
    if not new.any():
        panels.note(axes, "no section point at which the last block slips")
    elif new.sum() < DENSITY_FROM:
        axes.plot(position[new], relative[new], ".", color=style.BLUE, **look)
        axes.margins(0.02)
    else:
        share, *edges = np.histogram2d(position[new], relative[new], BINS, density=True)
        mesh = artists.density(axes, *edges, share.T)
        words = "density (per model length and velocity)"
        artists.colour_bar([mesh], axes, words, location="bottom")
    place = f"$x_{{{about['section_block']}}} = {about['section_position']:g}$"
    axes.set_xlabel(f"{panels.POSITION} at {place}")
    runs = f"{panels.METHODS[about['method']]}, {np.unique(points['point']).size} runs"
    panels.remark(axes, f"{runs}:\n{new.sum()} of {slipping.sum()} points are new")


# --- Not in the paper: avalanches of chains of several lengths ------------------------------------

BINS_PER_DECADE = 8
LEAST_FITTED = 5  # blocks


@panels.draws(FIGURES)
def avalanches(data):
    """a: density of the dissipated energy for each N; b: its cutoff against N."""
    figure, (left, right) = panels.page(4.2, "a;b", height_ratios=(1.3, 1))
    left.set(xlabel=r"$\Delta E$", ylabel=r"$P(\Delta E)$", xscale="log", yscale="log")
    right.set(xlabel="$N$", ylabel=r"$\Delta E$", xscale="log", yscale="log")
    catalogues = [data[name] for name in FIGURES["avalanches"].uses]
    samples = {int(one.attributes["n_blocks"]): measure.all_energies(one) for one in catalogues}
    with panels.shortage_on(left):
        for index, (n_blocks, sample) in enumerate(samples.items()):
            label = f"$N = {n_blocks}$, {sample.values.size} avalanches"
            look = style.line_style(index) | {"linewidth": 0.9, "markersize": 3, "elinewidth": 0.8}
            _density(left, measure.Histogram.of(sample, BINS_PER_DECADE), label=label, **look)
        left.legend(loc="lower left")
    with panels.shortage_on(right):
        _cutoffs(right, samples)
    return figure


def _cutoffs(axes, samples):
    """With N = 3, whose motion is another, the law is not fitted."""
    n_blocks, cutoffs, _ = measure.growth(samples)
    growth = measure.growth({n: sample for n, sample in samples.items() if n >= LEAST_FITTED})
    numbers = np.transpose([estimate.numbers for estimate in cutoffs])
    label = f"{measure.CUTOFF_QUANTILE:.0%} quantile"
    panels.intervals(axes, n_blocks, *numbers, fmt="o", color=style.BLUE, label=label)
    largest = [sample.values.max() for sample in samples.values()]
    axes.plot(n_blocks, largest, "^", color=style.GREY, label="largest")
    look = {"color": style.VERMILION, "label": rf"$\propto N^{{{growth.power.value:.2f}}}$"}
    axes.plot(growth.n_blocks, growth.line(), **look)
    axes.set_xticks(n_blocks, [f"{n:g}" for n in n_blocks])
    axes.minorticks_off()
    panels.plain_log(axes.yaxis)
    for text in axes.legend(loc="upper left").get_texts():
        if "propto" in text.get_text():
            panels.shows(text, "soc-cutoff", "energy: growth with N")

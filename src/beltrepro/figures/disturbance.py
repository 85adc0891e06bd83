"""Not in the paper: what small disturbances of each slip, as by a time step, do to the motion."""

import numpy as np

from beltrepro.analysis.growth import finite_size_exponents
from beltrepro.analysis.shares import shares
from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry
from beltrepro.model.disturbance import equivalent_kick

ENTRY = Entry(
    title="What the time step does: growth by size, and periodic motion under disturbance.",
    uses=("growth", "steps", "kicked", "weak_noise"),
    words=(
        "Not in the paper. (a) Rate at which the distance of two runs grows, against the distance: "
        "dots by the exact motion (event), crosses by the paper's scheme (verlet), whose runs do "
        "not separate from small distances. (b) Share of the runs that are not on a periodic orbit "
        "at the end, against the disturbance of each slip: dots with lines for random kicks of the "
        "exact motion, squares for the scheme, whose disturbance is u dt divided by the square "
        "root of 3. Bars are standard errors. (c) r at the end of these runs, means. (d) The same "
        "for noise, whose disturbance is sigma, at two or more time steps, over the line of "
        "the kicks."
    ),
    alt=(
        "Four panels: rates of growth against the distance of two runs, shares of irregular runs "
        "and r against the disturbance of each slip, and r against weak noise."
    ),
    category="Further studies",
)

_FEWEST = 5  # passages that a rate of growth rests on
_SKIPPED = 1  # levels of a twin in which it turns to the direction that grows
_DISTURBANCE = "disturbance of a slip"


@style.styled
def draw(data, caption):
    """Growth by size; irregular runs and r against the disturbance; r against weak noise."""
    panels.require(data, ENTRY)
    figure = style.page(caption, 5.6)
    growth, share, disorder, noise = figure.subplots(2, 2).flat
    _draw_growth(growth, data["growth"])
    steps, kicked = data["steps"].arrays, data["kicked"].arrays
    scheme = equivalent_kick(steps["belt_velocity"], steps["time_step"])
    for index, velocity in enumerate(np.unique(kicked["belt_velocity"])):
        _draw_runs(share, disorder, kicked, kicked["kick"], velocity, index, line=True)
        _draw_runs(share, disorder, steps, scheme, velocity, index, line=False)
    _draw_noise(noise, data["weak_noise"].arrays, kicked)
    for axes, name in zip((growth, share, disorder, noise), "abcd", strict=True):
        axes.set_xscale("log")
        panels.letter(axes, name)
    share.set(xlabel=_DISTURBANCE, ylabel="share of irregular runs", ylim=(-0.05, 1.05))
    disorder.set(xlabel=_DISTURBANCE, ylabel=panels.DISORDER)
    noise.set(xlabel=panels.NOISE, ylabel=panels.DISORDER)
    share.legend(loc="upper left")
    return figure


def _draw_growth(axes, dataset):
    """Finite-size exponents of each number of blocks by each method."""
    arrays = dataset.arrays
    observed = dataset.attributes["duration"] - dataset.attributes["transient"]
    levels = arrays["levels"]
    for index, n_blocks in enumerate(np.unique(arrays["n_blocks"])):
        for method, marker in (("event", "o"), ("verlet", "x")):
            own = (arrays["n_blocks"] == n_blocks) & (arrays["method"].astype(str) == method)
            if not own.any():
                continue
            times = arrays["passage_time"][own].reshape(-1, len(levels))
            found = finite_size_exponents(levels, times, observed, skipped=_SKIPPED)
            known = (found.passed >= _FEWEST) & np.isfinite(found.exponent)
            axes.errorbar(
                found.size[known],
                found.exponent[known],
                found.standard_error[known],
                fmt=marker,
                color=style.COLOURS[index],
                markersize=3.5,
                elinewidth=0.6,
                label=f"$N = {n_blocks}$, {method}",
            )
    axes.set(xlabel="distance of two runs", ylabel="rate of growth", yscale="log")
    axes.set_xlim(levels[0], levels[-1])
    axes.legend(loc="upper left")


def _draw_runs(share, disorder, arrays, disturbance, velocity, index, *, line):
    """Irregular runs and r at one belt velocity; a line for kicks, squares for the scheme."""
    own = arrays["belt_velocity"] == velocity
    if not own.any():
        return
    found = shares(disturbance[own], arrays["state"][own].astype(str) == "irregular")
    label = f"$u = {velocity:g}$" if line else None
    shown = found.value > 0
    look = {"color": style.COLOURS[index], "elinewidth": 0.6, "markersize": 3.5}
    look |= {"fmt": "o-", "linewidth": 0.8} if line else {"fmt": "s", "markerfacecolor": "none"}
    error = np.array([found.share - found.low, found.high - found.share])
    share.errorbar(found.value[shown], found.share[shown], error[:, shown], label=label, **look)
    mean, spread = _means(disturbance[own], arrays["disorder_parameter"][own])
    disorder.errorbar(found.value[shown], mean[shown], spread[shown], **look)


def _draw_noise(axes, arrays, kicked):
    """r against sigma at several time steps, with that against kicks."""
    for index, velocity in enumerate(np.unique(arrays["belt_velocity"])):
        own = kicked["belt_velocity"] == velocity
        colour = (
            style.COLOURS[np.flatnonzero(np.unique(kicked["belt_velocity"]) == velocity)[0]]
            if own.any()
            else style.COLOURS[index]
        )
        if own.any():
            mean, _ = _means(kicked["kick"][own], kicked["disorder_parameter"][own])
            value = np.unique(kicked["kick"][own])
            axes.plot(value[value > 0], mean[value > 0], color=colour, linewidth=0.8)
        for number, step in enumerate(np.unique(arrays["time_step"])):
            own = (arrays["belt_velocity"] == velocity) & (arrays["time_step"] == step)
            mean, error = _means(arrays["noise"][own], arrays["disorder_parameter"][own])
            value = np.unique(arrays["noise"][own])
            axes.errorbar(
                value[value > 0],
                mean[value > 0],
                error[value > 0],
                fmt=style.MARKERS[number + 2],
                color=colour,
                markersize=3.5,
                elinewidth=0.6,
                label=f"$u = {velocity:g}$, $dt = {step:g}$",
            )
    axes.legend(loc="upper left")


def _means(values, measured):
    """Mean of what was measured at each distinct value, and its standard error."""
    groups = [measured[values == value] for value in np.unique(values)]
    means = np.array([group.mean() for group in groups])
    errors = [group.std(ddof=1) / np.sqrt(len(group)) if len(group) > 1 else 0 for group in groups]
    return means, np.array(errors)

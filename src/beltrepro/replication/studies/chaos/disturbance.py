"""Not in the paper: what small disturbances of each slip, as by a time step, do to the motion."""

import numpy as np

from beltrepro.model.scheme_error import equivalent_kick
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.stats.estimates import share
from beltrepro.stats.growth import finite_size_exponents

FIGURE = Figure(
    title="What the time step does: growth by size, and periodic motion under disturbance.",
    uses=("growth", "steps", "kicked", "weak_noise"),
    words=(
        "Not in the paper. a: rate at which the distance of two runs grows, against the distance: "
        "dots by the exact motion, crosses by the paper's scheme; triangles are upper limits where "
        "no run went further, empty for the scheme. b: share of the runs that are not on a "
        "periodic orbit at the end, against the disturbance of each slip: dots with lines for "
        "random kicks of the exact motion, squares for the scheme, whose disturbance is u dt "
        "divided by the square root of 3. Bars are 95 % intervals. c: r at the end of these runs, "
        "means with their errors. d: the same for noise, whose disturbance is sigma, at two or "
        "more time steps, over the line of the kicks. Colours in b to d are those above b."
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
_METHODS = {"event": "exact", "verlet": "scheme"}


@style.styled
def draw(data):
    """Growth by size; irregular runs and r against the disturbance; r against weak noise."""
    panels.require(data, FIGURE)
    figure = style.page(6.6)
    growth, share, disorder, noise = figure.subplots(4, 1)
    steps, kicked, noisy = (data[name].arrays for name in ("steps", "kicked", "weak_noise"))
    _draw_growth(growth, data["growth"])
    velocities = np.unique(np.concatenate([kicked["belt_velocity"], noisy["belt_velocity"]]))
    scheme = equivalent_kick(steps["belt_velocity"], steps["time_step"])
    for velocity, colour in zip(velocities, style.COLOURS, strict=False):
        for arrays, disturbance, look in (
            (kicked, kicked["kick"], {"fmt": "o-", "linewidth": 0.8}),
            (steps, scheme, {"fmt": "s", "markerfacecolor": "none"}),
        ):
            look |= {"color": colour, "elinewidth": 0.6, "markersize": 3.5}
            runs = (arrays["belt_velocity"] == velocity) & (disturbance > 0)
            irregular = arrays["state"][runs].astype(str) == "irregular"
            _draw_shares(share, disturbance[runs], irregular, **look)
            _draw_means(disorder, disturbance[runs], arrays["disorder_parameter"][runs], **look)
        share.plot([], [], color=colour, linewidth=2, label=f"$u = {velocity:g}$")
        _draw_noise(noise, noisy, kicked, velocity, colour)
    _name_marks(disorder, {"o": "kicks", "s": "time step of the scheme"})
    steps = np.unique(noisy["time_step"])
    marks = zip(style.MARKERS[2:], steps, strict=False)
    _name_marks(noise, {marker: f"$dt = {panels.power(step)}$" for marker, step in marks})
    _finish(growth, share, disorder, noise)
    return figure


def _finish(growth, share, disorder, noise):
    for axes, name in zip((growth, share, disorder, noise), "abcd", strict=True):
        axes.set_xscale("log")
        panels.letter(axes, name)
    share.set(xlabel=_DISTURBANCE, ylabel="share of irregular runs", ylim=(-0.05, 1.05))
    disorder.set(xlabel=_DISTURBANCE, ylabel=panels.DISORDER)
    noise.set(xlabel=panels.NOISE, ylabel=panels.DISORDER)
    for axes in (disorder, noise):
        axes.set_xlim(share.get_xlim())
    for axes in (growth, share, disorder, noise):
        if not axes.has_data():
            panels.note(axes, "no runs")
        panels.legend_above(axes, ncols=2 if axes is growth else 5)


def _name_marks(axes, words):
    """What the marks of a panel stand for, whatever their colour."""
    for marker, label in words.items():
        look = {"color": style.GREY, "markerfacecolor": "none" if marker == "s" else None}
        axes.plot([], [], marker, markersize=3.5, label=label, **look)


def _draw_growth(axes, dataset):
    """Finite-size exponents of each number of blocks by each method."""
    arrays = dataset.arrays
    observed = dataset.attributes["duration"] - dataset.attributes["transient"]
    levels = arrays["levels"]
    for index, n_blocks in enumerate(np.unique(arrays["n_blocks"])):
        for method, marker in zip(_METHODS, "ox", strict=True):
            runs = (arrays["n_blocks"] == n_blocks) & (arrays["method"].astype(str) == method)
            if not runs.any():
                continue
            times = arrays["passage_time"][runs].reshape(-1, len(levels))
            look = {"color": style.COLOURS[index], "markersize": 3.5}
            label = f"$N = {n_blocks}$, {_METHODS[method]}"
            _draw_rates(axes, levels, times, observed, fmt=marker, label=label, **look)
            none = finite_size_exponents(levels, times, observed)
            still = none.passed == 0
            look |= {"linestyle": "none", "markerfacecolor": "none" if marker == "x" else None}
            axes.plot(none.size[still], none.limit[still], marker="v", **look)
    axes.set(xlabel="distance of two runs", ylabel="rate of growth", yscale="log")
    axes.set_xlim(levels[0], levels[-1])


def _draw_rates(axes, levels, times, observed, **look):
    """Finite-size exponents with their errors."""
    growth = finite_size_exponents(levels, times, observed, skipped=_SKIPPED)
    measured = (growth.passed >= _FEWEST) & np.isfinite(growth.exponent)
    columns = growth.size, growth.exponent, growth.standard_error
    values = (column[measured] for column in columns)
    axes.errorbar(*values, elinewidth=0.6, **look)


def _draw_shares(axes, disturbance, having, **look):
    """Share of runs with a property at each disturbance."""
    levels = np.unique(disturbance)
    runs_at_level = [having[disturbance == level] for level in levels]
    numbers = [share(run.sum(), run.size).numbers for run in runs_at_level]
    value, lower, upper = np.reshape(numbers, (-1, 3)).T
    if value.size:
        axes.errorbar(levels, value, [value - lower, upper - value], **look)


def _draw_means(axes, values, measured, **look):
    """Mean of what was measured at each distinct value, with its standard error."""
    distinct = np.unique(values)
    groups = [measured[values == value] for value in distinct]
    errors = [group.std(ddof=1) / np.sqrt(len(group)) if len(group) > 1 else 0 for group in groups]
    if groups:
        axes.errorbar(distinct, [group.mean() for group in groups], errors, **look)


def _draw_noise(axes, noisy, kicked, velocity, colour):
    """r against sigma at several time steps, over the line of r against kicks."""
    runs = (kicked["belt_velocity"] == velocity) & (kicked["kick"] > 0)
    look = {"color": colour, "elinewidth": 0.6, "markersize": 3.5}
    near = noisy["belt_velocity"] == velocity
    if not near.any():
        return
    _draw_means(
        axes, kicked["kick"][runs], kicked["disorder_parameter"][runs], fmt="-", color=colour
    )
    for step, marker in zip(np.unique(noisy["time_step"]), style.MARKERS[2:], strict=False):
        runs = near & (noisy["time_step"] == step)
        measured = noisy["disorder_parameter"][runs]
        _draw_means(axes, noisy["noise"][runs], measured, fmt=marker, **look)

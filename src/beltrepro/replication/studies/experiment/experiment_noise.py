"""Not in the paper: what trials of its length say about the recordings of the experiment."""

import numpy as np
from matplotlib.colors import LinearSegmentedColormap

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.experiment import measure, observations
from beltrepro.stats import estimates

FIGURE = Figure(uses=("experiment_odds", "alternation", "trials_free"), category="Further studies")

_LINES = 4  # most friction ratios shown as lines
_SHADE = LinearSegmentedColormap.from_list("posterior", ["#ffffff", style.SKY, style.BLUE])
_COLOURS = (style.BLUE, style.VERMILION)
_FREE = {
    ("friction_ratio",): "$f_s$ free",
    ("speed_factor",): "speed free",
    ("friction_ratio", "speed_factor"): "both free",
}


@style.styled
def draw(data):
    """Top: r against noise, alternation against u; bottom: posteriors."""
    panels.require(data, FIGURE)
    figure = style.page(5.6)
    (disorder, alternating), (plane, noise) = figure.subplots(2, 2)
    _draw_disorder(disorder, data["experiment_odds"])
    _draw_alternation(alternating, data["alternation"])
    with panels.shortage_on(plane):
        _draw_plane(plane, observations.on_grid(data["trials_free"].arrays))
    with panels.shortage_on(noise):
        _draw_noise(noise, observations.on_grid(data["trials_free"].arrays))
    for axes, name in zip((disorder, alternating, plane, noise), "abcd", strict=True):
        panels.letter(axes, name)
    return figure


# --- trials with the printed constants ------------------------------------------------------------


def _draw_disorder(axes, odds):
    """r at each noise, a colour for each speed; the printed r as lines."""
    axes.set(xlabel=panels.NOISE, ylabel=panels.DISORDER, ylim=(0, 0.16))
    rows = odds[(odds["dataset"] == "trials") & odds["noise"].notna()]
    if rows.empty:
        panels.note(axes, "no trials")
        return
    axes.set_xscale("log")
    panels.plain_log(axes.xaxis)
    for (speed, at_speed), colour, shift in zip(
        rows.groupby("speed_m_s"), _COLOURS, (0.96, 1.04), strict=False
    ):
        place, look = at_speed["noise"] * shift, {"color": colour, "markersize": 4}
        middle = {"fmt": "o", "elinewidth": 1.2, "label": f"{speed:g} m/s"}
        axes.errorbar(place, at_speed["r"], _reaches(at_speed, "r"), **middle, **look)
        axes.plot(place, at_speed["r_least"], "v", markerfacecolor="none", **look)
        axes.axhline(at_speed["r_recorded"].iloc[0], color=colour, linestyle="--", linewidth=1.2)
    axes.legend(loc="lower left", ncols=2, handlelength=1.0, title="lines: experiment")


def _draw_alternation(axes, table):
    """Share of alternating trials of all noises against u, a line for each friction ratio."""
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel="share with both regimes", ylim=(-0.03, 1.03))
    if table.empty:
        panels.note(axes, "no trials with free constants")
        return
    counts = table.groupby(["friction_ratio", "belt_velocity"])[["alternating", "runs"]].sum()
    for index, ratio in enumerate(_shown(table["friction_ratio"].unique())):
        velocity, rows = counts.loc[ratio].index, counts.loc[ratio].to_numpy()
        middle, low, high = np.transpose([estimates.share(*row).numbers for row in rows])
        look = style.line_style(index) | {"label": f"{ratio:g}", "markersize": 3}
        bars = np.abs([low - middle, high - middle])
        axes.errorbar(velocity, middle, bars, linewidth=0.9, elinewidth=0.7, **look)
    for observation, colour in zip(observations.EXPERIMENT, _COLOURS, strict=True):
        axes.axvline(observation.belt_velocity, color=colour, linestyle="--", linewidth=1.2)
    axes.legend(loc="lower right", title="$f_s$", handlelength=1.8)


def _shown(ratios):
    """The printed friction ratio and the larger ones, at most some, evenly spread."""
    larger = np.sort(ratios[ratios > observations.FRICTION_RATIO - 1e-9])
    return larger[np.unique(np.linspace(0, larger.size - 1, _LINES).round().astype(int))]


def _reaches(rows, name):
    """Lengths of error bars (2, R)."""
    ends = rows[[f"{name}_lower", f"{name}_upper"]].to_numpy().T
    return np.abs(ends - rows[name].to_numpy())


# --- posteriors -----------------------------------------------------------------------------------


def _draw_plane(axes, simulated):
    """Posterior of friction ratio and factor on the speed, whatever the noise."""
    axes.set(xlabel="friction ratio $f_s$", ylabel="factor on the belt speed")
    axes.plot(
        *measure.PRINTED.values(), "x", color=style.VERMILION, markersize=8, markeredgewidth=2
    )
    answer = measure.posterior(simulated)
    ratio, factor = (answer.levels[name] for name in measure.PRINTED)
    probability = answer.marginal(*measure.PRINTED)
    axes.pcolormesh(_edges(ratio), _edges(factor), probability.T, cmap=_SHADE, vmin=0)
    if min(ratio.size, factor.size) > 1:
        _draw_before(axes, ratio, factor)


def _draw_before(axes, ratio, factor):
    """Contours that hold 68 and 95 % of what is probable before the trials."""
    errors = observations.ERRORS
    angle = np.linspace(0, 2 * np.pi, 200)
    for held in (0.68, 0.95):
        radius = np.sqrt(-2 * np.log(1 - held))
        place = observations.FRICTION_RATIO + radius * errors["friction_ratio"] * np.cos(angle)
        height = np.exp(radius * errors["speed_factor"] * np.sin(angle))
        axes.plot(place, height, color="0.6", linewidth=0.8)
    axes.set(xlim=_edges(ratio)[[0, -1]], ylim=_edges(factor)[[0, -1]])


def _draw_noise(axes, simulated):
    """Posterior of the noise, a line for each choice of free parameters."""
    axes.set(xlabel=panels.NOISE, ylabel="probability")
    axes.set_xscale("log")
    axes.axvspan(*observations.ASSIGNED, color="0.9", zorder=0)
    levels = simulated.levels["noise"]
    axes.plot(levels, np.full(levels.size, 1 / levels.size), color="0.5", linewidth=1.5)
    missing = []
    for index, (free, words) in enumerate(_FREE.items()):
        try:
            answer = measure.posterior(measure.fixed_but(simulated, free))
        except NotEnoughDataError:
            missing.append(words)
            continue
        axes.plot(levels, answer.marginal("noise"), label=words, **style.line_style(index))
    axes.set_ylim(0, 1.3 * axes.dataLim.y1)  # room for the legend
    panels.plain_log(axes.xaxis)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc="upper right")
    if missing:
        panels.remark(axes, f"{', '.join(missing)}: too few agree")


def _edges(levels):
    """Edges of cells about levels."""
    if levels.size == 1:
        return np.array([0.95, 1.05]) * levels
    middle = (levels[1:] + levels[:-1]) / 2
    return np.concatenate([[2 * levels[0] - middle[0]], middle, [2 * levels[-1] - middle[-1]]])

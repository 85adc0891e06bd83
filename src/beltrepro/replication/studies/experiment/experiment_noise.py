"""Not in the paper: what trials of its length say about the recordings of the experiment."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.experiment import observations
from beltrepro.stats import estimates

FIGURE = Figure(uses=("experiment_odds", "alternation"), category="Further studies")

_LINES = 4  # most friction ratios shown as lines
_COLOURS = (style.BLUE, style.VERMILION)


@style.styled
def draw(data):
    """a: r against noise; b: alternation against u."""
    panels.require(data, FIGURE)
    figure = style.page(2.8)
    disorder, alternating = figure.subplots(1, 2)
    _draw_disorder(disorder, data["experiment_odds"])
    _draw_alternation(alternating, data["alternation"])
    panels.letters(disorder, alternating)
    return figure


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

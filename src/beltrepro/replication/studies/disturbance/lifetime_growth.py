"""Not in the paper: lifetime and exponent of irregular motion against N."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(
    title="Lifetime and largest exponent of irregular motion against the number of blocks.",
    uses=("lifetime_growth",),
    words=(
        "Not in the paper. a: mean lifetime of irregular motion without noise at four belt "
        "velocities, with 95 % intervals; an arrow begins at the lower limit where no run ended. "
        "b: largest exponent of the irregular motion, with standard errors. Marks are moved aside "
        "a little. What to see: a block more lengthens irregular motion by a factor, until runs "
        "are too short to see it end, and the exponent is clear of zero from six blocks on."
    ),
    alt=(
        "Two panels: the mean lifetime of irregular motion rises steeply with the number of "
        "blocks, on a logarithmic scale, and the largest exponent rises from zero."
    ),
    category="Further studies",
)

_VELOCITIES = (10, 20, 30, 40)
_ASIDE = 0.12  # by which the marks of one velocity lie beside those of the next


@style.styled
def draw(data):
    """Left: mean lifetimes; right: exponents."""
    panels.require(data, FIGURE)
    figure = style.page(1.95)
    lifetimes, exponents = figure.subplots(1, 2)
    table = data["lifetime_growth"]
    for index, velocity in enumerate(_VELOCITIES):
        points = table[table["belt_velocity"] == velocity]
        place = points["n_blocks"] + (index - 1.5) * _ASIDE
        look = style.line_style(index) | {"linestyle": "none", "markersize": 2.4}
        look |= {"elinewidth": 0.5, "label": f"$u = {velocity}$"}
        _draw_lifetimes(lifetimes, place, points, look)
        _draw_exponents(exponents, place, points, look)
    if table.empty:
        panels.note(lifetimes, "no runs in this table")
        panels.note(exponents, "no runs in this table")
    lifetimes.set(xlabel="$N$", ylabel="mean lifetime", yscale="log")
    lifetimes.minorticks_off()
    lifetimes.set_yticks([100, 1e4, 1e6], ["100", "10,000", "1,000,000"])
    exponents.set(xlabel="$N$", ylabel="largest exponent")
    exponents.axhline(0, color="0.6", linewidth=0.8, zorder=0)
    exponents.legend(loc="upper left", handletextpad=0.1, borderaxespad=0.1)
    for axes, name in ((lifetimes, "a"), (exponents, "b")):
        axes.set_xticks([4, 6, 8, 10, 12])
        panels.letter(axes, name)
    return figure


def _draw_lifetimes(axes, place, points, look):
    ended = (points["ended"] > 0).to_numpy()
    mean, low, high = (
        points[name].to_numpy() for name in ("lifetime", "lifetime_low", "lifetime_high")
    )
    bars = [mean[ended] - low[ended], high[ended] - mean[ended]]
    axes.errorbar(place[ended], mean[ended], bars, **look)
    look = look | {"marker": "_", "label": None, "lolims": True}
    axes.errorbar(place[~ended], low[~ended], 2 * low[~ended], **look)


def _draw_exponents(axes, place, points, look):
    some = np.isfinite(points["exponent"].to_numpy())
    bars = points["exponent_error"].to_numpy()[some]
    axes.errorbar(place[some], points["exponent"].to_numpy()[some], bars, **look)

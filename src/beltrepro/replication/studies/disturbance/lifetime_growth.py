"""Not in the paper: lifetime and exponent of irregular motion against N."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(uses=("lifetime_growth",), category="Further studies")

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
        points = points.assign(place=points["n_blocks"] + (index - 1.5) * _ASIDE)
        look = style.line_style(index) | {"linestyle": "none", "markersize": 2.4}
        look |= {"elinewidth": 0.5, "label": f"$u = {velocity}$"}
        ended, lasting = points[points["ended"] > 0], points[points["ended"] == 0]
        mean = (ended[f"lifetime{end}"] for end in ("", "_low", "_high"))
        panels.intervals(lifetimes, ended["place"], *mean, **look)
        limit = lasting["place"], lasting["lifetime_low"]
        panels.limits(lifetimes, *limit, length=2.0, **look | {"marker": "_", "label": None})
        measured = points[np.isfinite(points["exponent"])]
        values = (measured[name] for name in ("place", "exponent", "exponent_error"))
        exponents.errorbar(*values, **look)
    if table.empty:
        for axes in (lifetimes, exponents):
            panels.note(axes, "no runs in this table")
    lifetimes.set(xlabel="$N$", ylabel="mean lifetime", yscale="log")
    lifetimes.minorticks_off()
    lifetimes.set_yticks([100, 1e4, 1e6], ["100", "10,000", "1,000,000"])
    exponents.set(xlabel="$N$", ylabel="largest exponent")
    exponents.axhline(0, color="0.6", linewidth=0.8, zorder=0)
    exponents.legend(loc="upper left", handletextpad=0.1, borderaxespad=0.1)
    panels.letters(lifetimes, exponents)
    for axes in (lifetimes, exponents):
        axes.set_xticks([4, 6, 8, 10, 12])
    return figure

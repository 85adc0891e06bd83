"""Not in the paper: where r falls without noise, for linear springs and stiffening ones."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(uses=("scaled_falls",), category="Further studies")

_SPRINGS = {"linear": "linear springs", "exponential": "stiffening springs"}
_ASIDE = 0.008  # by which marks of one friction ratio lie beside each other
_TOP = 0.92  # the largest velocity that was run


@style.styled
def draw(data):
    """Scaled velocities of the fall against f_s."""
    panels.require(data, FIGURE)
    figure = style.page(2.2)
    axes = figure.subplots()
    table = data["scaled_falls"]
    for index, (springs, words) in enumerate(_SPRINGS.items()):
        rows = table[table["springs"] == springs]
        look = style.line_style(index) | {"linestyle": "none", "elinewidth": 0.6}
        look |= {"markersize": 3, "label": words}
        aside = (2 * index - 1) * _ASIDE
        _draw_marks(axes, rows, "begin", aside, look)
        if rows["critical"].notna().any():
            look = look | {"markerfacecolor": "white", "label": f"{words}, middle"}
            _draw_marks(axes, rows, "critical", aside + _ASIDE, look)
        _draw_arrows(axes, rows[rows[["begin", "critical"]].isna().all(axis=1)], aside, look)
    if table.empty:
        panels.note(axes, "no runs in this table")
    axes.axvline(0.45, color="0.7", linewidth=0.8, zorder=0)
    axes.set(xlim=(0, 1), ylim=(0, 1.05), xlabel="$f_s$")
    axes.set_ylabel(r"$u\,/\,[(1 - f_s)\,F_{\mathrm{st}}]$")
    panels.legend_above(axes, ncols=3)
    return figure


def _draw_marks(axes, rows, name, aside, look):
    rows = rows[rows[name].notna()]
    value, low, high = (rows[f"{name}{end}"] for end in ("", "_low", "_high"))
    place = rows["friction_ratio"] + aside
    panels.intervals(axes, place, value, low, np.minimum(high, _TOP), **look)


def _draw_arrows(axes, rows, aside, look):
    look = look | {"marker": "_", "label": None, "lolims": True}
    axes.errorbar(rows["friction_ratio"] + aside, np.full(len(rows), _TOP), 0.05, **look)

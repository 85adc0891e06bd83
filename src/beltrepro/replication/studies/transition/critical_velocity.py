"""Not in the paper as a figure: the critical velocity against noise and number of blocks."""

import numpy as np

from beltrepro.replication.drawing import marks, panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.verdicts.ledger import printed

FIGURE = Figure(
    uses=(
        "critical_velocities",
        "n5_replicates",
        "n5_replicates_check",
        "n5_replicates_wide",
        "size_replicates",
    ),
    category="Further studies",
    shows={
        "uc-of-sigma: exact dynamics": ("u_c(?)", "u_c(?.?)"),
        "u-critical": ("critical",),
        "u-critical: wider starts": ("critical",),
    },
)

N_BLOCKS = 5
NOISES = (0.0, 1.0)  # shown in b
LOOKS = {
    "n5_replicates": ("exact motion", style.BLUE, "o", 0.0),
    "n5_replicates_check": ("scheme of the paper", style.VERMILION, "s", 0.08),
    "n5_replicates_wide": ("scheme, wide starts", style.ORANGE, "^", 0.16),
}
# The claim, its variant and the names of its estimates that have the same numbers.
CLAIMS = {
    "n5_replicates": ("uc-of-sigma", "exact dynamics", "u_c({:g})"),
    "n5_replicates_check": ("u-critical", "", "critical"),
    "n5_replicates_wide": ("u-critical", "wider starts", "critical"),
}


@style.styled
def draw(data):
    """a: u_c against sigma for five blocks; b: u_c and the region against N for each noise."""
    panels.require(data, FIGURE)
    table = data["critical_velocities"]
    figure = style.page(4.4)
    left, right = figure.subplots(2, 1)
    panels.letter(left, "a")
    panels.letter(right, "b")
    left.set(xlabel=panels.NOISE, ylabel="$u_c$")
    right.set(xlabel="$N$", ylabel="$u_c$")
    _against_noise(left, table[table["n_blocks"] == N_BLOCKS])
    _against_size(right, table[table["dataset"].isin(["n5_replicates", "size_replicates"])])
    for axes in (left, right):
        panels.legend_above(axes, ncols=2)
        if table["critical"].isna().all():
            panels.note(axes, "r(u) falls nowhere, or has too few points")
    return figure


def _against_noise(axes, table):
    for name, (label, colour, marker, shift) in LOOKS.items():
        rows = table[table["dataset"] == name]
        points = _points(axes, rows["noise"] + shift, rows, label, color=colour, marker=marker)
        if points:
            claim, variant, names = CLAIMS[name]
            noises = rows["noise"][rows["critical"].notna()]
            shown = [names.format(noise) for noise in noises]
            marks.shown(points, claim, *shown, variant=variant)
    values = printed("u-critical"), printed("uc-sigma22")["u_c"]
    axes.plot((0.0, 2.2), values, "x", color=style.BLACK, markersize=7, label="paper")
    _say_none(axes, table[table["dataset"] == "n5_replicates"], "noise", r"$\sigma$")


def _against_size(axes, table):
    for index, noise in enumerate(NOISES):
        rows = table[table["noise"] == noise].sort_values("n_blocks")
        place = rows["n_blocks"] + 0.18 * (index - 0.5)
        look = {"color": style.COLOURS[index], "marker": style.MARKERS[index]}
        _points(axes, place, rows, rf"$\sigma = {noise:g}$", **look)
    for n_blocks, region in ((int(n), ends) for n, ends in printed("transition-width").items()):
        label = "paper, region" if n_blocks == N_BLOCKS else None
        axes.plot([n_blocks + 0.3] * 2, region, "_-", color=style.BLACK, linewidth=0.9, label=label)
    _say_none(axes, table[table["noise"].isin(NOISES)], "n_blocks", "$N$")


def _points(axes, place, rows, label, **look):
    """Critical velocities with their intervals, over the transition regions."""
    has_fall = rows["critical"].notna()
    if not has_fall.any():
        return
    place, rows = place[has_fall], rows[has_fall]
    axes.vlines(place, rows["lower"], rows["upper"], color=look["color"], alpha=0.25, linewidth=4)
    how = {"linestyle": "none", "markersize": 4, "elinewidth": 1.0, "capsize": 2}
    reach = np.nan_to_num([rows["critical"] - rows["low"], rows["high"] - rows["critical"]])
    return axes.errorbar(place, rows["critical"], reach, label=label, **how, **look)


def _say_none(axes, rows, quantity, symbol):
    """Words for the values of a quantity at which r falls nowhere."""
    values = [value for value, same in rows.groupby(quantity) if same["critical"].isna().all()]
    if values:
        words = ", ".join(f"{value:g}" for value in values)
        place = {"transform": axes.transAxes, "ha": "left", "va": "top"}
        axes.text(0.02, 0.97, f"no fall by half at {symbol} = {words}", **place)

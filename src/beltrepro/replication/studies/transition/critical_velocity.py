"""Not in the paper as a figure: the critical velocity against noise and number of blocks."""

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(
    title="Critical belt velocity against noise and number of blocks, over replicates.",
    uses=(
        "critical_velocities",
        "n5_replicates",
        "n5_replicates_check",
        "n5_replicates_wide",
        "size_replicates",
    ),
    words=(
        "The paper prints critical velocities at two noises, and transition regions for three "
        "numbers of blocks. a: the belt velocity in the middle of the fall of r, five blocks, from "
        "all replicates together. Error bars: one standard error, by drawing replicates anew; pale "
        "bars: the transition region. Without noise also by the paper's scheme, from starts of two "
        "spreads. b: against the number of blocks. Where words stand instead, r of the "
        "replicates falls by less than a factor of two, and there is no such velocity."
    ),
    alt=(
        "Two panels of the critical velocity with error bars, against noise and against the number "
        "of blocks, with the values of the paper as crosses and as lines."
    ),
    category="Further studies",
)

N_BLOCKS = 5
PRINTED = {0.0: 16.5, 2.2: 19.0}  # Sec. IV.A and IV.B: sigma and u_c
NOISES = (0.0, 1.0)  # shown in b
REGIONS = {5: (15, 18), 7: (23, 32), 10: (27, 40)}  # caption of Fig. 19, sigma = 1
LOOKS = {
    "n5_replicates": ("exact motion", style.BLUE, "o", 0.0),
    "n5_replicates_check": ("scheme of the paper", style.VERMILION, "s", 0.08),
    "n5_replicates_wide": ("the same, wide starts", style.ORANGE, "^", 0.16),
}


@style.styled
def draw(data, caption):
    """a: u_c against sigma for five blocks; b: u_c and the region against N for each noise."""
    panels.require(data, FIGURE)
    table = data["critical_velocities"]
    figure = style.page(caption, 3.8)
    left, right = figure.subplots(1, 2)
    panels.letter(left, "a")
    panels.letter(right, "b")
    left.set(xlabel=panels.NOISE, ylabel="$u_c$")
    right.set(xlabel="$N$", ylabel="$u_c$")
    _against_noise(left, table[table["n_blocks"] == N_BLOCKS])
    _against_size(right, table[table["dataset"].isin(["n5_replicates", "size_replicates"])])
    for axes in (left, right):
        panels.legend_within(axes, fontsize=7)
        if table["critical"].isna().all():
            panels.note(axes, "r(u) falls nowhere, or has too few points")
    return figure


def _against_noise(axes, table):
    for name, (label, colour, marker, shift) in LOOKS.items():
        rows = table[table["dataset"] == name]
        _points(axes, rows["noise"] + shift, rows, label, color=colour, marker=marker)
    values = list(PRINTED), list(PRINTED.values())
    axes.plot(*values, "x", color=style.BLACK, markersize=7, label="paper")
    _say_none(axes, table[table["dataset"] == "n5_replicates"], "noise", r"$\sigma$")


def _against_size(axes, table):
    for index, noise in enumerate(NOISES):
        rows = table[table["noise"] == noise].sort_values("n_blocks")
        place = rows["n_blocks"] + 0.18 * (index - 0.5)
        look = {"color": style.COLOURS[index], "marker": style.MARKERS[index]}
        _points(axes, place, rows, rf"$\sigma = {noise:g}$", **look)
    for n_blocks, region in REGIONS.items():
        label = "paper, region" if n_blocks == N_BLOCKS else None
        axes.plot([n_blocks + 0.3] * 2, region, "_-", color=style.BLACK, linewidth=0.9, label=label)
    _say_none(axes, table[table["noise"].isin(NOISES)], "n_blocks", "$N$")


def _points(axes, place, rows, label, **look):
    """Critical velocities with their errors, over the transition regions."""
    found = rows["critical"].notna()
    if not found.any():
        return
    place, rows = place[found], rows[found]
    axes.vlines(place, rows["lower"], rows["upper"], color=look["color"], alpha=0.25, linewidth=4)
    how = {"linestyle": "none", "markersize": 4, "elinewidth": 1.0, "capsize": 2}
    axes.errorbar(place, rows["critical"], rows["error"].fillna(0), label=label, **how, **look)


def _say_none(axes, rows, quantity, symbol):
    """Words for the values of a quantity at which r falls nowhere."""
    values = [value for value, same in rows.groupby(quantity) if same["critical"].isna().all()]
    if values:
        words = ", ".join(f"{value:g}" for value in values)
        panels.remark(axes, f"no fall by half at {symbol} = {words}")

"""Figs. 11 and 12: a transient, and the transition without noise."""

from contextlib import suppress

import numpy as np

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.transition import measure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.replication.verdicts.motions import N_BLOCKS
from beltrepro.simulation import artists
from beltrepro.stats import sections

FIGURES = {
    "fig11": Figure(uses=("u20", "u20_slips", "lifetimes"), number="11"),
    "fig12": Figure(
        uses=(
            "n5_density",
            "n5_rows_check",
            "n5_replicates_check",
            "lifetimes_wide",
            "survival",
        ),
        number="12",
        shows={"u-critical": ("critical", "lower", "upper")},
    ),
    "critical_velocity": Figure(uses=("critical_velocities",), category="Further studies"),
}


# --- Fig. 11: a chaotic transient and what follows it ---------------------------------------------

ZOOM = 60.0  # length of the enlarged part, at the end
AFTER = 0.6  # share of the transient's length that is drawn after it


@panels.draws(FIGURES)
def fig11(data):
    """a, b: x_N and v_rN of a run that ends as printed; c: x_N from rest; d: end of a; e: ends."""
    figure, (above, relative, rest, enlarged, ends) = panels.page(
        4.05, "aa;bb;cc;de", height_ratios=(1, 0.8, 1, 1.1)
    )
    slips = _transient(data["u20_slips"], "last stick")
    last_stick, last = slips["end"], slips["enlarged"][0, -1]
    _envelope(above, slips["x_N"], last_stick, panels.POSITION)
    _envelope(relative, slips["v_rN"], last_stick, panels.RELATIVE_VELOCITY)
    panels.zoom(above, enlarged, *slips["enlarged"], (last - ZOOM, last))
    enlarged.set(xlabel=panels.TIME, ylabel=panels.POSITION)
    spread = data["u20_slips"].attributes["initial_spread"]
    panels.remark(above, f"start moved by {spread:g}: last stick at $t$ = {last_stick:.0f}")
    panels.legend_above(relative)
    above.text(0.98, 0.8, "sticks no more", transform=above.transAxes, ha="right")

    series = data["u20"]
    settles = _transient(series, "orbit")
    end, period = settles["end"], settles["period"]
    _envelope(rest, settles["x_N"], end, panels.POSITION)
    rest.set_xlabel(panels.TIME)
    is_orbit = np.isfinite(period)
    words = f"period {period:.1f} from $t$ = {end:.0f} on" if is_orbit else "no period found"
    panels.remark(rest, f"start at rest: {words}")
    _ends(ends, data["lifetimes"], float(series.attributes["belt_velocity"]))
    panels.heading(figure, series.attributes)
    return figure


@panels.reduced
def _transient(series, until):
    """x_N(t) and v_rN(t) up to some time after their transient ends, and the end of x_N(t) whole.

    until : "orbit", if the motion comes to rest on one, or "last stick".
    """
    time, position, velocity = panels.last_block(series)
    stuck = time[np.abs(velocity) < 1e-9]
    end, period = (float(stuck[-1]) if stuck.size else 0.0), np.nan
    if until == "orbit":
        states = series.arrays["positions"], series.arrays["velocities"]
        end, period = measure.settled_orbit(time, *states) or (end, period)
    shown = time <= (1 + AFTER) * end + ZOOM
    time, position, velocity = time[shown], position[shown], velocity[shown]
    last = time >= time[-1] - ZOOM
    curves = {"x_N": panels.thinned(time, position), "v_rN": panels.thinned(time, velocity)}
    curves["enlarged"] = time[last], position[last]
    return {name: np.array(curve) for name, curve in curves.items()} | {
        "end": end,
        "period": period,
    }


def _envelope(axes, curve, end, label):
    """A trace with the end of its transient, here and in the paper."""
    artists.envelope(axes, *curve)
    axes.axvline(end, **style.HERE, label="end here")
    paper = printed("u20-transient")
    axes.axvline(paper, **style.PAPER, label="paper")
    look = {"xycoords": ("data", "axes fraction"), "annotation_clip": True}
    axes.annotate("\N{BLACK DOWN-POINTING TRIANGLE}", (paper, 1), ha="center", va="center", **look)
    axes.set(xlim=(0, curve[0, -1]), ylabel=label)


def _ends(axes, scan, velocity):
    """The share of starts whose last block slips for good, over the time of its last stick."""
    arrays, duration = scan.arrays, float(scan.attributes["duration"])
    at_velocity = np.isclose(arrays["belt_velocity"], velocity)
    axes.set(xlabel="last stick (time)", ylabel="share", xlim=(0, duration), ylim=(0, 1))
    if not at_velocity.any():
        panels.note(axes, "no run at this velocity", width=12)
        return
    ended = np.sort(arrays["lifetime"][at_velocity & arrays["escaped"].astype(bool)])
    share = np.arange(1, ended.size + 1) / at_velocity.sum()
    steps = [0, *ended, duration], [0, *share, *share[-1:], *[0.0] * (not share.size)]
    axes.step(*steps, where="post", color=style.BLUE)
    axes.axvline(printed("u20-transient"), **style.PAPER)
    panels.remark(axes, f"{ended.size} of {at_velocity.sum()} starts\nend in lasting slip")


# --- Fig. 12: the transition without noise --------------------------------------------------------

SPREAD = 10.0  # of the starts whose irregular motion is timed, as in the claim on lifetimes
PRINTED = printed("transition-width")["5"]
LEVELS = tuple(printed("r-jump").values())  # of r before the fall and beyond it
OUTLIERS = 20, 22  # between these the paper has three points of large r


@panels.draws(FIGURES)
def fig12(data):
    """a: v_N at the section; b: r; c: mean lifetimes. Against u, without noise."""
    figure, (top, disorder, lifetimes) = panels.page(
        4.05, "a;b;c", sharex=True, height_ratios=(1.3, 1.4, 1.1)
    )
    scan, row = data["n5_density"], {"n_blocks": N_BLOCKS, "noise": 0.0}
    panels.diagrams(scan, [(top, row)], bar="top")
    top.set_ylabel(panels.VELOCITY)
    panels.remark(top, panels.section_name(sections.cut(scan, **row)))
    _disorder(disorder, data)
    _lifetimes(lifetimes, data)
    lifetimes.set(xlabel=panels.BELT_VELOCITY, ylabel=r"$\tau$", xlim=(0, None))
    figure.align_ylabels()
    return figure


def _disorder(axes, data):
    """r of the row, over runs from other starts and their fall, under r by the other integrator."""
    starts = data.get("n5_replicates_check")
    if starts is not None:
        look = {"color": style.GREEN, "markersize": 3.4, "markerfacecolor": "none", "zorder": 3}
        points = (starts.arrays[name] for name in ("belt_velocity", "disorder_parameter"))
        axes.plot(*points, "o", label="other starts", **look)
    for name, label, look in (
        ("n5_density", "as in the paper", {"color": style.BLUE, "markersize": 1.2}),
        ("n5_rows_check", "exact motion", {"color": style.ORANGE, "marker": "x", "markersize": 3}),
    ):
        if name in data:
            row = sections.cut(data[name], n_blocks=N_BLOCKS, noise=0.0)
            points = row["belt_velocity"], row["disorder_parameter"]
            axes.plot(*points, **{"marker": ".", "linestyle": "none", "label": label} | look)
    panels.finish_curves(axes, xlabel="", handlelength=0.6, markerscale=1.6)
    panels.make_room(axes, above=0.34)
    axes.set_yticks((0.05, 0.1, *LEVELS))
    for level in LEVELS:
        axes.axhline(level, color="0.8", linewidth=0.6, zorder=0)
    look = {"transform": axes.transAxes, "ha": "right", "va": "center"}
    axes.text(0.99, 0.66, "not in the paper: large $r$ again", **look)
    if starts is not None:
        _mark_transition(axes, _fall(starts))
    panels.printed_range(axes, *OUTLIERS, "outliers")
    axes.axvline(printed("u-critical"), **style.PAPER, zorder=0)
    panels.printed_range(axes, *PRINTED, "paper: fall, $u_c$", left=True)


@panels.reduced
def _fall(scan):
    fall = measure.fall(scan, N_BLOCKS, 0.0)
    return {name: fall[name].value for name in ("lower", "critical", "upper")}


def _mark_transition(axes, fall):
    lower, critical, upper = (fall[name] for name in ("lower", "critical", "upper"))
    if np.isnan(critical):
        return
    region = axes.axvspan(lower, upper, color="0.9", linewidth=0, zorder=0)
    line = axes.axvline(critical, **style.HERE | {"linewidth": 0.8, "zorder": 0})
    words = f"here: {lower:.1f} to {upper:.1f}, $u_c$ = {critical:.1f}"
    panels.shows(region, "u-critical", "lower", "upper")
    panels.shows(line, "u-critical", "critical")
    text = panels.beside(axes, PRINTED[1], 0.83, words, color=style.VERMILION)
    panels.shows(text, "u-critical", "lower", "upper", "critical")


def _lifetimes(axes, data):
    exact = {"label": "time irregular, exact", "color": style.BLUE, "marker": "o"}
    scheme = {"label": "to last stick, scheme", "color": style.VERMILION, "marker": "s"}
    for ends_of, look in (
        (lambda: measure.until_settled(data["survival"], SPREAD), exact),
        (lambda: measure.until_last_stick(data["lifetimes_wide"]), scheme),
    ):
        place, *numbers = _means(ends_of)
        look |= {"markersize": 2.2, "elinewidth": 0.8}
        panels.intervals_or_limits(axes, place, *numbers, **look)
    if not axes.containers:
        panels.note(axes, "no run of the lifetimes lasts")
        return
    axes.set_yscale("log")
    low, high = np.log10(axes.get_ylim())
    decades = np.arange(np.ceil(low), np.ceil(high))
    # above the scale, since it is infinite
    beyond = 10 ** (np.ceil(high) + 0.8)
    axes.axhline(10 ** np.ceil(high), color=style.BLACK, linewidth=0.6)
    axes.set_yticks(
        [*10**decades, beyond], [*(f"$10^{{{one:g}}}$" for one in decades), r"$\infty$"]
    )
    axes.minorticks_off()
    axes.set_ylim(10**low, 10 ** (np.ceil(high) + 1.6))
    axes.plot((0, PRINTED[1]), (beyond, beyond), "-", color=style.BLACK, linewidth=2)
    axes.text(PRINTED[1] + 0.5, beyond, f"paper: grows towards $u = {PRINTED[1]}$", va="center")
    panels.legend_above(axes)


def _means(ends_of):
    """Belt velocities with a mean lifetime, its value and the ends of its interval."""
    rows = []
    with suppress(NotEnoughDataError):
        ends = ends_of()
        for place in np.unique(ends.belt_velocity):
            with suppress(NotEnoughDataError):
                lifetime = ends.mean(place, place)
                if lifetime.low > 0:
                    rows.append((place, *lifetime.numbers))
    return np.array(rows).reshape(-1, 4).T


# --- Not in the paper as a figure: the critical velocity against the number of blocks ------------

NOISES = (0.0, 1.0)  # the paper prints regions for the latter


@panels.draws(FIGURES)
def critical_velocity(data):
    """u_c and the region of the fall for each N, a panel for each noise, and printed regions."""
    table = data["critical_velocities"]
    regions = {int(n): ends for n, ends in printed("transition-width").items()}
    figure, grid = panels.page(3.2, "a;b", sharex=True)
    for axes, noise in zip(grid, NOISES, strict=True):
        rows = panels.independent_falls(table, "noise", noise)
        panels.falls(axes, rows, "n_blocks", style.colour_of_size, regions if noise else {})
        axes.set_ylabel(rf"$N$ at $\sigma = {noise:g}$")
        if rows.empty:
            panels.note(axes, "no fall, or too few points")
    grid[0].set_xlim(left=0)
    return figure

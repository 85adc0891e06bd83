"""Fig. 17: natural distribution over belt velocity."""

import numpy as np
from matplotlib.colors import LogNorm

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.noise import measure
from beltrepro.stats import intermittency, sections

FIGURE = Figure(uses=("n5_rows",), number="17")

NOISES = (0.0, 1.0, 5.0, 10.0)
BINS = 120
FOOT = 0.04  # height of the marks, as a share of the panel
DECADES = 3  # range of the colours below the largest density, at most


@style.styled
def draw(data):
    """Density of v_N at the section for each u, on the plane (u, v_N), a panel per noise level."""
    panels.require(data, FIGURE)
    rows = {s: sections.rows(data["n5_rows"], n_blocks=5, noise=s) for s in NOISES}
    span = _span(rows.values())
    figure = style.page(4.0)
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    maps = {
        noise: measure.velocity_density(row, bins=BINS, range=span)
        for noise, row in rows.items()
        if np.isfinite(row["section_velocity"]).any()
    }
    norm, extend = _colours([density for _, _, density in maps.values()])
    image = None
    for axes, mark, noise in zip(grid.flat, "abcd", NOISES, strict=True):
        panels.letter(axes, mark)
        axes.set_title(rf"$\sigma = {noise:g}$")
        if noise not in maps:
            panels.note(axes, "no crossing of the section at this noise in this scan")
            continue
        u_edges, v_edges, share = maps[noise]
        axes.set_facecolor("0.93")
        image = axes.pcolormesh(
            u_edges, v_edges, np.where(share > 0, share, np.nan), norm=norm, rasterized=True
        )
        _marks(axes, rows[noise], span)
    for axes in grid[-1]:
        axes.set_xlabel(panels.BELT_VELOCITY)
    for axes in grid[:, 0]:
        axes.set_ylabel(panels.VELOCITY)
    if image is not None:
        bar = figure.colorbar(
            image, ax=grid, pad=0.02, aspect=40, extend=extend, location="bottom", format="%g"
        )
        bar.minorticks_off()
        bar.set_label("density of $v_N$ at given $u$")
    return figure


def _marks(axes, row, span):
    """At the foot of each u: whether the last block slips on, or both motions take turns."""
    low, high = intermittency.LAMINAR_SHARE
    share = sections.spread(row["belt_velocity"], row["laminar_fraction"])
    foot = span[0] - FOOT / 2 * (span[1] - span[0])
    for chosen, colour in (
        (share.mean > high, style.BLUE),
        ((share.mean >= low) & (share.mean <= high), style.ORANGE),
    ):
        if chosen.any():
            places = share.place[chosen]
            axes.plot(places, np.full(places.size, foot), "|", color=colour, markersize=5)
    axes.set_ylim(span[0] - FOOT * (span[1] - span[0]), span[1])


def _span(rows):
    """Range of v_N that holds all section velocities of these rows."""
    values = np.concatenate([row["section_velocity"].ravel() for row in rows])
    return float(np.floor(min(values[np.isfinite(values)], default=-1.0))), 0.0


def _colours(densities):
    """(norm, extend): logarithmic colours for all panels, and whether some densities lie below."""
    positive = np.concatenate([density[density > 0] for density in densities] or [np.ones(1)])
    lowest = max(positive.min(), positive.max() / 10**DECADES)
    return LogNorm(lowest, positive.max()), "min" if positive.min() < lowest else "neither"

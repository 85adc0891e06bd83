"""Fig. 16: noise-induced intermittency."""

import numpy as np

from beltrepro.replication.drawing import alternation, panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.stats import sections

FIGURE = Figure(uses=("u17", "u19", "n5_replicates"), number="16")

SHOWN = 60000.0  # length of the part of a series that is drawn
VELOCITIES = (13.7, 24.3)  # shown in e


@style.styled
def draw(data):
    """a, b: x_N(t); c, d: spectra after the transient; e: share of laminar phases against u."""
    panels.require(data, FIGURE)
    scan = data["n5_replicates"]
    laminar_time = scan.attributes["laminar_time"]
    figure = style.page(5.2)
    places = figure.subplot_mosaic([["a", "a"], ["b", "b"], ["c", "d"], ["e", "e"]])
    for mark, axes in places.items():
        panels.letter(axes, mark)
    below = places["e"]
    for mark, spectrum, name in (("a", "c", "u17"), ("b", "d", "u19")):
        series = data[name]
        window = alternation.half_laminar(series, laminar_time, SHOWN)
        alternation.trace(places[mark], series, laminar_time, window)
        places[mark].set_xlabel(panels.TIME)
        places[mark].locator_params(axis="x", nbins=5)
        panels.spectrum(places[spectrum], series)
        velocity = series.attributes["belt_velocity"]
        panels.remark(places[spectrum], f"$u = {velocity:g}$")
        below.axvline(velocity, color="0.4", linewidth=0.8, linestyle="--")
    noise = data["u17"].attributes["noise"]
    row = sections.rows(scan, n_blocks=5, noise=noise)
    share = row["belt_velocity"], row["laminar_fraction"]
    replicate_panels.draw_runs(below, *share, 0, apart=np.inf)
    below.set(xlabel=panels.BELT_VELOCITY, ylabel="laminar share", ylim=(-0.05, 1.05))
    below.set_xlim(*VELOCITIES)
    if not below.has_data() or not row["noise"].size:
        panels.note(below, "no run at this noise")
    panels.remark(below, rf"$\sigma = {noise:g}$")
    return figure

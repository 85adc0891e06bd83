"""Fig. 16: noise-induced intermittency."""

from beltrepro.replication.drawing import alternation, panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.stats import sections

FIGURE = Figure(
    title="Noise-induced intermittency at sigma = 2.2, with power spectra.",
    uses=("u17", "u19", "n5_replicates"),
    words=(
        "With noise, in the transition region, the last block alternates between long quiet "
        "stretches and bursts of large swings, as in the experiment. a: the belt velocity of the "
        "paper, which lies at the edge of the region. b: the critical velocity that it prints for "
        "this noise. Shaded: laminar phases, that is, slips of the last block longer than 200. "
        "c: the share of time that they take, in runs from starts of their own."
    ),
    alt=(
        "Five panels: two traces of the position of the last block, quiet stretches between bursts "
        "shaded, each with its spectrum; below, the share of quiet time, from 0 to 1, against u."
    ),
    number="16",
)

SHOWN = 10000.0  # last part of the series that is drawn
VELOCITIES = (14.0, 24.0)  # shown in c


@style.styled
def draw(data):
    """a, b: x_N(t) and the spectrum after the transient; c: share of laminar phases against u."""
    panels.require(data, FIGURE)
    scan = data["n5_replicates"]
    laminar_time = scan.attributes["laminar_time"]
    figure = style.page(6.2)
    mosaic = [["a", "A"], ["b", "B"], ["c", "c"]]
    places = figure.subplot_mosaic(mosaic, width_ratios=(2.2, 1), height_ratios=(1, 1, 0.9))
    below = places["c"]
    for mark, name in (("a", "u17"), ("b", "u19")):
        series = data[name]
        stop = float(series.attributes["duration"])
        start = max(stop - SHOWN, float(series.attributes["transient"]))
        panels.letter(places[mark], mark)
        alternation.trace(places[mark], series, laminar_time, (start, stop))
        panels.spectrum(places[mark.upper()], series)
        below.axvline(
            series.attributes["belt_velocity"], color="0.4", linewidth=0.9, linestyle="--"
        )
    places["b"].set_xlabel(panels.TIME)
    panels.letter(below, "c")
    noise = data["u17"].attributes["noise"]
    row = sections.rows(scan, n_blocks=5, noise=noise)
    replicate_panels.band(below, row["belt_velocity"], row["laminar_fraction"], 0, runs=style.BLACK)
    below.set(xlabel=panels.BELT_VELOCITY, ylabel="laminar share", ylim=(-0.05, 1.05))
    below.set_xlim(*VELOCITIES)
    if not below.has_data() or not row["noise"].size:
        panels.note(below, "no run at this noise")
    panels.remark(
        below, rf"$\sigma = {noise:g}$; dots: runs; {replicate_panels.WORDS}; dashed: a, b"
    )
    return figure

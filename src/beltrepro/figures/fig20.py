"""Fig. 20: ten blocks in their transition region."""

from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Intermittency of ten blocks without noise, at four belt velocities.",
    uses=("n10_u28", "n10_u31", "n10_u34", "n10_u38"),
    words=(
        "Ten blocks without noise at four belt velocities in their transition region: quiet "
        "stretches, longer and longer as the belt runs faster."
    ),
    alt=(
        "Four panels of position of the last of ten blocks against time, with quiet stretches "
        "that lengthen from one panel to the next."
    ),
    number="20",
)

SHOWN = 10000.0  # first part after the transient that is drawn


@style.styled
def draw(data, caption):
    """x_N(t) after the transient, a panel for each belt velocity."""
    panels.require(data, ENTRY)
    every = sorted(
        (data[name] for name in ENTRY.uses), key=lambda one: one.attributes["belt_velocity"]
    )
    figure = style.page(caption, 5.4)
    stack = figure.subplots(len(every), 1, sharex=True, sharey=True)
    for axes, series in zip(stack, every, strict=True):
        time, position, _ = panels.last_block(series)
        start = series.attributes["transient"]
        shown = (time >= start) & (time <= start + SHOWN)
        panels.trace(axes, time[shown] - start, position[shown], ylabel=panels.POSITION)
        axes.set_title(f"$u = {series.attributes['belt_velocity']:g}$", loc="left")
    stack[-1].set_xlabel(r"$t - t_{\rm trans}$")
    return figure

"""Fig. 20: ten blocks in their transition region."""

from beltrepro.figures import panels, style

TITLE = "Intermittency of ten blocks without noise, at four belt velocities."
USES = {
    "n10_u28": "series N = 10, u = 28, sigma = 0",
    "n10_u31": "series N = 10, u = 31, sigma = 0",
    "n10_u34": "series N = 10, u = 34, sigma = 0",
    "n10_u38": "series N = 10, u = 38, sigma = 0",
}

SHOWN = 10000.0  # first part after the transient that is drawn


@style.styled
def draw(data, caption):
    """x_N(t) after the transient, a panel for each belt velocity."""
    panels.require(data, USES)
    every = sorted((data[name] for name in USES), key=lambda one: one.attributes["belt_velocity"])
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

"""Colours of the window: a dark room, in which only the top of the last block is white."""

from typing import Any

from matplotlib.colors import LinearSegmentedColormap

# Okabe and Ito's palette: distinct for colour-blind readers.
STUCK, SLIPPING = "#56b4e9", "#e69f00"
ROOM, BELT, BELT_MARKS = "#0d0f12", "#24282d", "#33383e"
BLOCK, LAST_BLOCK = "#000000", "#ffffff"
TEXT, SOFT, LINE = "#d5d9de", "#8f979f", "#4a5057"
# compressed violet, stretched green: also distinct, and never as dark as the belt
SPRINGS = LinearSegmentedColormap.from_list("springs", ("#b57bff", "#e8e8e8", "#22c48b"))

STYLE: list[Any] = [
    "default",
    {
        "figure.facecolor": ROOM,
        "axes.facecolor": ROOM,
        "axes.edgecolor": LINE,
        "axes.labelcolor": TEXT,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "#1f2429",
        "text.color": TEXT,
        "xtick.color": SOFT,
        "ytick.color": SOFT,
        "xtick.labelsize": 9,
        "ytick.labelsize": 9,
        "font.size": 10,
        "lines.linewidth": 1.2,
    },
]
"""For `matplotlib.style.context`."""

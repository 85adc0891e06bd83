"""Fig. 6: force of a spring against its deformation."""

import numpy as np

from beltrepro.model.parameters import ChainParameters
from beltrepro.model.spring import spring_force
from beltrepro.replication.drawing import style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(uses=(), number="6")

RANGE = (-36.0, 100.0)


@style.styled
def draw(data):
    """Spring force of Eq. 2 with the paper's constants, beside Hooke's law; shows no data."""
    constants = ChainParameters(n_blocks=1, belt_velocity=1.0)
    limit = constants.linear_limit
    deformation = np.linspace(*RANGE, 1361)
    figure = style.page(2.3)
    axes = figure.subplots()
    axes.axhline(0, color="0.8", linewidth=0.7)
    axes.axvline(0, color="0.8", linewidth=0.7)
    axes.axvspan(-limit, limit, color="0.94", linewidth=0)
    look = {"color": style.VERMILION, "linewidth": 1.3, "label": r"ideal spring, $-\Delta l$"}
    axes.plot(deformation, -deformation, "--", **look)
    look = {"color": style.BLUE, "linewidth": 1.8, "label": "spring of the model"}
    axes.plot(deformation, spring_force(deformation, constants), **look)
    joins = np.array([-limit, limit])
    axes.plot(joins, spring_force(joins, constants), "o", color=style.BLUE, markersize=4.5)
    axes.text(0, 112, "linear", ha="center", color="0.35")
    axes.text(-31.5, 95, f"$b_1 = {constants.compression_rate:g}$", ha="left", color=style.BLUE)
    axes.text(80, -155, f"$b_2 = {constants.extension_rate:g}$", ha="right", color=style.BLUE)
    axes.set(xlim=RANGE, ylim=(-190, 130), xlabel=r"$\Delta l$", ylabel=r"$F_e$")
    axes.legend(loc="upper right")
    return figure

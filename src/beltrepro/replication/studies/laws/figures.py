"""Figs. 6 and 7: the force of a spring, and friction."""

from typing import NamedTuple

import numpy as np
from matplotlib.patches import FancyArrowPatch

from beltrepro.base.errors import require
from beltrepro.model.parameters import ChainParameters
from beltrepro.model.spring import external_force, spring_force
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan import io
from beltrepro.replication.plan.registry import Figure
from beltrepro.simulation import artists

FIGURES = {
    "fig06": Figure(uses=(), number="6"),
    "fig07": Figure(uses=("friction_event",), number="7"),
}


# --- Fig. 6: force of a spring against its deformation --------------------------------------------

RANGE = (-36.0, 100.0)


@panels.draws(FIGURES)
def fig06(data):
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
    along = {"rotation": -45, "transform_rotates_text": True, "rotation_mode": "anchor"}
    axes.text(98, -92, look["label"], color=look["color"], ha="right", **along)
    look = {"color": style.BLUE, "linewidth": 1.8, "label": "spring of the model"}
    axes.plot(deformation, spring_force(deformation, constants), **look)
    axes.text(42, -95, look["label"], color=look["color"], ha="right")
    joins = np.array([-limit, limit])
    axes.plot(joins, spring_force(joins, constants), "o", color=style.BLUE, markersize=4.5)
    axes.text(0, 112, "linear", ha="center", color="0.35")
    axes.text(-31.5, 95, f"$b_1 = {constants.compression_rate:g}$", ha="left", color=style.BLUE)
    axes.text(80, -140, f"$b_2 = {constants.extension_rate:g}$", ha="right", color=style.BLUE)
    axes.set(xlim=RANGE, ylim=(-155, 130), ylabel=artists.label("$F_e$", "force"))
    axes.set_xlabel(artists.label(r"$\Delta l$", "length"))
    return figure


# --- Fig. 7: friction force during one stick-slip event -------------------------------------------


class Event(NamedTuple):
    """One stick-slip event: stuck from `begin`, slipping from `start` to `stop`; block 1-based."""

    block: int
    begin: float
    start: float
    stop: float


@panels.draws(FIGURES)
def fig07(data):
    """Friction force of one block against the resultant spring force on it."""
    series = data["friction_event"]
    figure = style.page(2.6)
    axes = figure.subplots()
    axes.set(xlabel=artists.label("$F_{ex}$", "force"), ylabel=artists.label("$F_f$", "force"))
    axes.axhline(0, color="0.85", linewidth=0.7, zorder=0)
    axes.axvline(0, color="0.85", linewidth=0.7, zorder=0)
    with panels.shortage_on(axes):
        _draw_event(axes, _forces(series), io.chain(series))
        axes.set_ylim(bottom=axes.get_ylim()[0] - 12)  # for the legend, below zero
        axes.legend(loc="lower left", handlelength=2.4)
    return figure


def _choose_event(series):
    """First slip complete in the series and the stick before, of the last block that has one."""
    events, time = series.arrays["events"], series.arrays["time"]
    for block in range(int(series.attributes["n_blocks"]), 0, -1):
        begin, start = time[0] if time.size else np.nan, None
        for event in events[events["block"] == block]:
            if event["kind"] == "slip":
                start = event["time"]
                continue
            stop = event["time"]
            if start is not None and _sampled(time, begin, start) and _sampled(time, start, stop):
                return Event(block, begin, start, stop)
            begin, start = stop, None
    return None


def _sampled(time, begin, end):
    """Whether a stretch of time holds enough samples to be drawn."""
    return np.searchsorted(time, end) - np.searchsorted(time, begin) >= 10


@panels.reduced
def _forces(series):
    """External force and friction of the event, and whether the block is stuck, in each sample."""
    event = _choose_event(series)
    require(event is not None, "no complete stick-slip event in this series")
    time, column = series.arrays["time"], event.block - 1
    # Samples strictly inside each phase: at the instants themselves either law may hold.
    shown = (time > event.begin) & (time < event.stop) & (time != event.start)
    external = external_force(series.arrays["positions"][shown], io.chain(series))[:, column]
    friction, stuck = series.arrays["friction"][shown, column], time[shown] < event.start
    return {"block": event.block, "external": external, "friction": friction, "stuck": stuck}


def _draw_event(axes, forces, chain):
    external, friction, stuck = (forces[name] for name in ("external", "friction", "stuck"))
    slips = ~stuck
    for phase, label, look in (
        (stuck, "stuck: $F_f = -F_{ex}$", {"color": style.BLUE, "lw": 3.2, "dashes": (2.2, 1.1)}),
        (slips, "slipping: $F_f = f_s F_{st}$", {"color": style.VERMILION, "lw": 0.5}),
    ):
        axes.plot(external[phase], friction[phase], label=label, rasterized=True, **look)
    kinetic = float(np.mean(friction[slips]))
    first, last = external[slips][[0, -1]]
    _sudden_change(axes, (first, friction[stuck][-1]), (first, kinetic))
    _sudden_change(axes, (last, kinetic), (last, -last))
    axes.scatter(last, -last, 16, color=style.BLUE, zorder=5)
    axes.annotate("sticks\nagain", (last, -last), (-8, -9), textcoords="offset points", ha="right")
    axes.plot([], [], "--", color=style.GREY, linewidth=1.6, label="sudden change")
    axes.margins(0.08)
    axes.autoscale_view()
    _draw_level(axes, chain.static_friction, "$F_{st_0}$")
    _draw_level(axes, chain.friction_ratio * chain.static_friction, "$f_s F_{st_0}$")
    deviation = f"deviation {np.std(friction[slips]):.2f}"
    deviation += rf" ($f_s \sigma$ = {chain.friction_ratio * chain.noise:.2f})"
    panels.remark(axes, f"block {forces['block']} of {chain.n_blocks}; while slipping {deviation}")


def _draw_level(axes, level, text):
    axes.axhline(level, color="0.6", linewidth=0.8, linestyle=":", zorder=0)
    place = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
    look = {"ha": "right", "va": "top", "color": "0.35"}
    axes.annotate(text, (0.88, level), xytext=(-4, -3), **place, **look)


def _sudden_change(axes, begin, end):
    arrow = {"arrowstyle": "-|>", "mutation_scale": 12, "shrinkA": 0, "shrinkB": 0}
    look = {"linestyle": "--", "linewidth": 1.6, "color": style.GREY, "zorder": 4}
    axes.add_patch(FancyArrowPatch(begin, end, **arrow, **look))

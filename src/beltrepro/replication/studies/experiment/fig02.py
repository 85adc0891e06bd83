"""Fig. 2: snapshot of the experiment."""

from functools import partial

from beltrepro.model.units import to_si
from beltrepro.replication.camera.scene import Scene
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.experiment import filmed

FIGURE = Figure(uses=("belt_028", "belt_028_film", "belt_028_track"), number="2")


@style.styled
def draw(data):
    """The first frame of the film, with the names of its parts."""
    panels.require(data, FIGURE)
    run = data["belt_028"]
    picture = next(data["belt_028_film"]()).picture
    figure = style.page(1.25)
    filmed.mark(figure)
    axes = figure.subplots()
    height, width = picture.shape
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    places = to_si(run.arrays["positions"], "length")
    if len(places):
        _name_parts(axes, partial(filmed.pixel, data["belt_028_track"]), places[0])
    else:
        panels.note(axes, "no samples")
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height + 55, -60), xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    return figure


def _name_parts(axes, pixel, blocks_m):
    """Blocks are named above the picture, what else there is below it."""
    scene = Scene()
    half = scene.block_width / 2
    for number, place in enumerate(blocks_m, 1):
        # a long word beside another would run into it: only the first has room
        words = {1: "block 1", len(blocks_m): f"{number}, white"}.get(number, f"{number}")
        _point(axes, words, pixel(place, -half), -35)
    tape = half + scene.tape_gap + scene.tape_width / 2
    _point(axes, "fixed point", pixel(0.0, half / 2), 35, align="left")
    _point(axes, "tape measure", pixel(0.45, tape), 35)
    middle = (blocks_m[-2] + blocks_m[-1]) / 2
    _point(axes, "spring", pixel(middle, scene.spring_width / 2), 35)
    begin, end = pixel(blocks_m[-1] + 0.06), pixel(blocks_m[-1] + 0.16)
    arrow = {"arrowstyle": "-|>", "color": style.ORANGE, "linewidth": 1.6}
    axes.annotate("", end, begin, arrowprops=arrow)
    axes.annotate("belt, $u$", begin, (0, 4), textcoords="offset points", color=style.ORANGE)


def _point(axes, words, place, beyond, *, align="center"):
    """Words above (beyond < 0) or below the picture, with a line to a place in it."""
    height = axes.images[0].get_array().shape[0]
    outside = beyond if beyond < 0 else height + beyond
    line = {"arrowstyle": "-", "color": style.SKY, "linewidth": 0.8}
    look = {"ha": align, "va": "center"}
    axes.annotate(words, place, (place[0], outside), arrowprops=line, **look)

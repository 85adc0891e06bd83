"""An animated picture of a chain on its periodic orbit.

python docs/static/chain.py docs/static/chain.svg
"""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

from beltrepro import ChainParameters, periodic_orbit, simulate

SECONDS = 0.0765  # of a unit of model time
WIDTH, LEFT, SCALE = 760, 30, 0.82  # pixels, pixels, pixels for a unit of length
BELT, BLOCK, HEIGHT = 70, 26, 250  # heights in pixels: middle of the belt, block, picture
TRACE = 150, 230  # top and foot of the curve of x_N(t)

STYLE = """
.ink { stroke: #333; fill: none; } .dot { fill: #d55e00; }
text { fill: #333; font: 13px sans-serif; }
.belt { fill: #ece7df; } .mark { fill: #d9d0c3; }
@media (prefers-color-scheme: dark) {
  .ink { stroke: #ddd; } text { fill: #ddd; } .belt { fill: #2b2d31; } .mark { fill: #3b3e44; }
}
"""


def listed(values):
    """Numbers as SVG wants them."""
    return ";".join(f"{value:.1f}".rstrip("0").rstrip(".") for value in values)


def animated(kind, values, seconds, **more):
    """An SVG element that runs through the values in so many seconds, again and again."""
    name, what = (
        ("animateTransform", f' type="{kind}"')
        if kind in ("translate", "scale")
        else ("animate", "")
    )
    attribute = "transform" if what else kind
    rest = "".join(f' {key}="{value}"' for key, value in more.items())
    return (
        f'<{name} attributeName="{attribute}"{what} dur="{seconds:.3f}s" '
        f'repeatCount="indefinite" values="{values}"{rest}/>'
    )


def spring(from_x, to_x, seconds):
    """A zigzag of unit length, moved and stretched."""
    turns = "".join(f"L{0.1 + 0.8 * (k + 0.5) / 16:.3f} {8 if k % 2 else -8} " for k in range(16))
    stretch = ";".join(f"{value:.1f} 1" for value in to_x - from_x)
    return (
        f'<g>{animated("translate", listed(from_x), seconds)}<path class="ink" '
        f'vector-effect="non-scaling-stroke" d="M0 0 L0.1 0 {turns} L0.9 0 L1 0">'
        f"{animated('scale', stretch, seconds)}</path></g>"
    )


def block(x, stuck, seconds):
    """A block: blue while it sticks, orange while it slips."""
    colours = ";".join(np.where(stuck, "#0072b2", "#e69f00"))
    paint = animated("fill", colours, seconds, calcMode="discrete")
    move = animated("translate", listed(x), seconds)
    return (
        f'<rect x="{-BLOCK / 2}" y="{-BLOCK / 2}" width="{BLOCK}" height="{BLOCK}" rx="3">'
        f"{paint}{move}</rect>"
    )


def picture(chain):
    """The SVG of one period of the orbit that the chain ends on, in the time of the experiment."""
    orbit = periodic_orbit(chain, duration=1e5, transient=8e4, initial_spread=0)
    run = simulate(
        chain,
        duration=orbit.period_time,
        method="event",
        initial_state=orbit.state,
        sample_interval=orbit.period_time / 200,
    )
    seconds = orbit.period_time * SECONDS
    x = LEFT + SCALE * np.vstack([run.positions[-1], run.positions])  # closed: begins where it ends
    velocities = np.vstack([run.velocities[-1], run.velocities])
    stuck = np.isclose(velocities, chain.belt_velocity)
    wall = np.full(len(x), float(LEFT))
    ends = [wall, *x.T]
    count = round(chain.belt_velocity * orbit.period_time / 60)
    step = (
        SCALE * chain.belt_velocity * orbit.period_time / count
    )  # pixels between marks on the belt
    marks = "".join(
        f'<rect class="mark" x="{LEFT + k * step:.1f}" y="{BELT - 30}" '
        f'width="{step / 2:.1f}" height="60"/>'
        for k in range(-1, int(WIDTH / step) + 1)
    )
    top, foot = TRACE
    belt = f'x="{LEFT}" y="{BELT - 30}" width="{WIDTH - 2 * LEFT}" height="60"'
    last = x[:, -1]
    height = foot - (last - last.min()) / np.ptp(last) * (foot - top)
    time = np.linspace(LEFT, WIDTH - LEFT, len(last))
    curve = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(time, height, strict=True))
    dot = animated("cx", listed(time), seconds) + animated("cy", listed(height), seconds)
    springs = "".join(spring(a, b, seconds) for a, b in pairwise(ends))
    blocks = "".join(block(a, s, seconds) for a, s in zip(x.T, stuck.T, strict=True))
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">
<title>A chain of {chain.n_blocks} blocks on a belt that moves to the right</title>
<style>{STYLE}</style>
<clipPath id="belt"><rect {belt}/></clipPath>
<g clip-path="url(#belt)"><rect class="belt" {belt}/>
<g>{animated("translate", listed([0, step]), seconds / count)}{marks}</g></g>
<path class="ink" stroke-width="3" d="M{LEFT} {BELT - 32} V{BELT + 32}"/>
<g transform="translate(0 {BELT})">{springs}{blocks}</g>
<text x="{LEFT}" y="{top - 12}">position of the last block, {seconds:.1f} s</text>
<text x="{WIDTH - LEFT}" y="26" text-anchor="end"><tspan fill="#0072b2">■</tspan> stuck to the belt
<tspan fill="#e69f00">■</tspan> slips back</text>
<polyline class="ink" points="{curve}"/><circle class="dot" r="5">{dot}</circle></svg>
"""


if __name__ == "__main__":
    Path(*sys.argv[1:] or ["chain.svg"]).write_text(
        picture(ChainParameters(n_blocks=5, belt_velocity=15)), "utf-8"
    )

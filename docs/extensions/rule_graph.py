"""The rules of the workflow as a drawing: what Snakemake says, laid out by igraph, as SVG."""

import re
import subprocess
import sys
from html import escape
from pathlib import Path

import igraph
from docutils import nodes
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).parents[2]
_WIDTH, _HEIGHT, _ACROSS, _DOWN = 84, 28, 100, 62  # of a box; from box to box
_EDGE = 4  # around all


def rules() -> tuple[list[str], list[tuple[int, int]]]:
    """Names of the rules, and the edges between them, from `snakemake --rulegraph`."""
    call = [sys.executable, "-m", "snakemake", "--forceall", "--rulegraph", "--quiet", "all"]
    done = subprocess.run(
        [*call, "--config", "preset=smoke"], cwd=ROOT, capture_output=True, text=True
    )
    names = re.findall(r'^\s*\d+\[label = "(\w+)"', done.stdout, re.M)
    edges = [(int(a), int(b)) for a, b in re.findall(r"(\d+) -> (\d+)", done.stdout)]
    if not names:
        raise RuntimeError(f"snakemake --rulegraph says: {done.stderr[-500:]}")
    return names, edges


def drawing(names: list[str], edges: list[tuple[int, int]]) -> str:
    """An SVG of the graph, from the first rule at the top to the last one."""
    graph = igraph.Graph(len(names), edges, directed=True)
    layout = graph.layout_sugiyama(hgap=_ACROSS, vgap=_DOWN, maxiter=1000)
    places, ways = list(layout), layout.edge_routing
    stops = [place for way in (places, *ways) for place in way]
    left, right = min(x for x, _ in stops), max(x for x, _ in stops)
    bottom = max(y for _, y in places)
    lines = [
        _line([places[begin], *way, places[end]])
        for (begin, end), way in zip(edges, ways, strict=True)
    ]
    boxes = [_box(*place, name) for place, name in zip(places, names, strict=True)]
    corner = f"{left - _WIDTH / 2 - _EDGE:g} {-_HEIGHT / 2 - _EDGE:g}"
    size = f"{right - left + _WIDTH + 2 * _EDGE:g} {bottom + _HEIGHT + 2 * _EDGE:g}"
    words = escape("Rules: " + ", ".join(f"{names[a]} to {names[b]}" for a, b in edges))
    return (
        f'<svg class="rules" viewBox="{corner} {size}" role="img" aria-label="{words}">'
        '<defs><marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8z"/></marker></defs>'
        f"{''.join(lines)}{''.join(boxes)}</svg>"
    )


def _line(way: list) -> str:
    """An arrow through all places of its way, upright at each."""
    (x, y), *others = way
    path = f"M{x:g} {y:g}"
    others[-1] = others[-1][0], others[-1][1] - _HEIGHT / 2
    for to_x, to_y in others:
        middle = (y + to_y) / 2
        path += f"C{x:g} {middle:g} {to_x:g} {middle:g} {to_x:g} {to_y:g}"
        x, y = to_x, to_y
    return f'<path class="edge" d="{path}" marker-end="url(#head)"/>'


def _box(x: float, y: float, name: str) -> str:
    corner = f'x="{x - _WIDTH / 2:g}" y="{y - _HEIGHT / 2:g}"'
    return (
        f'<rect {corner} width="{_WIDTH}" height="{_HEIGHT}" rx="5"/>'
        f'<text x="{x:g}" y="{y:g}">{escape(name)}</text>'
    )


class RuleGraph(SphinxDirective):
    """The drawing in the page."""

    def run(self) -> list[nodes.Node]:
        """Ask Snakemake and draw."""
        for path in (ROOT / "Snakefile", *(ROOT / "workflow/rules").glob("*.smk")):
            self.env.note_dependency(str(path))
        return [nodes.raw("", drawing(*rules()), format="html")]


def setup(app) -> dict:
    """Called by Sphinx."""
    app.add_directive("rule-graph", RuleGraph)
    return {"parallel_read_safe": True}

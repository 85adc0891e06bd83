"""Addresses outside the site are listed, not asked: `external_links.txt` beside the start page."""

from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx


def setup(app: Sphinx) -> dict:
    """Called by Sphinx."""
    found: set[str] = set()

    def collect(app, doctree, docname):
        addresses = (node.get("refuri", "") for node in doctree.findall(nodes.reference))
        found.update(each for each in addresses if "://" in each)

    def write(app, error):
        if error is None and app.builder.format == "html":
            text = "".join(f"{each}\n" for each in sorted(found))
            (Path(app.outdir) / "external_links.txt").write_text(text, encoding="utf-8")

    app.connect("doctree-resolved", collect)
    app.connect("build-finished", write)
    return {"parallel_read_safe": True}

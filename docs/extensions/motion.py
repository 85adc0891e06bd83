"""The live chain of the report in a page of the site."""

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from beltrepro.replication.report.contents import MOTION
from beltrepro.replication.report.material import Material
from beltrepro.replication.report.page import part


class Motion(SphinxDirective):
    """The section of the report with the live chain, as it stands there."""

    def run(self) -> list[nodes.Node]:
        """Its HTML, with its style."""
        return [nodes.raw("", part(MOTION, Material("", {}, {})), format="html")]


def setup(app) -> dict:
    """Called by Sphinx."""
    app.add_directive("motion", Motion)
    return {"parallel_read_safe": True}

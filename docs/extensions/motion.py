"""The player of the report in a page, with runs that are simulated while the site is built."""

from pathlib import Path
from tempfile import TemporaryDirectory

import yaml
from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from beltrepro.replication.plan import files, kinds
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.plan.points import points_of
from beltrepro.replication.report.contents import MOTION
from beltrepro.replication.report.material import Material
from beltrepro.replication.report.page import part

CONFIG = Path(__file__).parents[2] / "config.yaml"


class Motion(SphinxDirective):
    """The section of the report with the player, as it stands there."""

    def run(self) -> list[nodes.Node]:
        """Simulate what the player shows and give its HTML."""
        self.env.note_dependency(str(CONFIG))
        return [nodes.raw("", section(), format="html")]


def section() -> str:
    """The section as HTML, with its data."""
    plan = make_plan(yaml.safe_load(CONFIG.read_text(encoding="utf-8")))
    with TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{name}.h5" for name in MOTION.needs]
        for path in paths:
            _simulate(plan, path)
        return part(MOTION, Material(plan.preset, {}, {"datasets": paths}))


def _simulate(plan, path: Path) -> None:
    """What the job of the workflow does for this dataset, which is a single run."""
    spec = plan.batch_spec(path.stem, 0)
    points = points_of(spec["points"])
    files.write(path, spec, kinds.record(spec["kind"], points, spec["settings"]))


def setup(app) -> dict:
    """Called by Sphinx."""
    app.add_directive("motion", Motion)
    return {"parallel_read_safe": True}

"""The outcome of the Python code of a page: what it prints, and the figure that it saves."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

_CODE = re.compile(r"^```python\n(.*?)^```$", re.M | re.S)


def code(page: Path) -> str:
    """All blocks of Python of a page, one after the other."""
    return "\n".join(_CODE.findall(page.read_text(encoding="utf-8")))


def run(page: Path, folder: Path) -> str:
    """Run the code of a page in a folder, and return what it prints."""
    environment = os.environ | {"MPLBACKEND": "agg"}
    call = [sys.executable, "-W", "error::SyntaxWarning", "-c", code(page)]
    done = subprocess.run(call, cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"the code of {page.name} fails: {done.stderr.strip().splitlines()[-1]}")
    return done.stdout


class Outcome(SphinxDirective):
    """Runs the code of this page and shows what it prints and the figure of this name."""

    required_arguments = 1
    final_argument_whitespace = True
    has_content = True

    def run(self) -> list[nodes.Node]:
        """Run the code and give its outcome; the content of the directive describes the figure."""
        page = Path(self.env.doc2path(self.env.docname))
        folder = Path(self.env.srcdir) / "made"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        printed = run(page, folder)
        image = nodes.image(uri=f"/made/{self.arguments[0]}", alt=" ".join(self.content))
        image["candidates"] = {"*": f"made/{self.arguments[0]}"}
        self.env.images.add_file(self.env.docname, f"made/{self.arguments[0]}")
        return [nodes.literal_block(printed, printed, language="none"), image]


def setup(app) -> dict:
    """Called by Sphinx."""
    app.add_directive("outcome", Outcome)
    return {"parallel_read_safe": True}

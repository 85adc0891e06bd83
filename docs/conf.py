"""How Sphinx builds the site: `make docs`."""

import sys
import warnings
from pathlib import Path

from beltrepro import __version__

sys.path.insert(0, str(Path(__file__).parent))

project = "beltrepro"
author = "beltrepro authors"
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx_argparse_cli",
    "sphinx_gallery.gen_gallery",
    "extensions.api",
    "extensions.claims_and_figures",
    "extensions.configuration",
]
exclude_patterns = ["extensions"]
default_role = "code"
highlight_language = "none"  # of blocks that name no language: many are commands

myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "cookbook",
    "filename_pattern": "",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "capture_repr": (),
    "min_reported_time": 1000,
    "write_computation_times": False,
    "show_signature": False,
}
warnings.formatwarning = lambda words, kind, *_: f"{kind.__name__}: {words}\n"  # of recipes
for written in Path(__file__).parents[1].glob("examples/*.h5"):  # by recipes, in the last build
    written.unlink()

suppress_warnings = ["ref.python"]  # a type of a docstring that several modules have: no link
autodoc_typehints = "none"  # docstrings have the types, with shapes
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

html_theme = "furo"
html_title = "beltrepro"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_copyright = False

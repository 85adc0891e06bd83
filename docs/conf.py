"""How Sphinx builds the site: `make docs`."""

import sys
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
    "extensions.api",
    "extensions.claims_and_figures",
    "extensions.configuration",
]
exclude_patterns = ["extensions"]
default_role = "code"
highlight_language = "none"  # of blocks that name no language: many are commands

myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]

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

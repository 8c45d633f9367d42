"""How the documentation site is built; the command is in CONTRIBUTING.md."""

from __future__ import annotations

import sys
from pathlib import Path

import heyoka_bike

sys.path.insert(0, str(Path(__file__).parent / "_site"))

project = "heyoka_bike"
author = "The heyoka_bike developers"
copyright = "the heyoka_bike developers, MIT license"
version = release = heyoka_bike.__version__

extensions = [
    "myst_nb",  # Markdown, and notebooks, which are run
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_argparse_cli",
    # Of this folder's _site.
    "accessible",
    "beside_pages",
    "mathml",
    "redirects",
    "repository_links",
    "run",
]
exclude_patterns = ["_build", "_site", "examples", "paper"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3  # the anchors that GitHub makes
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300  # of a cell [s]; none takes a tenth of it
nb_merge_streams = True

nitpicky = True
nitpick_ignore_regex = [
    # Types of other projects, whose sites cannot be looked up without a network.
    (r"py:.*", r"(?!heyoka_bike\b).*"),
    # Private fields of dataclasses.
    (r"py:class", r".*\._\w+"),
    # Types that are not among the public names.
    (r"py:class", r"heyoka_bike\.(bicycle\.column\.Column|scoring\.grades\.Grade)"),
    (r"py:class", r"heyoka_bike\.bicycle\.equations\.reduced\.Equations"),
    (r"py:class", r"heyoka_bike\.motion\.trajectory\.Drift"),
    (r"py:class", r"heyoka_bike\.scoring\.(evidence\.\w+|outcomes)\.\w+"),
]
# Words of a shape, "(rows,)", are no references.
suppress_warnings = ["ref.python"]

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "furo"
html_title = "heyoka_bike"
html_static_path = ["_site/static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
# MathML: nothing is loaded from the network.
html_math_renderer = "mathml"
pygments_dark_style = "monokai"

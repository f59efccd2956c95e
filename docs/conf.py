"""How Sphinx builds the site: `make docs` does it, into build/docs/."""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "pinchoff"
author = "pinchoff developers"
copyright = author
version = release = installed_version("pinchoff")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "command_help",
    "formulas",
    "live_model",
    "parameter_table",
]
exclude_patterns = ["_extensions"]
source_suffix = {".md": "markdown"}

myst_enable_extensions = ["amsmath", "attrs_inline", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3

napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say it, with shapes and units

html_theme = "furo"
html_title = f"pinchoff {release}"
html_math_renderer = "formulas"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_search_summary = False  # they are fetched, which a browser refuses for files
html_show_copyright = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#1b6e53", "color-brand-content": "#1b6e53"},
    "dark_css_variables": {"color-brand-primary": "#6fcfae", "color-brand-content": "#6fcfae"},
}

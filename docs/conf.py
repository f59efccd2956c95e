"""How Sphinx builds the site: `make docs` does it, into build/docs/."""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

from sphinx.ext import autosummary

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "pinchoff"
author = "pinchoff developers"
copyright = author
version = release = installed_version("pinchoff")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "command_help",
    "formulas",
    "live_model",
    "parameter_table",
]
exclude_patterns = [
    "_extensions",
    "_templates",
    "gallery/*.py",
    "gallery/*.ipynb",
    "**/sg_execution_times.rst",
    "sg_execution_times.rst",
]
templates_path = ["_templates"]
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".ipynb": "myst-nb"}

myst_enable_extensions = ["amsmath", "attrs_inline", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3

# The notebooks hold no outputs: they are run whenever the site is built.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_execution_show_tb = True

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "within_subsection_order": "gallery.order",
    "image_scrapers": ("gallery.pictures",),
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1e6,
    "abort_on_example_error": True,
    "capture_repr": ("_repr_html_",),
    "download_all_examples": False,
}

copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
autosummary_generate = True
autosummary.WELL_KNOWN_ABBREVIATIONS += ("eq.", "eqs.")  # they end no sentence
autosummary_filename_map = {"pinchoff.Boundary": "pinchoff.Boundary-class"}  # beside boundary
suppress_warnings = ["ref.python"]  # attributes of several classes have one name
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

"""The documentation site: pages in Markdown, notebooks among them, the reference from docstrings and help.

`make docs-pages` builds the pages alone. `make docs` runs every notebook and every `command` first, so that
no output or picture on a page is older than the code that makes it.
"""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

project = "noctule"
author = "the noctule maintainers"
version = release = version_of("noctule")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx_copybutton",
    "sphinx_design",
    "_extension.mathml",
    "_extension.command",
    "_extension.gallery",
    "_extension.reference",
    "_extension.rows",
    "_extension.units",
    "_extension.error_tree",
    "_extension.file_fields",
    "_extension.json_keys",
    "_extension.names",
    "_extension.navigation",
    "_extension.nir",
    "_extension.places",
    "sphinx.ext.napoleon",  # after ours, which see docstrings as they were written
]
exclude_patterns = ["_extension"]

html_theme = "furo"
html_title = "noctule"
html_static_path = ["_static"]
html_css_files = ["noctule.css"]
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_math_renderer = "mathml"  # a browser's own: no script and nothing from the network

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
copybutton_prompt_text = "$ "

# A notebook that fails or takes longer than this fails the build.
nb_execution_mode = "off"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True
nb_execution_in_temp = True  # what a notebook writes is not left beside the pages

napoleon_google_docstring = False
napoleon_custom_sections = [("Attributes", "params_style")]
suppress_warnings = ["ref.python"]  # two robots have a `Run`: the text says which is meant
autodoc_type_aliases = {
    name: name for name in ("F64", "F32", "C128", "I64", "I32", "I8", "Bools", "Polyline")
}
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 90
default_role = "code"  # in docstrings a name in single backticks is code

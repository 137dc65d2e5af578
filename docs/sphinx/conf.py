"""How `make docs` turns the Markdown pages and the docstrings into a site.

The source folder is the top of the repository, so that links between README, docs/ and the other
pages hold as they are written, here and where a Git server shows the files.
"""

# ruff: noqa: E402
import sys
from pathlib import Path

from sphinx.application import Sphinx

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from contents import add_contents
from docstrings import escape_docstring, restore_docstring, shorten_signature

import fenics_defo
import fenics_defo.fem.compat  # MPI must load before autodoc imports what loads DOLFINx

# autodoc finds what a package has, not what it would load when asked.
for subpackage in fenics_defo.__all__[1:]:
    package = getattr(fenics_defo, subpackage)
    for name in getattr(package, "__all__", ()):
        setattr(package, name, getattr(package, name))

project = "fenics_defo"
author = "the authors of fenics_defo"
version = release = fenics_defo.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "docs/index"
include_patterns = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "docs/**.md",
    "meshes/README.md",
    "scenes/README.md",
]
# A folder is only left out of the walk if it is named here; tests/ and workflows/ are quick.
exclude_patterns = ["docs/_build", ".*", "build", "demo", "dist"]

# Blocks without a language are formulas and tables of output.
highlight_language = "none"
# q' and u'' are derivatives.
smartquotes = False
myst_heading_anchors = 3
python_maximum_signature_line_length = 80
toc_object_entries_show_parents = "hide"

autodoc_member_order = "groupwise"
autodoc_typehints_format = "short"
autodoc_default_options = {"members": True}
napoleon_numpy_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = "fenics_defo"
html_static_path = ["static"]
html_css_files = ["pages.css"]
html_extra_path = ["extra"]  # the index.html at the top, which leads to docs/index.html
html_copy_source = False
html_show_copyright = html_show_sphinx = False


def setup(app: Sphinx) -> None:
    """Register what contents.py and docstrings.py do."""
    app.connect("source-read", add_contents)
    # Before napoleon, which turns the sections of a docstring into fields.
    app.connect("autodoc-process-docstring", escape_docstring, priority=400)
    app.connect("autodoc-process-docstring", restore_docstring, priority=600)
    app.connect("autodoc-process-signature", shorten_signature)

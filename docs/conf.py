# SPDX-License-Identifier: MPL-2.0
"""Settings of Sphinx for the documentation site; scripts/docs builds it.

The source folder is the root of the project, so that links between docs/, examples/ and benchmarks/ are the same on the
site and in the files.
"""
import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "docs/_site"))
if os.environ.get("BATTEN_PYTHON"):
    sys.path.insert(0, os.environ["BATTEN_PYTHON"])

project = "Batten"
author = "the Batten authors"
project_copyright = author
version = release = re.search(r"project\(batten VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_copybutton", "sphinxcontrib.bibtex", "batten_site"]
root_doc = "docs/index"
include_patterns = ["docs/**", "examples/*/README.md", "benchmarks/README.md", "CHANGELOG.md", "CONTRIBUTING.md",
                    "CODE_OF_CONDUCT.md", "SECURITY.md"]
exclude_patterns = ["build", ".git", "docs/_site"]
source_suffix = {".md": "markdown"}
nitpicky = True

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 5
bibtex_bibfiles = ["docs/references.bib"]
bibtex_default_style = "batten"

autodoc_member_order = "bysource"
autodoc_typehints = "none"
default_role = "code"  # of docstrings

html_theme = "furo"
html_title = f"Batten {release}"
html_static_path = ["_site/static"]
html_css_files = ["batten.css"]
html_favicon = html_logo = "../cmake/packages/batten-studio.svg"
html_show_sourcelink = False
html_copy_source = False
html_additional_pages = {"index": "redirect.html"}
templates_path = ["_site/templates"]
html_theme_options = {"navigation_with_keys": True, "sidebar_hide_name": False}
pygments_style = "friendly"
pygments_dark_style = "monokai"

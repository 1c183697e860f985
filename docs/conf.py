"""The documentation site: `python -m sphinx -W docs site`, with the packages of the extra `docs`.

Its reference of Python and C++, and its copies of files outside this folder, are written by the modules in
`_site` when a build begins. On a code-hosting site the pages work unchanged; `_site` rewrites their links for
this site.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS))

about = tomllib.loads((DOCS.parent / "pyproject.toml").read_text())["project"]

project = about["name"]
author = "The motes authors"
project_copyright = author
version = release = about["version"]

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "_site.docstrings",
    "_site.files",
    "_site.headers",
    "_site.loops",
    "_site.reference",
]
exclude_patterns = ["_site", "**/.ipynb_checkpoints"]

# Notebooks are shown as they were saved; the tests run them.
nb_execution_mode = "off"
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]

smartquotes_action = "D"  # only dashes: straight quotes mark arguments, as in "xy"
autoclass_content = "both"
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_type_aliases = {name: name for name in ("ArrayLike", "Drawn", "Number", "Vector", "Where")}
python_maximum_signature_line_length = 100
napoleon_use_ivar = True
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = f"{project} {version}"
html_static_path = ["_site/static"]
html_css_files = ["site.css"]
html_copy_source = False

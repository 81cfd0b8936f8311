"""The documentation as a site: ``sphinx-build docs docs/_build/site``, with what the extra ``docs`` brings.

No outside request: formulas are MathML, made while the site is built; the search is in the pages.
"""

import os
import re
import sys
from pathlib import Path
from typing import Any

sys.path[:0] = [str(Path(__file__).resolve().parent / "site")]

import formulas
import gallery
import reference

import cutwise

DOCS = Path(__file__).resolve().parent

project, author = "cutwise", "The cutwise contributors"
version = release = cutwise.__version__
project_copyright = author
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "index"
exclude_patterns = ["_build", "README.md", "site", "**.ipynb_checkpoints"]

myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_in_temp = False
nb_execution_timeout = 600
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(DOCS.parent / "src"), os.environ.get("PYTHONPATH", "")]))
nb_execution_raise_on_error = True
suppress_warnings = [
    "myst.xref_missing",
    "myst.header",
    "misc.highlighting_failure",
]  # links are held by tests/house/test_docs.py

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say them, in words and units
napoleon_google_docstring = False

html_theme = "furo"
html_title = f"cutwise {version}"
html_show_search_summary = False  # else the search asks for pages, which a browser refuses from a disk
html_copy_source = html_show_sourcelink = False
html_math_renderer = "mathml"

_OUTSIDE = re.compile(r"\[([^\]]+)\]\(((?:\.\./)+)((?!how-to|theory|reference|tutorials|pictures)[\w./-]+)(#[\w-]+)?\)")


def _inside_of_the_site(app: Any, name: str, source: list[str]) -> None:
    """Links to files of the repository that are no pages: their name stays, as a place to look."""
    depth = name.count("/")

    def told(found: re.Match[str]) -> str:
        if found[3] == "README.md" and found[2].count("..") == depth:
            return f"[{found[1]}]({found[2]}index.md)"
        inside = found[2].count("..") <= depth
        return found[0] if inside else f"{found[1]} (`{found[3]}`)"

    source[0] = _OUTSIDE.sub(told, source[0])


def _made(app: Any) -> None:
    """Pages that the program knows better."""
    reference.write(DOCS / "generated")
    gallery.write(DOCS / "generated", only=os.environ.get("CUTWISE_GALLERY", ""))


def setup(app: Any) -> None:
    """Formulas, pages that are made, links that leave."""
    formulas.setup(app)
    app.connect("builder-inited", _made)
    app.connect("source-read", _inside_of_the_site)

"""The documentation as a site: complete, its notebook runs, its formulas are drawn, and nothing is asked for from outside."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest
from matplotlib import pyplot

ROOT = Path(__file__).parent.parent.parent
DOCS = ROOT / "docs"
NOTEBOOKS = [
    page for page in sorted((DOCS / "tutorials").glob("*.md")) if "{code-cell}" in page.read_text(encoding="utf-8")
]
_CELL = re.compile(r"^```\{code-cell\} python\n((?::[^\n]*\n)*)(.*?)^```", re.DOTALL | re.MULTILINE)
_ASKS = re.compile(r"<(?:script|link|img|iframe|source)\b[^>]*?\b(?:src|href)=[\"']?(?:https?:)?//", re.IGNORECASE)


def pages():
    """Every page of the documentation but the list for those who read it as files."""
    found = {str(page.relative_to(DOCS).with_suffix("")) for page in DOCS.rglob("*.md")}
    return {
        name for name in found if not name.startswith(("generated/", "_build/")) and name not in ("README", "index")
    }


def test_every_page_is_in_the_contents():
    said = (DOCS / "index.md").read_text(encoding="utf-8")
    named = {
        line.strip() for block in re.findall(r"```\{toctree\}(.*?)```", said, re.DOTALL) for line in block.splitlines()
    }
    reached = {name for name in pages() if name in named or f"{Path(name).parent}/*" in named}
    assert pages() == reached


@pytest.mark.slow
@pytest.mark.parametrize("page", NOTEBOOKS, ids=lambda page: page.stem)
def test_the_cells_of_a_notebook_run(page, tmp_path, monkeypatch):
    """In their order, as a reader would type them; the site runs them once more as a notebook."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    matplotlib.use("agg")
    cells = [body for _, body in _CELL.findall(page.read_text(encoding="utf-8"))]
    assert len(cells) > 3
    exec(compile("\n".join(cells), page.name, "exec"), {"__name__": "__main__"})
    pyplot.close("all")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, with one example in its gallery."""
    for needed in ("sphinx", "furo", "myst_nb"):
        pytest.importorskip(needed, reason="the extra docs is not installed")
    place = tmp_path_factory.mktemp("site")
    for folder in ("docs", "examples"):
        shutil.copytree(
            ROOT / folder, place / folder, ignore=shutil.ignore_patterns("_build", "generated", "__pycache__")
        )
    env = {**os.environ, "CUTWISE_GALLERY": "deburr_compliant_spindle", "PYTHONPATH": str(ROOT / "src")}
    words = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "docs", "out"]
    done = subprocess.run(words, cwd=place, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return place / "out"


@pytest.mark.slow
def test_the_site_is_built_without_a_warning_and_asks_for_nothing(site):
    built = {
        str(page.relative_to(site).with_suffix("")): page.read_text(encoding="utf-8") for page in site.rglob("*.html")
    }
    assert pages() <= built.keys()
    for name, text in built.items():
        assert not _ASKS.search(text), name
    for style in site.rglob("*.css"):
        assert not re.search(r"url\(['\"]?(?:https?:)?//|@import", style.read_text(encoding="utf-8")), style
    assert (site / "searchindex.js").stat().st_size > 50_000


@pytest.mark.slow
def test_formulas_gallery_notebook_and_reference_are_there(site):
    def page(name):
        return (site / f"{name}.html").read_text(encoding="utf-8")

    assert page("theory/cutting").count("<math") > 20
    assert "MathJax" not in page("theory/cutting")
    gallery = page("generated/gallery")
    assert "PASS, but not by every history" in gallery
    assert "<svg" in gallery
    notebook = page("tutorials/notebook")
    assert "Surface error, max" in notebook  # a result as it shows itself
    assert "os.chdir" not in notebook
    assert "cutwise.load" in page("generated/api")
    assert "overrides" in page("generated/api")
    commands = page("generated/commands")
    for name in ("view", "new", "run", "advise"):
        assert f'id="{name}"' in commands
    assert "berselli2016" in page("generated/library")

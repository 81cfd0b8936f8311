"""The documentation tells the truth: its examples run, its links lead somewhere, its tables are up to date."""

import importlib.util
import re
import runpy
import shlex
import shutil
from pathlib import Path
from urllib.parse import unquote

import matplotlib
import pytest
from matplotlib import pyplot

from cutwise.io.scenario import parse
from cutwise.spec.kinds import KINDS
from cutwise.study import review, trials
from cutwise.study.review import reviewed

ROOT = Path(__file__).parent.parent.parent
_MADE = ("generated", "_build")  # by the site, of what is tested already
PAGES = sorted(
    page for page in (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "benchmarks").glob("*.md"))
    if not set(_MADE) & set(page.parts)
)  # fmt: skip
_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
_LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
_COMMAND = re.compile(r"^(?:\$ )?(cutwise .*)$", re.MULTILINE)
_REGISTRY = re.compile(r"/simple/|index-url|--find-links|registry\.", re.IGNORECASE)
_MACHINE = re.compile(r"(?<![\w.])/(?:work|root|home|tmp|opt|Users)/|\b[A-Z]:\\")


def name(page):
    return str(page.relative_to(ROOT))


def blocks(page, *languages):
    return [body for language, body in _BLOCK.findall(page.read_text(encoding="utf-8")) if language in languages]


def commands(page):
    return [command for body in blocks(page, "console", "sh") for command in _COMMAND.findall(body)]


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """An empty folder with the examples in it, to work in."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "src"))  # of processes that a command starts
    matplotlib.use("agg")
    yield tmp_path
    pyplot.close("all")


def load_script(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "python")], ids=name)
def test_python_examples_run(page):
    """The blocks of a page in their order, one after the other as a reader would type them."""
    code = compile("\n".join(blocks(page, "python")), name(page), "exec")
    exec(code, {"__name__": "__main__"})


@pytest.mark.slow
@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize("page", [page for page in PAGES if commands(page)], ids=name)
def test_commands_run(page, cutwise, monkeypatch):
    """Exit code 1, a requirement that fails, is an honest end too.

    The first run of the READ ME is reviewed as it is for everyone; others by three further runs instead of up to a
    hundred, which took nine tenths of the time of this test and went through the same lines. Advice that is given no
    end looks for one in the READ ME, and ends after 20 runs elsewhere.
    """
    reviews = []

    def fewer(result, **given):
        reviews.append(result)
        return reviewed(result, runs=None if page.stem == "README" and len(reviews) == 1 else 3, **given)

    monkeypatch.setattr(review, "reviewed", fewer)
    if page.stem != "README":
        monkeypatch.setattr(trials, "NO_END", trials.Budget(20))
    for command in commands(page):
        said = cutwise(*shlex.split(command)[1:])
        assert said.code in (0, 1), f"{command}\n{said.out}{said.err}"
        assert "Traceback" not in said.err


@pytest.mark.slow
@pytest.mark.parametrize("script", sorted((ROOT / "examples").glob("*.py")), ids=name)
def test_scripts_among_the_examples_run(script, desk, capsys):
    runpy.run_path(str(desk / "examples" / script.name), run_name="__main__")
    assert capsys.readouterr().out.strip()


def test_read_me_has_two_commands_and_ci_runs_the_second():
    first, second = (body.strip() for body in blocks(ROOT / "README.md", "sh"))
    environment, install, run = (part.strip() for part in first.split("&&"))
    assert environment == "python3 -m venv .venv"
    assert run == ".venv/bin/cutwise run examples/deburr_compliant_spindle.yaml"
    assert second == f"{environment} && {install} && .venv/bin/python -m pytest -q -n auto --dist worksteal"
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert install.partition(" ")[2] in ci
    assert ci.rstrip().endswith("-m pytest -q -n auto --dist worksteal")


@pytest.mark.parametrize(
    "text",
    [body for page in PAGES for body in blocks(page, "yaml") if re.search(r"^(process|cell):", body, re.MULTILINE)],
)
def test_scenarios_in_the_documentation_are_scenarios(text):
    assert parse(text).process in KINDS


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    for link in _LINK.findall(_BLOCK.sub("", text)):
        if link.startswith(("http://", "https://", "mailto:")):
            continue
        file, _, anchor = unquote(link).partition("#")
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target), link


def anchors(page):
    """Names of the headings as GitHub makes them."""
    titles = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_no_place_of_one_machine(page):
    text = page.read_text(encoding="utf-8")
    assert not _MACHINE.findall(text)
    assert not _REGISTRY.findall(text)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_tables_are_up_to_date(page):
    """To bring them up to date: python docs/tables.py."""
    text = page.read_text(encoding="utf-8")
    assert load_script(ROOT / "docs" / "tables.py").filled(text) == text


@pytest.mark.parametrize("kind", KINDS)
def test_every_process_has_its_reference(kind):
    """A page of keys and a table of measures, as comments that docs/tables.py fills in."""
    keys = ROOT / "docs" / "reference" / f"scenario-{kind}.md"
    assert f"<!-- table: keys.{kind} -->" in keys.read_text(encoding="utf-8")
    measures = ROOT / "docs" / "reference" / "measures.md"
    assert f"<!-- table: measures.{kind} -->" in measures.read_text(encoding="utf-8")


def test_the_picture_of_the_architecture_is_that_of_the_imports():
    draw = load_script(ROOT / "docs" / "pictures" / "draw.py")
    text = (ROOT / "docs" / "pictures" / "imports.svg").read_text(encoding="utf-8")
    drawn = {tuple(name.split("-")) for name in re.findall(r'id="import-([a-z_]+-[a-z_]+)"', text)}
    assert drawn == draw.needed(draw.imports()), "python docs/pictures/draw.py"
    folders = {path.name for path in (ROOT / "src" / "cutwise").iterdir() if (path / "__init__.py").exists()}
    assert folders - {"library"} <= set(draw.ROOMS)


@pytest.mark.slow
def test_pictures_are_drawn_by_the_program():
    """Every picture has a function that draws it, and what it shows is what the theory page says."""
    draw = load_script(ROOT / "docs" / "pictures" / "draw.py")
    assert set(draw.PICTURES) == {path.name for path in (ROOT / "docs" / "pictures").glob("*.svg")}
    page = (ROOT / "docs/theory/deburring.md").read_text(encoding="utf-8")
    for law in draw.LAWS:
        row = next(line for line in page.splitlines() if line.startswith("|") and f"(`{law}`)" in line and "," in line)
        said = [tuple(float(x) for x in cell.split(",")) for cell in row.strip("|").split("|")[1:]]
        for frequency, (height, mean) in list(zip(draw.FREQUENCIES, said, strict=True))[1:]:
            found = draw.absorbed(frequency, law)
            assert found == pytest.approx((height, mean), abs=1.5e-3), (law, frequency)

"""What is handed on: the wheel holds what a run needs, the source archive what a reader of the code needs, and no more."""

import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest
from ruamel.yaml import YAML

import cutwise

ROOT = Path(__file__).parent.parent.parent
_LEFT = shutil.ignore_patterns(
    ".venv", ".git", "node_modules", "__pycache__", "*.egg-info", "build", "dist", ".*_cache", ".hypothesis", "_build", "generated",
    "cutwise-runs", "*.nbi", "*.nbc",
)  # fmt: skip


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Names in the wheel, and in the source archive without its first folder."""
    pytest.importorskip("setuptools", "69")
    place = tmp_path_factory.mktemp("built")
    shutil.copytree(ROOT, place / "tree", ignore=_LEFT)
    code = "import setuptools.build_meta as b; print(b.build_sdist('../out')); print(b.build_wheel('../out'))"
    done = subprocess.run([sys.executable, "-c", code], cwd=place / "tree", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    (wheel,), (archive,) = (list((place / "out").glob(pattern)) for pattern in ("*.whl", "*.tar.gz"))
    with zipfile.ZipFile(wheel) as file:
        within = {name: file.read(name) for name in file.namelist() if ".dist-info/" in name}
        names = set(file.namelist())
    with tarfile.open(archive) as file:
        sources = {name.partition("/")[2] for name in file.getnames()}
    return names, within, sources


def tracked(*folders):
    """Files of the tree, without what is made of them."""
    found = (file for folder in folders for file in (ROOT / folder).rglob("*") if file.is_file())
    unwanted = {"__pycache__", "node_modules", "_build", "cutwise-runs", "generated"}
    return {
        str(file.relative_to(ROOT)) for file in found
        if not unwanted & set(file.parts) and file.suffix not in (".pyc", ".nbi", ".nbc") and ".egg-info" not in str(file)
    }  # fmt: skip


def test_the_wheel_holds_the_whole_package_and_nothing_else(built):
    names, _, _ = built
    expected = {name.removeprefix("src/") for name in tracked("src")}
    assert {name for name in names if ".dist-info/" not in name} == expected
    for needed in (
        "cutwise/py.typed",
        "cutwise/app/templates/report.html.j2",
        "cutwise/library/spindles/berselli2016.yaml",
    ):
        assert needed in names


def test_the_wheel_says_what_it_is(built):
    _, within, _ = built
    named = {name.rpartition("/")[2]: content.decode() for name, content in within.items()}
    assert "cutwise = cutwise.__main__:main" in named["entry_points.txt"]
    assert f"Version: {cutwise.__version__}\n" in named["METADATA"]
    assert "License-Expression: MIT" in named["METADATA"]
    for needed in ("starlette", "uvicorn", "numba", "pydantic"):
        assert f"Requires-Dist: {needed}" in named["METADATA"]
    assert sum(name.endswith(("LICENSE", "LICENSE.md")) for name in within) == 2


def test_the_source_archive_is_whole(built):
    _, _, sources = built
    folders = [name for name in ("docs", "tests", "examples", "benchmarks", "src", "web") if (ROOT / name).is_dir()]
    assert tracked(*folders) <= sources
    for name in ("CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "Dockerfile", "LICENSE", "README.md", "constraints.txt",
                 "pyproject.toml", ".ci/run"):  # fmt: skip
        assert name in sources
    assert not [
        name for name in sources if "__pycache__" in name or "node_modules" in name or name.endswith((".pyc", ".nbc"))
    ]


def test_the_citation_is_of_this_version():
    said = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert said["cff-version"] == "1.2.0"
    assert str(said["version"]) == cutwise.__version__
    assert (said["license"], said["type"]) == ("MIT", "software")
    assert said["title"]
    assert said["authors"]


def test_the_container_is_slim_and_not_root():
    lines = (ROOT / "Dockerfile").read_text(encoding="utf-8").replace("\\\n", "").splitlines()
    steps = [line.split(None, 1) for line in lines if line and not line.startswith("#")]
    assert steps[0][0] == "FROM"
    assert steps[0][1].endswith("-slim")
    users = [value for step, value in steps if step == "USER"]
    assert users[-1] not in ("root", "0")
    assert steps[-2][1] == '["cutwise"]'
    for step, value in steps:
        if step == "COPY":
            *sources, _ = value.split()
            assert all((ROOT / source).exists() for source in sources)
    allowed = {line[1:] for line in (ROOT / ".dockerignore").read_text().splitlines() if line.startswith("!")}
    copied = {source for step, value in steps if step == "COPY" for source in value.split()[:-1]}
    assert copied == allowed


def test_what_a_contributor_is_told_to_run_is_there():
    said = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for name in (
        ".ci/run",
        "docs/architecture.md",
        "docs/tables.py",
        "tests/golden/regenerate.py",
        "tests/laws/test_pistons.py",
    ):
        assert name in said
        assert (ROOT / name).exists()
